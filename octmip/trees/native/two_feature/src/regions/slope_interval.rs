//! Slope intervals of dual planes.

/// Neighbouring slope intervals of one dual plane, and a lower bound of the cost of a split in any of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SlopeInterval {
    pub(crate) dual_plane: u32,
    /// The first of them, and their number.
    pub(crate) first: u16,
    pub(crate) n_intervals: u16,
    pub(crate) bound: i64,
    /// What a split in any of them saves at most, of the most that the samples can cost (`nodes/gains.rs`).
    pub(crate) gain: i64,
}

/// Neighbouring intervals that are bounded together at first.
pub(crate) const GROUP: u16 = 16;

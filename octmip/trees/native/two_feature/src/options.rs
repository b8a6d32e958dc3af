//! Options of the search.

use crate::switches::Switches;
use octmip_frame::control::Limits;

/// Options of the search.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// When to stop early.
    pub limits: Limits,
    /// Threads; the result does not depend on them.
    pub n_threads: usize,
    /// Trees of this cost and more are of no interest.
    pub known: Option<i64>,
    /// Seed of the first trees' random choices.
    pub seed: u64,
    /// Prunes and bounds that are on.
    pub switches: Switches,
    /// Coefficients become whole numbers of at most this size where some part the samples alike.
    pub whole_coefficients: Option<i64>,
}

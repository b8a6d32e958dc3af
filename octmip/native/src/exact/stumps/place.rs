//! What a stump solver is asked, and what it returns.

use crate::exact::samples::Samples;
use crate::exact::view::View;

/// What is known of the best stump of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stump {
    /// No stump (or leaf) costs less.
    pub lower: i64,
    /// One that costs this much is known.
    pub value: i64,
}

/// A cut that was evaluated: which, and the swing between it and the cut asked for.
#[derive(Debug, Clone, Copy)]
pub struct Neighbour {
    /// Its record, as `both` numbered it; 0: everything right of the cut, 1: everything left.
    pub record: usize,
    /// Swing between.
    pub distance: i64,
}

/// The place of the cut: the first `k` samples of list `f` of `view` are left.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// All samples of the node.
    pub view: &'a View,
    /// Feature of the cut.
    pub f: usize,
    /// Samples left of the cut.
    pub k: usize,
    /// Position of every sample in list `f`.
    pub positions: &'a [u32],
    /// The evaluated cuts before and after.
    pub neighbours: [Neighbour; 2],
    /// Both sides together must cost less for the cut to matter.
    pub target: i64,
}

/// A target that no cost reaches: the stumps are wanted exactly.
pub const NEVER: i64 = i64::MAX;

impl Place<'_> {
    /// Whether a sample is on a side (0 left, 1 right).
    #[inline(always)]
    pub fn is_on(&self, side: usize, sample: u32) -> bool {
        ((self.positions[sample as usize] as usize) < self.k) == (side == 0)
    }

    /// Number of samples on a side.
    pub fn size(&self, side: usize) -> usize {
        if side == 0 { self.k } else { self.view.len - self.k }
    }
}

/// A way to find best stumps.
pub trait Stumps: Send {
    /// Prepare for views that are subsets of this one and not much smaller.
    fn prepare(&mut self, samples: &Samples, view: &View);

    /// What was prepared no longer holds: views that follow are not subsets of it.
    fn forget(&mut self);

    /// Take up a view: the best stump of all its samples.
    fn load(&mut self, samples: &Samples, view: &View) -> Stump;

    /// Gain of a stump on each feature of the view last taken up (`p`).
    fn scores(&self) -> &[i64];

    /// Put the cut back to 0, everything right of it, for another feature.
    fn rewind(&mut self);

    /// Best stumps of both sides, exact unless their bounds reach `close` together.
    fn both(&mut self, samples: &Samples, place: &Place<'_>, close: i64) -> [Stump; 2];

    /// Number of the cut last evaluated.
    fn last_record(&self) -> usize;

    /// Bytes of its tables.
    fn bytes(&self) -> usize;
}

//! Stump solvers: the cut they are asked about, and the stumps they return.

use crate::samples::Samples;
use crate::view::View;

/// Bounds of the best stump of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stump {
    /// No stump (or leaf) costs less.
    pub(crate) lower: i64,
    /// One that costs this much is known.
    pub(crate) value: i64,
}

/// The place of the cut: the first `k` samples of list `f` of `view` are left.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// All samples of the node.
    pub(crate) view: &'a View,
    /// Feature of the cut.
    pub(crate) f: usize,
    /// Samples left of the cut.
    pub(crate) k: usize,
    /// Both sides together must cost less for the cut to matter.
    pub(crate) target: i64,
    /// The side that is a leaf, if one has to be.
    pub(crate) leaf_side: Option<usize>,
    /// Ranks of `f` by sample; none where all samples are right of the cut.
    ranks: &'a [u32],
    /// Least rank right of the cut.
    edge: u32,
}

impl<'a> Place<'a> {
    /// A cut between two values of `f`.
    pub fn new(samples: &'a Samples, view: &'a View, f: usize, k: usize, target: i64) -> Self {
        let ranks = samples.ranks_of(f);
        let edge = ranks[view.list(f)[k] as usize];
        Self { view, f, k, target, leaf_side: None, ranks, edge }
    }

    /// The same with a leaf on a side.
    pub(crate) fn with_leaf(self, leaf_side: Option<usize>) -> Self {
        Self { leaf_side, ..self }
    }

    /// All samples on the right; the stump is wanted exactly.
    pub(crate) fn whole(view: &'a View) -> Self {
        Self { view, f: 0, k: 0, target: i64::MAX, leaf_side: None, ranks: &[], edge: 0 }
    }

    /// Whether a sample is on a side (0 left, 1 right).
    #[inline(always)]
    pub fn is_on(&self, side: usize, sample: u32) -> bool {
        (self.ranks.get(sample as usize).is_some_and(|&rank| rank < self.edge)) == (side == 0)
    }
}

/// Gains of each label on a side of a cut, and its total cost range.
pub(crate) type Sums<'s> = (&'s [i64], i64);

/// A solver for best stumps.
pub(crate) trait StumpSolver: Send {
    /// Prepare for views that are subsets of this one and not much smaller.
    fn prepare(&mut self, samples: &Samples, view: &View);

    /// Forget what was prepared: views that follow are not subsets of it.
    fn forget(&mut self);

    /// Take up a view: the best stump of all its samples.
    fn load(&mut self, samples: &Samples, view: &View) -> Stump;

    /// Gain of a stump on each feature of the view last taken up (`p`).
    fn scores(&self) -> &[i64];

    /// The sums of a side of the cut that was asked about last (or taken up, right).
    fn sums(&self, side: usize) -> Sums<'_>;

    /// No stump of feature `f` gains more on this side of the cut that was asked about last (or taken up, right).
    fn reach(&self, f: usize, side: usize) -> i64;

    /// Put the cut back to 0, everything right of it, for another feature.
    fn rewind(&mut self);

    /// Best stumps of both sides, exact unless their bounds reach `threshold` together.
    fn both(&mut self, samples: &Samples, place: &Place<'_>, threshold: i64) -> [Stump; 2];
}

//! Remaining uncertainty of the best stumps on both sides of a cut.

/// A bucket that may hide a better stump.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Candidate {
    /// Largest gain that it may hide.
    pub(crate) cap: i64,
    /// Its feature.
    pub(crate) feature: usize,
    /// The bucket.
    pub(crate) bucket: usize,
}

/// Bounds of both sides while groups are visited.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sides {
    /// Total cost range of each side.
    pub(crate) total_range: [i64; 2],
    /// Gain of the best leaf.
    pub(crate) leaf: [i64; 2],
    /// Gain of the best stump known.
    pub(crate) best: [i64; 2],
    /// Price of a split.
    pub(crate) penalty: i64,
}

impl Sides {
    /// Cost of a side whose best stump has this gain.
    pub(crate) fn cost(&self, side: usize, gain: i64) -> i64 {
        self.total_range[side] - self.leaf[side].max(gain - self.penalty)
    }

    /// Whether enough is known when the best stumps gain at most `reach`.
    ///
    /// So it is when their cost is `threshold` or more; or `target` or more, and the remaining uncertainty is small
    /// beside what it is above that. Such a cut loses anyway, and the exact cost would rule out only few more
    /// neighbours.
    pub(crate) fn is_closed(&self, reach: [i64; 2], target: i64, threshold: i64) -> bool {
        let lower = self.total([0, 1].map(|side| reach[side].max(self.best[side])));
        lower >= threshold || (lower >= target && 4 * (self.total(self.best) - lower) <= lower - target)
    }

    /// Cost of both sides.
    fn total(&self, gains: [i64; 2]) -> i64 {
        self.cost(0, gains[0]) + self.cost(1, gains[1])
    }
}

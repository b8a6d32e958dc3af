//! What is not yet known of the best stumps on both sides of a cut.

/// A bucket that may hide a better stump.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Candidate {
    /// Largest gain that it may hide.
    pub cap: i64,
    /// Slot of its feature.
    pub slot: usize,
    /// Which.
    pub bucket: usize,
}

/// What is known of both sides while groups are visited.
#[derive(Debug, Clone, Copy)]
pub struct Sides {
    /// Swing of each side.
    pub mass: [i64; 2],
    /// Gain of the best leaf.
    pub leaf: [i64; 2],
    /// Gain of the best stump known.
    pub best: [i64; 2],
    /// Price of a split.
    pub penalty: i64,
}

impl Sides {
    /// Cost of a side whose best stump has this gain.
    pub fn cost(&self, side: usize, gain: i64) -> i64 {
        self.mass[side] - self.leaf[side].max(gain - self.penalty)
    }

    /// Whether enough is known when the best stumps gain at most `reach`: their cost is `close` or more; or `target` or
    /// more, and what is in doubt is small beside what it is above that. Such a cut loses anyway, and the exact
    /// cost would rule out only few more neighbours.
    pub fn is_closed(&self, reach: [i64; 2], target: i64, close: i64) -> bool {
        let lower = self.total([0, 1].map(|side| reach[side].max(self.best[side])));
        lower >= close || (lower >= target && 4 * (self.total(self.best) - lower) <= lower - target)
    }

    /// Cost of both sides.
    fn total(&self, gains: [i64; 2]) -> i64 {
        self.cost(0, gains[0]) + self.cost(1, gains[1])
    }
}

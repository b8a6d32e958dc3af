//! Sloped errors: a target above its prediction costs `up` for each unit between them, one below it `down`.
//!
//! Both slopes are 1 in absolute errors. With `up = q` and `down = 1 - q` they are those of the quantile of level q,
//! here in whole numbers: 9 and 1 for q = 0.9. The best constant of a set has no more than `up / (up + down)` of the
//! weight below it, and no more than the rest above it.

/// What one unit of distance costs, whole numbers above 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slopes {
    /// Of a target above its prediction.
    pub up: f64,
    /// Of a target below its prediction.
    pub down: f64,
}

impl Slopes {
    /// The error of targets so far above their prediction and so far below it, both 0 or more.
    #[inline(always)]
    pub(crate) fn cost(self, below: f64, above: f64) -> f64 {
        self.down * below + self.up * above
    }

    /// The larger error of a target that lies at most so far below its prediction, or so far above it.
    #[inline(always)]
    pub(crate) fn most(self, below: f64, above: f64) -> f64 {
        (self.down * below).max(self.up * above)
    }

    /// Whether a best constant is one with so much of the weight at or below it, or a lower one.
    #[inline(always)]
    pub(crate) fn is_reached(self, weight: f64, total: f64) -> bool {
        (self.up + self.down) * weight >= self.up * total
    }

    /// Whether every best constant is below targets with so much of the weight below them.
    #[inline(always)]
    pub(crate) fn is_passed(self, weight: f64, total: f64) -> bool {
        (self.up + self.down) * weight > self.up * total
    }
}

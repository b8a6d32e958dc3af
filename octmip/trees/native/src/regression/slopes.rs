//! Sloped errors: a target above its prediction costs `up` for each unit between them, one below it `down`.
//!
//! Both slopes are 1 in absolute errors. With `up = q` and `down = 1 - q` they are those of the quantile of level q,
//! here in whole numbers: 9 and 1 for q = 0.9. The best constant of a set has no more than `up / (up + down)` of the
//! weight below it, and no more than the rest above it.

/// What one unit of distance costs: whole numbers above 0 without a common divisor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slopes {
    /// Of a target above its prediction.
    pub up: f64,
    /// Of a target below its prediction.
    pub down: f64,
}

impl Slopes {
    /// Whether both are 1: errors are absolute, and nothing need be multiplied.
    #[inline(always)]
    pub(crate) fn are_even(self) -> bool {
        self.up == self.down
    }

    /// The error of targets so far above their prediction and so far below it, both 0 or more.
    #[inline(always)]
    pub(crate) fn cost(self, below: f64, above: f64) -> f64 {
        if self.are_even() { below + above } else { self.down * below + self.up * above }
    }

    /// The larger error of a target that lies at most so far below its prediction, or so far above it.
    #[inline(always)]
    pub(crate) fn most(self, below: f64, above: f64) -> f64 {
        if self.are_even() { below.max(above) } else { (self.down * below).max(self.up * above) }
    }

    /// Whether a best constant is one with so much of the weight at or below it, or a lower one.
    #[inline(always)]
    pub(crate) fn is_reached(self, weight: f64, total: f64) -> bool {
        if self.are_even() { 2.0 * weight >= total } else { (self.up + self.down) * weight >= self.up * total }
    }

    /// Whether every best constant is below targets with so much of the weight below them.
    #[inline(always)]
    pub(crate) fn is_passed(self, weight: f64, total: f64) -> bool {
        if self.are_even() { 2.0 * weight > total } else { (self.up + self.down) * weight > self.up * total }
    }
}

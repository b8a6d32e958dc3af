//! Sloped errors: a target above its prediction costs `up` for each unit between them, one below it `down`.
//!
//! Both slopes are 1 in absolute errors. With `up = q` and `down = 1 - q` they are those of the quantile of level q,
//! here in whole numbers: 9 and 1 for q = 0.9. The best constant of a set has no more than `up / (up + down)` of the
//! weight below it, and no more than the rest above it. Inner loops are compiled twice, for slopes that are known to be
//! 1 (`EVEN`), by which nothing is multiplied, and for any; both give the same to the last bit.

/// What one unit of distance costs: whole numbers above 0 without a common divisor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slopes {
    /// Of a target above its prediction.
    pub up: f64,
    /// Of a target below its prediction.
    pub down: f64,
}

impl Slopes {
    /// Those of absolute errors.
    const EVEN: Self = Self { up: 1.0, down: 1.0 };

    /// Whether both are 1: errors are absolute.
    pub(crate) fn are_even(self) -> bool {
        self == Self::EVEN
    }

    /// The same as constants where the loop is compiled for even slopes.
    #[inline(always)]
    pub(crate) fn known<const EVEN: bool>(self) -> Self {
        if EVEN { Self::EVEN } else { self }
    }

    /// The error of targets so far above their prediction and so far below it, both 0 or more.
    #[inline(always)]
    pub(crate) fn cost(self, below: f64, above: f64) -> f64 {
        self.down * below + self.up * above
    }

    /// The larger error of a target that lies at most so far below its prediction, or so far above it.
    #[inline(always)]
    pub(crate) fn most(self, below: f64, above: f64) -> f64 {
        let (below, above) = (self.down * below, self.up * above);
        if below > above { below } else { above } // not NaN: one instruction, where `f64::max` is several
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

//! Costs as whole numbers: 64 bits where they fit, else 128.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// A whole-numbered cost.
pub trait Cost:
    Copy
    + Ord
    + Default
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + SubAssign
    + TryFrom<i128>
    + Into<i128>
{
    /// A cost of the exact core's grid, `2^shift` of these units each.
    fn from_grid(cost: i64, shift: u32) -> Self;

    /// The grid's units in this cost, rounded down.
    fn to_grid(self, shift: u32) -> i64;
}

impl Cost for i64 {
    fn from_grid(cost: i64, shift: u32) -> Self {
        cost << shift
    }

    fn to_grid(self, shift: u32) -> i64 {
        self >> shift
    }
}

impl Cost for i128 {
    fn from_grid(cost: i64, shift: u32) -> Self {
        Self::from(cost) << shift
    }

    fn to_grid(self, shift: u32) -> i64 {
        (self >> shift).clamp(Self::from(i64::MIN / 2), Self::from(i64::MAX / 2)) as i64
    }
}

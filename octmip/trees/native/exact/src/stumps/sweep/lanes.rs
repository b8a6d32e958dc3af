//! Numbers of the vector lanes, and their arithmetic lane by lane.

use pulp::bytemuck;

/// A number of a histogram lane.
pub(crate) trait Lane: bytemuck::Pod + Ord + Default + Send {
    /// From a sum that fits (see `stumps::width`).
    fn narrow(value: i64) -> Self;
    /// To a sum.
    fn widen(self) -> i64;
    /// Sum.
    fn plus(self, other: Self) -> Self;
    /// Difference.
    fn minus(self, other: Self) -> Self;
    /// Two numbers side by side: left and right of the cut.
    type Pair: bytemuck::Pod + Default + Send;
    /// The change of a pair when a number moves from right to left.
    fn shift(number: i64) -> Self::Pair;
    /// The change of a pair when the same number moves back.
    fn back(by: Self::Pair) -> Self::Pair;
    /// The change of a pair when the same number enters on the right.
    fn enter(by: Self::Pair) -> Self::Pair;
    /// A pair after a change; both halves stay 0 or more.
    fn change(pair: Self::Pair, by: Self::Pair) -> Self::Pair;
    /// Product, of numbers whose product fits.
    fn times(self, other: Self) -> Self;
    /// Half, rounded down.
    fn half(self) -> Self;
    /// The largest.
    const MAX: Self;
    /// Added to both halves of a pair that holds differences, so that they stay 0 or more: above any total range
    /// that fits.
    const BIAS: Self;
}

macro_rules! lane {
    ($t:ty, $bias:expr, $pair:ty, $shift:expr, $back:expr, $enter:expr, $change:expr) => {
        impl Lane for $t {
            const MAX: Self = <$t>::MAX;
            const BIAS: Self = $bias;
            type Pair = $pair;
            #[inline(always)]
            fn shift(number: i64) -> $pair {
                $shift(number)
            }
            #[inline(always)]
            fn back(by: $pair) -> $pair {
                $back(by)
            }
            #[inline(always)]
            fn enter(by: $pair) -> $pair {
                $enter(by)
            }
            #[inline(always)]
            fn change(pair: $pair, by: $pair) -> $pair {
                $change(pair, by)
            }
            #[inline(always)]
            fn narrow(value: i64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn widen(self) -> i64 {
                self as i64
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            #[inline(always)]
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }
            #[inline(always)]
            fn half(self) -> Self {
                self >> 1
            }
        }
    };
}

// Both halves of a pair move by one addition: left + 2^16 right is an exact integer while both are 0 or more and fit.
const _: () = assert!(cfg!(target_endian = "little"), "pairs are read back half by half, the left one first");
lane!(
    i16,
    1 << 14,
    u32,
    |number: i64| (number as u32).wrapping_sub((number as u32) << 16),
    u32::wrapping_neg,
    |by: u32| by << 16,
    u32::wrapping_add
);
lane!(
    i32,
    1 << 30,
    u64,
    |number: i64| (number as u64).wrapping_sub((number as u64) << 32),
    u64::wrapping_neg,
    |by: u64| by << 32,
    u64::wrapping_add
);
lane!(
    i64,
    0,
    [i64; 2],
    |number: i64| [number, -number],
    |by: [i64; 2]| [by[1], by[0]],
    |by: [i64; 2]| [0, by[0]],
    |pair: [i64; 2], by: [i64; 2]| [pair[0] + by[0], pair[1] + by[1]]
);

/// A number for each lane.
pub(super) type Row<T, const N: usize> = [T; N];

#[inline(always)]
pub(super) fn zip<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>, f: impl Fn(T, T) -> T) -> Row<T, N> {
    let mut out = [T::default(); N];
    for lane in 0..N {
        out[lane] = f(a[lane], b[lane]);
    }
    out
}

#[inline(always)]
pub(super) fn add<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, T::plus)
}

#[inline(always)]
pub(super) fn sub<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, T::minus)
}

#[inline(always)]
pub(super) fn max<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, Ord::max)
}

#[inline(always)]
pub(super) fn min<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, Ord::min)
}

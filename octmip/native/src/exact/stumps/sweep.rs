//! The vector pass over the buckets: gains of stumps at the edges, bounds of those inside.
//!
//! Plain loops over arrays of a fixed width inside `pulp`'s dispatch: the compiler turns them into the widest vectors
//! of the machine at hand. Integer arithmetic, so every width gives the same numbers.

use pulp::{Simd, WithSimd, bytemuck};

mod kinds;

/// A number of a histogram lane.
pub trait Lane: bytemuck::Pod + Ord + Default + Send {
    /// From a sum that fits (see `finder`).
    fn narrow(value: i64) -> Self;
    /// To a sum.
    fn widen(self) -> i64;
    /// Sum.
    fn plus(self, other: Self) -> Self;
    /// Difference.
    fn minus(self, other: Self) -> Self;
    /// Two numbers side by side: left and right of the cut.
    type Pair: bytemuck::Pod + Default + Send;
    /// The change of a pair when an amount moves from right to left.
    fn shift(amount: i64) -> Self::Pair;
    /// The change of a pair when an amount enters on the right.
    fn enter(amount: i64) -> Self::Pair;
    /// A pair after a change; both halves stay 0 or more.
    fn change(pair: Self::Pair, by: Self::Pair) -> Self::Pair;
    /// Product, of numbers whose product fits.
    fn times(self, other: Self) -> Self;
    /// Half, rounded down.
    fn half(self) -> Self;
    /// The largest.
    const MAX: Self;
    /// Added to both halves of a pair that holds differences, so that they stay 0 or more: above any swing that fits.
    const BIAS: Self;
}

macro_rules! lane {
    ($t:ty, $bias:expr, $pair:ty, $shift:expr, $enter:expr, $change:expr) => {
        impl Lane for $t {
            const MAX: Self = <$t>::MAX;
            const BIAS: Self = $bias;
            type Pair = $pair;
            #[inline(always)]
            fn shift(amount: i64) -> $pair {
                $shift(amount)
            }
            #[inline(always)]
            fn enter(amount: i64) -> $pair {
                $enter(amount)
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
    |amount: i64| (amount as u32).wrapping_sub((amount as u32) << 16),
    |amount: i64| (amount as u32) << 16,
    u32::wrapping_add
);
lane!(
    i32,
    1 << 30,
    u64,
    |amount: i64| (amount as u64).wrapping_sub((amount as u64) << 32),
    |amount: i64| (amount as u64) << 32,
    u64::wrapping_add
);
lane!(i64, 0, [i64; 2], |amount: i64| [amount, -amount], |amount: i64| [0, amount], |pair: [i64; 2], by: [i64; 2]| [
    pair[0] + by[0],
    pair[1] + by[1]
]);

type Row<T, const N: usize> = [T; N];

#[inline(always)]
fn zip<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>, f: impl Fn(T, T) -> T) -> Row<T, N> {
    let mut out = [T::default(); N];
    for lane in 0..N {
        out[lane] = f(a[lane], b[lane]);
    }
    out
}

#[inline(always)]
fn add<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, T::plus)
}

#[inline(always)]
fn sub<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, T::minus)
}

#[inline(always)]
fn max<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, |x, y| if x > y { x } else { y })
}

#[inline(always)]
fn min<T: Lane, const N: usize>(a: &Row<T, N>, b: &Row<T, N>) -> Row<T, N> {
    zip(a, b, |x, y| if x < y { x } else { y })
}

/// Two columns, buckets of one column each: what the first gains less what the second does is all that is needed.
pub struct Difference<'a, T, const N: usize> {
    /// Gain of the first column less that of the second, and `BIAS` (`n_buckets`).
    pub histogram: &'a [Row<T, N>],
    /// Sum of each of the two columns, by lane.
    pub totals: &'a [Row<T, N>],
    /// Largest gain of a stump, out. Inside a bucket there is no larger one: its difference only grows or only shrinks.
    pub best: Row<T, N>,
}

impl<T: Lane, const N: usize> WithSimd for &mut Difference<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let bias = [T::BIAS; N];
        let mut run = [T::default(); N];
        let (mut least, mut most) = (run, run);
        for bucket in self.histogram {
            run = add(&run, &sub(bucket, &bias));
            least = min(&least, &run);
            most = max(&most, &run);
        }
        // first | second: first left + second right = second + run; second | first: first - run
        self.best = max(&add(&self.totals[1], &most), &sub(&self.totals[0], &least));
    }
}

/// Buckets between two checkpoints of the running sums.
pub const STRIDE: usize = 8;

/// One group of lanes: what goes in and comes out.
pub struct Group<'a, T, const N: usize> {
    /// Histogram (`n_buckets * rows`).
    pub histogram: &'a [Row<T, N>],
    /// The largest where a bucket may have a cut inside, 0 where it has not (`n_buckets`).
    pub open: &'a [Row<T, N>],
    /// Sum of each column, by lane (`columns`).
    pub totals: &'a [Row<T, N>],
    /// Largest gain that a stump inside a bucket may have, out (`n_buckets`).
    pub caps: &'a mut [Row<T, N>],
    /// The largest of `caps` over each `STRIDE` buckets, out (`n_buckets / STRIDE`).
    pub tops: &'a mut [Row<T, N>],
    /// Running sums before every `STRIDE`-th bucket, out (`n_buckets / STRIDE * columns`).
    pub runs: &'a mut [Row<T, N>],
    /// Gains of one sample of each kind (`kinds * columns`); empty where each kind gains in its own column.
    pub gains: &'a [T],
    /// Swing of one sample of each kind (`kinds`); empty likewise.
    pub swings: &'a [T],
    /// Twice the span that is left of each kind beside each direction (`directions * kinds`); empty likewise.
    pub spans: &'a [T],
    /// Largest gain seen at an edge, out.
    pub best: Row<T, N>,
    /// Largest gain that any stump may have, out.
    pub reach: Row<T, N>,
}

impl<T: Lane, const N: usize> WithSimd for &mut Group<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        match (self.swings.len(), self.totals.len()) {
            (0, 2) => self.sweep::<2>(),
            (0, 3) => self.sweep::<3>(),
            (0, 4) => self.sweep::<4>(),
            (0, 5) => self.sweep::<5>(),
            (0, 6) => self.sweep::<6>(),
            (0, _) => self.sweep_any(),
            (3, 3) => self.sweep_kinds::<3>(),
            (4, 4) => self.sweep_kinds::<4>(),
            (5, 5) => self.sweep_kinds::<5>(),
            (6, 6) => self.sweep_kinds::<6>(),
            _ => self.sweep_any_kinds(),
        }
    }
}

impl<T: Lane, const N: usize> Group<'_, T, N> {
    #[inline(always)]
    fn sweep<const K: usize>(&mut self) {
        let mut totals = [[T::default(); N]; K];
        totals.copy_from_slice(&self.totals[..K]);
        let mut run = [[T::default(); N]; K];
        let mut edge = Edge::first(&totals);
        let (buckets, _) = self.histogram.as_chunks::<K>();
        for (b, ((bucket, open), cap)) in buckets.iter().zip(self.open).zip(self.caps.iter_mut()).enumerate() {
            if b % STRIDE == 0 {
                self.runs[b / STRIDE * K..][..K].copy_from_slice(&run);
            }
            let mut low = [T::default(); N];
            let mut high = [T::default(); N];
            let mut count = [T::default(); N];
            let mut top = [T::default(); N];
            for c in 0..K {
                run[c] = add(&run[c], &bucket[c]);
                low = max(&low, &run[c]);
                high = max(&high, &sub(&totals[c], &run[c]));
                count = add(&count, &bucket[c]);
                top = max(&top, &bucket[c]);
            }
            edge.pass(&low, &high, &count, &sub(&count, &top), open, cap);
            if b % STRIDE == STRIDE - 1 {
                self.tops[b / STRIDE] = edge.close_stride();
            }
        }
        (self.best, self.reach) = (edge.best, edge.reach);
    }

    #[inline(always)]
    fn sweep_any(&mut self) {
        let k = self.totals.len();
        let mut run = vec![[T::default(); N]; k];
        let mut edge = Edge::first(self.totals);
        for (b, bucket) in self.histogram.chunks_exact(k).enumerate() {
            if b % STRIDE == 0 {
                self.runs[b / STRIDE * k..][..k].copy_from_slice(&run);
            }
            let mut low = [T::default(); N];
            let mut high = [T::default(); N];
            let mut count = [T::default(); N];
            let mut top = [T::default(); N];
            for (c, held) in bucket.iter().enumerate() {
                run[c] = add(&run[c], held);
                low = max(&low, &run[c]);
                high = max(&high, &sub(&self.totals[c], &run[c]));
                count = add(&count, held);
                top = max(&top, held);
            }
            edge.pass(&low, &high, &count, &sub(&count, &top), &self.open[b], &mut self.caps[b]);
            if b % STRIDE == STRIDE - 1 {
                self.tops[b / STRIDE] = edge.close_stride();
            }
        }
        (self.best, self.reach) = (edge.best, edge.reach);
    }
}

/// What is carried from one bucket edge to the next.
struct Edge<T, const N: usize> {
    high: Row<T, N>,
    score: Row<T, N>,
    best: Row<T, N>,
    reach: Row<T, N>,
    top: Row<T, N>,
}

impl<T: Lane, const N: usize> Edge<T, N> {
    #[inline(always)]
    fn first(totals: &[Row<T, N>]) -> Self {
        let mut high = [T::default(); N];
        for row in totals {
            high = max(&high, row);
        }
        Self { high, score: high, best: high, reach: high, top: [T::default(); N] }
    }

    /// Pass a bucket: `low`, `high` the best gain left and right of its end, `count` its swing, `minor` its swing
    /// outside its largest column, or the least span that is left of its gains beside one direction.
    ///
    /// A cut inside the bucket has at most the least of these gains (start, end: the bucket's edges):
    /// * `low(end) + high(start)`: gains grow with the set.
    /// * `score(start) + c1` and `score(end) + c2` for the swings c1 + c2 = count on both sides of it, so at most
    ///   their mean: moving a sample changes a gain by at most its swing.
    /// * `max(score(start), score(end)) + minor`: without the samples outside the largest column, low + high is a
    ///   convex function of how many samples of that one column lie left, so largest at an end, where it is at most
    ///   the score with them; putting them back gains at most their swing. For directions: see `exact::directions`.
    #[inline(always)]
    fn pass(
        &mut self,
        low: &Row<T, N>,
        high: &Row<T, N>,
        count: &Row<T, N>,
        minor: &Row<T, N>,
        open: &Row<T, N>,
        cap: &mut Row<T, N>,
    ) {
        let score = add(low, high);
        let cross = add(low, &self.high);
        let mean = zip(&add(&score, count), &self.score, |a, b| a.plus(b).half());
        let lifted = add(&max(&score, &self.score), minor);
        let inside = min(&min(&cross, &mean), &min(&lifted, open));
        *cap = inside;
        self.top = max(&self.top, &inside);
        self.best = max(&self.best, &score);
        self.high = *high;
        self.score = score;
    }

    /// The largest cap of the last `STRIDE` buckets.
    #[inline(always)]
    fn close_stride(&mut self) -> Row<T, N> {
        let top = std::mem::replace(&mut self.top, [T::default(); N]);
        self.reach = max(&self.reach, &max(&self.best, &top));
        top
    }
}

//! The vector pass over one group of features, where samples gain in one label each.

use pulp::{Simd, WithSimd};

use super::edge::{Edge, STRIDE};
use super::lanes::{Lane, Row, add, max, sub};

/// One group of lanes, its inputs and results.
pub(crate) struct Group<'a, T, const N: usize> {
    /// Histogram (`n_buckets * rows`).
    pub(crate) histogram: &'a [Row<T, N>],
    /// The largest where a bucket may have a cut inside, 0 where it has not (`n_buckets`).
    pub(crate) open: &'a [Row<T, N>],
    /// Sum of each label, by lane (`labels`).
    pub(crate) totals: &'a [Row<T, N>],
    /// Largest gain that a stump inside a bucket may have, out (`n_buckets`).
    pub(crate) caps: &'a mut [Row<T, N>],
    /// The larger gain of a bucket's two edges, out (`n_buckets`); not where each profile gains in its own label.
    pub(crate) scores: &'a mut [Row<T, N>],
    /// The largest of `caps` over each `STRIDE` buckets, out (`n_buckets / STRIDE`).
    pub(crate) tops: &'a mut [Row<T, N>],
    /// Running sums before every `STRIDE`-th bucket, out (`n_buckets / STRIDE * labels`).
    pub(crate) runs: &'a mut [Row<T, N>],
    /// Gains of one sample of each profile (`profiles * labels`); empty where each profile gains in its own label.
    pub(crate) gains: &'a [T],
    /// Cost range of one sample of each profile (`profiles`); empty likewise.
    pub(crate) ranges: &'a [T],
    /// Twice the largest span that is left of each profile beside a direction (`profiles`); empty likewise.
    pub(crate) spans: &'a [T],
    /// Whether only the first half of the lanes has features.
    pub(crate) is_half: bool,
    /// Largest gain seen at an edge, out.
    pub(crate) best: Row<T, N>,
    /// Largest gain that any stump may have, out.
    pub(crate) reach: Row<T, N>,
}

impl<T: Lane, const N: usize> WithSimd for &mut Group<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        match (self.ranges.len(), self.totals.len()) {
            // Without vectors, loops: to unroll them here as well takes a tenth of this crate's build.
            (0, _) if S::IS_SCALAR => self.sweep_any(),
            _ if S::IS_SCALAR => self.sweep_any_profiles(),
            (0, 2) => self.pass_buckets::<2, _>(&ByLabel),
            (0, 3) => self.pass_buckets::<3, _>(&ByLabel),
            (0, 4) => self.pass_buckets::<4, _>(&ByLabel),
            (0, 5) => self.pass_buckets::<5, _>(&ByLabel),
            (0, 6) => self.pass_buckets::<6, _>(&ByLabel),
            (0, 7) => self.pass_buckets::<7, _>(&ByLabel),
            (0, 8) => self.pass_buckets::<8, _>(&ByLabel),
            (0, 9) => self.pass_buckets::<9, _>(&ByLabel),
            (0, 10) => self.pass_buckets::<10, _>(&ByLabel),
            (0, _) => self.sweep_any(),
            // Unrolled products of 64 bits are slower than loops (48 against 38 us an evaluated cut of mu2).
            _ if size_of::<T>() > 4 => self.sweep_any_profiles(),
            (3, 3) => self.sweep_profiles::<3>(),
            (4, 4) => self.sweep_profiles::<4>(),
            (5, 5) => self.sweep_profiles::<5>(),
            (6, 6) => self.sweep_profiles::<6>(),
            (7, 7) => self.sweep_profiles::<7>(),
            (8, 8) => self.sweep_profiles::<8>(),
            (9, 9) => self.sweep_profiles::<9>(),
            (10, 10) => self.sweep_profiles::<10>(),
            _ => self.sweep_any_profiles(),
        }
    }
}

/// What a bucket adds on one lane.
pub(super) struct Entry<T, const K: usize> {
    /// Gain in each label.
    pub(super) gains: [T; K],
    /// Cost range.
    pub count: T,
    /// Uncertainty of the gains inside.
    pub(super) minor: T,
}

/// How a bucket is read.
pub(super) trait Reader<T, const N: usize, const K: usize> {
    /// Whether the gains at the edges are wanted.
    const KEEPS_SCORES: bool;
    /// What a bucket adds on one lane.
    fn read(&self, bucket: &[Row<T, N>; K], lane: usize) -> Entry<T, K>;
}

/// Rows are labels.
struct ByLabel;

impl<T: Lane, const N: usize, const K: usize> Reader<T, N, K> for ByLabel {
    const KEEPS_SCORES: bool = false;

    #[inline(always)]
    fn read(&self, bucket: &[Row<T, N>; K], lane: usize) -> Entry<T, K> {
        let mut gains = [T::default(); K];
        let (mut count, mut top) = (T::default(), T::default());
        for c in 0..K {
            gains[c] = bucket[c][lane];
            count = count.plus(gains[c]);
            top = top.max(gains[c]);
        }
        Entry { gains, count, minor: count.minus(top) }
    }
}

/// Running sums of the gains in each label, from one bucket edge to the next.
struct Sums<T, const N: usize, const K: usize> {
    totals: [Row<T, N>; K],
    run: [Row<T, N>; K],
    edge: Edge<T, N>,
}

impl<T: Lane, const N: usize, const K: usize> Sums<T, N, K> {
    #[inline(always)]
    fn first(whole: &[Row<T, N>]) -> Self {
        let mut totals = [[T::default(); N]; K];
        totals.copy_from_slice(whole);
        Self { totals, run: [[T::default(); N]; K], edge: Edge::first(whole) }
    }

    /// Pass a bucket on the first so many lanes; returns what it may hide.
    ///
    /// All that is done for a lane stands in one loop over the lanes, which the compiler turns into vectors. Of a loop
    /// for each operation it unrolls the short ones and joins their pieces by shuffles: on AVX2 that took three times
    /// as long.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // likewise of K steps
    fn pass<R: Reader<T, N, K>>(
        &mut self,
        n_lanes: usize,
        bucket: &[Row<T, N>; K],
        open: &Row<T, N>,
        reader: &R,
    ) -> Row<T, N> {
        let mut inside = [T::default(); N];
        for lane in 0..n_lanes {
            let Entry { gains, count, minor } = reader.read(bucket, lane);
            let (mut low, mut high) = (T::default(), T::default());
            for c in 0..K {
                let sum = self.run[c][lane].plus(gains[c]);
                self.run[c][lane] = sum;
                low = low.max(sum);
                high = high.max(self.totals[c][lane].minus(sum));
            }
            inside[lane] = self.edge.pass(lane, [low, high], count, minor, open[lane]);
        }
        inside
    }
}

impl<T: Lane, const N: usize> Group<'_, T, N> {
    /// The pass over buckets of `K` rows, as many as labels; `reader` knows what they hold.
    #[inline(always)]
    pub(super) fn pass_buckets<const K: usize, R: Reader<T, N, K>>(&mut self, reader: &R) {
        let mut sums = Sums::<T, N, K>::first(&self.totals[..K]);
        let (buckets, _) = self.histogram.as_chunks::<K>();
        for (b, ((bucket, open), cap)) in buckets.iter().zip(self.open).zip(self.caps.iter_mut()).enumerate() {
            if b % STRIDE == 0 {
                self.runs[b / STRIDE * K..][..K].copy_from_slice(&sums.run);
            }
            *cap =
                if self.is_half { sums.pass(N / 2, bucket, open, reader) } else { sums.pass(N, bucket, open, reader) };
            if R::KEEPS_SCORES {
                self.scores[b] = sums.edge.larger;
            }
            if b % STRIDE == STRIDE - 1 {
                self.tops[b / STRIDE] = sums.edge.close_stride();
            }
        }
        (self.best, self.reach) = (sums.edge.best, sums.edge.reach);
    }

    /// The same for any number of labels.
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
            edge.pass_all(&[low, high], &count, &sub(&count, &top), &self.open[b], &mut self.caps[b]);
            if b % STRIDE == STRIDE - 1 {
                self.tops[b / STRIDE] = edge.close_stride();
            }
        }
        (self.best, self.reach) = (edge.best, edge.reach);
    }
}

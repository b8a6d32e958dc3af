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
    /// The largest of `caps` over each `STRIDE` buckets, out (`n_buckets / STRIDE`).
    pub(crate) tops: &'a mut [Row<T, N>],
    /// Running sums before every `STRIDE`-th bucket, out (`n_buckets / STRIDE * labels`).
    pub(crate) runs: &'a mut [Row<T, N>],
    /// Gains of one sample of each profile (`profiles * labels`); empty where each profile gains in its own label.
    pub(crate) gains: &'a [T],
    /// Cost range of one sample of each profile (`profiles`); empty likewise.
    pub(crate) ranges: &'a [T],
    /// Twice the span that is left of each profile beside each direction (`directions * profiles`); empty likewise.
    pub(crate) spans: &'a [T],
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
            (0, 2) => self.sweep::<2>(),
            (0, 3) => self.sweep::<3>(),
            (0, 4) => self.sweep::<4>(),
            (0, 5) => self.sweep::<5>(),
            (0, 6) => self.sweep::<6>(),
            (0, 7) => self.sweep::<7>(),
            (0, 8) => self.sweep::<8>(),
            (0, 9) => self.sweep::<9>(),
            (0, 10) => self.sweep::<10>(),
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

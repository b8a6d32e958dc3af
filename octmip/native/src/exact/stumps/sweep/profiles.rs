//! The vector pass where samples gain in several labels: a bucket holds the number of samples of each cost profile.

use super::edge::{Edge, STRIDE};
use super::group::Group;
use super::lanes::{Lane, Row, add, max, min, sub, zip};

#[inline(always)]
fn scale<T: Lane, const N: usize>(a: &Row<T, N>, by: T) -> Row<T, N> {
    zip(a, a, |x, _| x.times(by))
}

/// A value that the compiler takes by itself. Of 32 bits it else works across labels and profiles, by gathers and
/// shuffles, and not across lanes (three times as long).
#[inline(always)]
fn by_itself<T: Lane, V>(value: V) -> V {
    if size_of::<T>() == 4 { std::hint::black_box(value) } else { value }
}

impl<T: Lane, const N: usize> Group<'_, T, N> {
    /// Rows are profiles, and samples of a profile gain in several labels; as many profiles as labels.
    #[inline(always)]
    pub(super) fn sweep_profiles<const K: usize>(&mut self) {
        let (mut totals, mut gains, mut ranges) = ([[T::default(); N]; K], [[T::default(); K]; K], [T::default(); K]);
        totals.copy_from_slice(&self.totals[..K]);
        gains.copy_from_slice(&self.gains.as_chunks::<K>().0[..K]);
        ranges.copy_from_slice(&self.ranges[..K]);
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
            for profile in 0..K {
                count = add(&count, &scale(&bucket[profile], by_itself::<T, _>(ranges[profile])));
                for c in 0..K {
                    run[c] = add(&run[c], &scale(&bucket[profile], by_itself::<T, _>(gains[profile][c])));
                }
            }
            for c in 0..K {
                let (run, total) = (by_itself::<T, _>(&run[c]), by_itself::<T, _>(&totals[c]));
                low = max(&low, run);
                high = max(&high, &sub(total, run));
            }
            let mut minor = [T::MAX; N];
            for spans in self.spans.as_chunks::<K>().0 {
                let mut left = [T::default(); N];
                for profile in 0..K {
                    left = add(&left, &scale(&bucket[profile], by_itself::<T, _>(spans[profile])));
                }
                minor = min(&minor, &left);
            }
            edge.pass(&low, &high, &count, &zip(&minor, &minor, |m, _| m.half()), open, cap);
            if b % STRIDE == STRIDE - 1 {
                self.tops[b / STRIDE] = edge.close_stride();
            }
        }
        (self.best, self.reach) = (edge.best, edge.reach);
    }

    /// The same for any number of profiles and labels.
    #[inline(always)]
    pub(super) fn sweep_any_profiles(&mut self) {
        let k = self.totals.len();
        let mut run = vec![[T::default(); N]; k];
        let mut edge = Edge::first(self.totals);
        for (b, bucket) in self.histogram.chunks_exact(self.ranges.len()).enumerate() {
            if b % STRIDE == 0 {
                self.runs[b / STRIDE * k..][..k].copy_from_slice(&run);
            }
            let mut low = [T::default(); N];
            let mut high = [T::default(); N];
            let mut count = [T::default(); N];
            for ((held, range), gains) in bucket.iter().zip(self.ranges).zip(self.gains.chunks_exact(k)) {
                count = add(&count, &scale(held, *range));
                for (run, gain) in run.iter_mut().zip(gains) {
                    *run = add(run, &scale(held, *gain));
                }
            }
            for (run, total) in run.iter().zip(self.totals) {
                low = max(&low, run);
                high = max(&high, &sub(total, run));
            }
            let mut minor = [T::MAX; N];
            for spans in self.spans.chunks_exact(self.ranges.len()) {
                let mut left = [T::default(); N];
                for (held, span) in bucket.iter().zip(spans) {
                    left = add(&left, &scale(held, *span));
                }
                minor = min(&minor, &left);
            }
            let minor = zip(&minor, &minor, |m, _| m.half());
            edge.pass(&low, &high, &count, &minor, &self.open[b], &mut self.caps[b]);
            if b % STRIDE == STRIDE - 1 {
                self.tops[b / STRIDE] = edge.close_stride();
            }
        }
        (self.best, self.reach) = (edge.best, edge.reach);
    }
}

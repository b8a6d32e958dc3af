//! The vector pass where samples gain in several labels: a bucket holds the number of samples of each cost profile.

use super::edge::{Edge, STRIDE};
use super::group::{Entry, Group, Reader};
use super::lanes::{Lane, Row, add, max, sub, zip};

#[inline(always)]
fn scale<T: Lane, const N: usize>(a: &Row<T, N>, by: T) -> Row<T, N> {
    zip(a, a, |x, _| x.times(by))
}

/// Rows are profiles, and samples of a profile gain in several labels; as many profiles as labels.
struct ByProfile<T, const K: usize> {
    gains: [[T; K]; K],
    ranges: [T; K],
    spans: [T; K],
}

/// What the samples of a bucket add together.
#[inline(always)]
fn sum<T: Lane, const K: usize>(held: &[T; K], each: &[T; K]) -> T {
    let mut sum = T::default();
    for profile in 0..K {
        sum = sum.plus(held[profile].times(each[profile]));
    }
    sum
}

impl<T: Lane, const N: usize, const K: usize> Reader<T, N, K> for ByProfile<T, K> {
    const KEEPS_SCORES: bool = true;

    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // loops of K steps become straight code by their indices
    fn read(&self, bucket: &[Row<T, N>; K], lane: usize) -> Entry<T, K> {
        let mut held = [T::default(); K];
        for profile in 0..K {
            held[profile] = bucket[profile][lane];
        }
        let mut gains = [T::default(); K];
        for c in 0..K {
            gains[c] = sum(&held, &self.gains[c]);
        }
        let (mut doubled, mut top) = (T::default(), T::default());
        for profile in 0..K {
            let span = held[profile].times(self.spans[profile]);
            doubled = doubled.plus(span);
            top = top.max(span);
        }
        Entry { gains, count: sum(&held, &self.ranges), minor: doubled.minus(top).half() }
    }
}

impl<T: Lane, const N: usize> Group<'_, T, N> {
    /// The pass where there are `K` profiles and labels.
    #[inline(always)]
    pub(super) fn sweep_profiles<const K: usize>(&mut self) {
        let mut gains = [[T::default(); K]; K];
        for (profile, row) in self.gains.as_chunks::<K>().0.iter().enumerate() {
            for c in 0..K {
                gains[c][profile] = row[c];
            }
        }
        let (mut spans, mut ranges) = ([T::default(); K], [T::default(); K]);
        spans.copy_from_slice(&self.spans[..K]);
        ranges.copy_from_slice(&self.ranges[..K]);
        self.pass_buckets(&ByProfile { gains, ranges, spans });
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
            let (mut doubled, mut top) = ([T::default(); N], [T::default(); N]);
            for (held, span) in bucket.iter().zip(self.spans) {
                let span = scale(held, *span);
                doubled = add(&doubled, &span);
                top = max(&top, &span);
            }
            let minor = zip(&doubled, &top, |doubled, top| doubled.minus(top).half());
            edge.pass_all(&[low, high], &count, &minor, &self.open[b], &mut self.caps[b]);
            self.scores[b] = edge.larger;
            if b % STRIDE == STRIDE - 1 {
                self.tops[b / STRIDE] = edge.close_stride();
            }
        }
        (self.best, self.reach) = (edge.best, edge.reach);
    }
}

//! The second pass over the buckets: only those that may hide a better stump, with a bound that takes longer.

use pulp::{Simd, WithSimd};

use super::edge::STRIDE;
use super::lanes::{Lane, Row, add, max, min, sub};

/// Lowers the bounds of the buckets of one group of features, where samples gain in one label each.
///
/// A stump that predicts one label on both sides is a leaf, and counted as such. One inside a bucket that predicts l
/// left and r right, l and r different, gains at most `gain of l left of the bucket's end + gain of r right of its
/// start`, as gains grow with the set. Where one label prevails on both sides of a bucket, that is far below what is
/// gained at its edges, and the bucket is not walked.
pub(crate) struct Distinct<'a, T, const N: usize> {
    /// Histogram (`n_buckets * labels`).
    pub(crate) histogram: &'a [Row<T, N>],
    /// Sum of each label, by lane (`labels`).
    pub(crate) totals: &'a [Row<T, N>],
    /// Running sums before every `STRIDE`-th bucket (`n_buckets / STRIDE * labels`).
    pub(crate) runs: &'a [Row<T, N>],
    /// Gain that is known, the leaf's at least: bounds up to it stay as they are.
    pub(crate) known: Row<T, N>,
    /// Largest gain that a stump inside a bucket may have, in and out (`n_buckets`).
    pub(crate) caps: &'a mut [Row<T, N>],
    /// The largest of `caps` over each `STRIDE` buckets, in and out (`n_buckets / STRIDE`).
    pub(crate) tops: &'a mut [Row<T, N>],
}

impl<T: Lane, const N: usize> WithSimd for &mut Distinct<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let k = self.totals.len();
        let mut run = vec![[T::default(); N]; k];
        for (stride, top) in self.tops.iter_mut().enumerate() {
            if !is_above(top, &self.known) {
                continue;
            }
            run.copy_from_slice(&self.runs[stride * k..][..k]);
            *top = [T::default(); N];
            let buckets = self.histogram[stride * STRIDE * k..][..STRIDE * k].chunks_exact(k);
            for (bucket, cap) in buckets.zip(&mut self.caps[stride * STRIDE..]) {
                let (mut low, mut high, mut cross) = ([T::default(); N], [T::default(); N], [T::default(); N]);
                for ((run, held), total) in run.iter_mut().zip(bucket).zip(self.totals) {
                    // each label with those before it: `low` and `high` are theirs
                    let start = sub(total, run);
                    *run = add(run, held);
                    cross = max(&cross, &max(&add(run, &high), &add(&start, &low)));
                    low = max(&low, run);
                    high = max(&high, &start);
                }
                *cap = min(cap, &cross);
                *top = max(top, cap);
            }
        }
    }
}

#[inline(always)]
fn is_above<T: Lane, const N: usize>(row: &Row<T, N>, known: &Row<T, N>) -> bool {
    row.iter().zip(known).fold(false, |any, (a, b)| any | (a > b))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUCKETS: [[usize; 3]; STRIDE] =
        [[0, 0, 1], [0, 2, 0], [1, 1, 0], [2, 0, 1], [1, 1, 1], [0, 1, 2], [2, 2, 0], [0, 2, 2]];

    /// Bounds of the buckets, all of them 1000 before.
    fn lowered(buckets: &[[usize; 3]]) -> Vec<i32> {
        let mut histogram = vec![[0; 1]; buckets.len() * 3];
        for (bucket, labels) in histogram.chunks_exact_mut(3).zip(buckets) {
            labels.iter().for_each(|&label| bucket[label][0] += 1);
        }
        let totals: Vec<[i32; 1]> =
            (0..3).map(|c| [histogram.iter().skip(c).step_by(3).map(|held| held[0]).sum()]).collect();
        let (mut caps, mut tops) = (vec![[1000; 1]; buckets.len()], vec![[1000; 1]; 1]);
        pulp::Arch::Scalar.dispatch(&mut Distinct {
            histogram: &histogram,
            totals: &totals,
            runs: &[[0]; 3],
            known: [0],
            caps: &mut caps,
            tops: &mut tops,
        });
        assert_eq!(caps.iter().max(), tops.first());
        caps.iter().map(|cap| cap[0]).collect()
    }

    /// Most samples of two different labels, one left and one right of a cut.
    fn best_of_two(samples: &[usize], cut: usize) -> usize {
        let (left, right) = samples.split_at(cut);
        let gain = |part: &[usize], label| part.iter().filter(|&&own| own == label).count();
        let pairs = (0..3).flat_map(|l| (0..3).map(move |r| (l, r))).filter(|(l, r)| l != r);
        pairs.map(|(l, r)| gain(left, l) + gain(right, r)).max().unwrap_or(0)
    }

    #[test]
    fn no_stump_of_two_labels_inside_a_bucket_gains_more_than_its_bound() {
        let caps = lowered(&BUCKETS);
        let samples = BUCKETS.as_flattened();
        for cut in 0..samples.len() {
            assert!(best_of_two(samples, cut) <= caps[cut / 3] as usize, "cut {cut}: {caps:?}");
        }
    }

    #[test]
    fn where_one_label_prevails_on_both_sides_nothing_is_hidden() {
        let mut buckets = [[0; 3]; STRIDE];
        (buckets[1][0], buckets[6][1]) = (1, 2);
        let leaf = 22;
        assert!(lowered(&buckets).iter().all(|&cap| cap <= leaf));
    }
}

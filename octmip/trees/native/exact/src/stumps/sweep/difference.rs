//! The vector pass where two labels are left and each bucket holds one of them.

use pulp::{Simd, WithSimd};

use super::lanes::{Lane, Row, add, max, min, sub};

/// Two labels, buckets of one label each: the first gain less the second is all that is needed.
pub(crate) struct Difference<'a, T, const N: usize> {
    /// Gain of the first label less that of the second, and `BIAS` (`n_buckets`).
    pub(crate) histogram: &'a [Row<T, N>],
    /// Sum of each of the two labels, by lane.
    pub(crate) totals: &'a [Row<T, N>],
    /// Largest gain of a stump, out. Inside a bucket there is no larger one: its difference only grows or only shrinks.
    pub(crate) best: Row<T, N>,
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

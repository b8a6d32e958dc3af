//! The bounds of a bucket, from the gains at its two edges.

use super::lanes::{Lane, Row, add, max, min, zip};

/// Buckets between two checkpoints of the running sums.
pub(crate) const STRIDE: usize = 8;

/// Sums and bounds that are carried from one bucket edge to the next.
pub(super) struct Edge<T, const N: usize> {
    high: Row<T, N>,
    score: Row<T, N>,
    pub(super) best: Row<T, N>,
    pub(super) reach: Row<T, N>,
    top: Row<T, N>,
}

impl<T: Lane, const N: usize> Edge<T, N> {
    #[inline(always)]
    pub(super) fn first(totals: &[Row<T, N>]) -> Self {
        let mut high = [T::default(); N];
        for row in totals {
            high = max(&high, row);
        }
        Self { high, score: high, best: high, reach: high, top: [T::default(); N] }
    }

    /// Pass a bucket: `low`, `high` the best gain left and right of its end, `count` its cost range, `minor` its cost
    /// range outside its largest label, or the least span that is left of its gains beside one direction.
    ///
    /// A cut inside the bucket has at most the least of these gains (start, end: the bucket's edges):
    /// * `low(end) + high(start)`: gains grow with the set.
    /// * `score(start) + c1` and `score(end) + c2` for the ranges c1 + c2 = count on both sides of it, so at most
    ///   their mean: moving a sample changes a gain by at most its cost range.
    /// * `max(score(start), score(end)) + minor`: without the samples outside the largest label, low + high is a
    ///   convex function of how many samples of that one label lie left, so largest at an end, where it is at most
    ///   the score with them; putting them back gains at most their cost range. For directions: see
    ///   `exact::samples::directions`.
    #[inline(always)]
    pub(super) fn pass(
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
    pub(super) fn close_stride(&mut self) -> Row<T, N> {
        let top = std::mem::replace(&mut self.top, [T::default(); N]);
        self.reach = max(&self.reach, &max(&self.best, &top));
        top
    }
}

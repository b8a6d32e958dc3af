//! The bounds of a bucket, from the gains at its two edges.

use super::lanes::{Lane, Row, max};

/// Buckets between two checkpoints of the running sums.
pub(crate) const STRIDE: usize = 8;

/// Sums and bounds that are carried from one bucket edge to the next.
pub(super) struct Edge<T, const N: usize> {
    high: Row<T, N>,
    score: Row<T, N>,
    pub(super) best: Row<T, N>,
    pub(super) reach: Row<T, N>,
    top: Row<T, N>,
    /// The larger gain of the two edges of the bucket passed last.
    pub(super) larger: Row<T, N>,
}

impl<T: Lane, const N: usize> Edge<T, N> {
    #[inline(always)]
    pub(super) fn first(totals: &[Row<T, N>]) -> Self {
        let mut high = [T::default(); N];
        for row in totals {
            high = max(&high, row);
        }
        Self { high, score: high, best: high, reach: high, top: [T::default(); N], larger: high }
    }

    /// Pass a bucket on one lane: `low`, `high` the best gain left and right of its end, `count` its cost range, and
    /// `minor` its cost range outside its largest label, or the least span that is left of its gains beside one
    /// direction.
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
    pub(super) fn pass(&mut self, lane: usize, [low, high]: [T; 2], count: T, minor: T, open: T) -> T {
        let score = low.plus(high);
        let before = self.score[lane];
        let mean = score.plus(count).plus(before).half();
        let larger = score.max(before);
        let lifted = larger.plus(minor);
        self.larger[lane] = larger;
        let inside = low.plus(self.high[lane]).min(mean).min(lifted).min(open);
        self.top[lane] = self.top[lane].max(inside);
        self.best[lane] = self.best[lane].max(score);
        (self.high[lane], self.score[lane]) = (high, score);
        inside
    }

    /// Pass a bucket on all lanes.
    #[inline(always)]
    pub(super) fn pass_all(
        &mut self,
        [low, high]: &[Row<T, N>; 2],
        count: &Row<T, N>,
        minor: &Row<T, N>,
        open: &Row<T, N>,
        cap: &mut Row<T, N>,
    ) {
        for lane in 0..N {
            cap[lane] = self.pass(lane, [low[lane], high[lane]], count[lane], minor[lane], open[lane]);
        }
    }

    /// The largest cap of the last `STRIDE` buckets.
    #[inline(always)]
    pub(super) fn close_stride(&mut self) -> Row<T, N> {
        let top = std::mem::replace(&mut self.top, [T::default(); N]);
        self.reach = max(&self.reach, &max(&self.best, &top));
        top
    }
}

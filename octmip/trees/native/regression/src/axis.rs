//! One feature of a node: its cuts, what is known of them, and the proofs by which runs of cuts are dropped.
//!
//! Notation: cut `k` sends a set L(k) left and R(k) right; `e` is the cost of the best tree of the children's depth,
//! `r` the same where leaves may be of any size (the relaxed cost, `r <= e`), `range(k)` the total cost range of
//! L(k), and `c(a, k)` the least error of as many constants as the child has leaves, for the samples between. For a <
//! k < b:
//!
//! * clusters: `e(L(k)) >= r(L(k)) >= r(L(a)) + c(a, k)` and `e(R(k)) >= r(R(b)) + c(k, b)`: on L(a) the best relaxed
//!   tree of L(k) costs at least `r(L(a))` (splits that part nothing are dropped, which lowers the penalties), and for
//!   the other samples it predicts at most so many constants.
//! * cost range: `e(L(k)) >= e(L(b)) - (range(b) - range(k))` and `e(R(k)) >= e(R(a)) - (range(k) - range(a))`: the
//!   best tree of the smaller set is feasible on the larger. Its constants lie between the least and the greatest
//!   target, so a new sample costs at most its range, its error under the worse of the two.

use crate::clusters::{Histogram, N_BINS, Sums};
use crate::samples::Samples;
use crate::scan::Scanner;
use crate::sides::Sides;
use crate::view::View;
use octmip_frame::interval::Interval;

/// Histograms of targets are kept after so many parts of a feature's samples.
const N_PARTS: usize = 256;

/// Lower bounds of the two children of a cut.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    /// Of the left child.
    pub(crate) left: f64,
    /// Of the right child.
    pub(crate) right: f64,
}

impl Pair {
    /// That of one side, 0 left, 1 right.
    #[inline(always)]
    pub(crate) fn of(&self, side: usize) -> f64 {
        if side == 0 { self.left } else { self.right }
    }

    /// A bound of one side that holds as well.
    pub(crate) fn raise(&mut self, side: usize, bound: f64) {
        let own = if side == 0 { &mut self.left } else { &mut self.right };
        *own = own.max(bound);
    }
}

/// Cuts of a feature in order; the first and the last are the trivial ones that leave a side empty.
#[derive(Debug, Default)]
pub(crate) struct Axis {
    /// Samples left of each cut.
    pub(crate) positions: Vec<u32>,
    /// Least error of one constant left and right of each cut.
    pub(crate) leaves: Vec<Pair>,
    /// Total cost range left of each cut.
    pub(crate) ranges: Vec<f64>,
    /// Lower bounds of the children of the cuts that were solved.
    pub(crate) solved: Vec<Pair>,
    /// The same for leaves of any size.
    pub(crate) relaxed: Vec<Pair>,
    /// Number of the evaluation of each solved cut, for those who keep more of it.
    pub(crate) evaluation: Vec<u32>,
    parts: Vec<Histogram>,
    part_size: usize,
    n_leaves: usize,
}

impl Axis {
    /// Lay out the cuts of feature `f`; the children have up to `n_leaves` leaves.
    ///
    /// `whole`: lower bounds of the child problem on all samples, with leaves as asked and of any size.
    pub(crate) fn lay(&mut self, samples: &Samples, view: &View, f: usize, n_leaves: usize, whole: (f64, f64)) {
        self.n_leaves = n_leaves;
        self.part_size = view.len.div_ceil(N_PARTS).max(1);
        for list in [&mut self.solved, &mut self.relaxed, &mut self.leaves] {
            list.clear();
        }
        self.positions.clear();
        self.ranges.clear();
        self.parts.clear();
        self.lay_cuts(samples, view, f);
        let n_cuts = self.positions.len();
        self.evaluation.clear();
        self.evaluation.resize(n_cuts, 0);
        self.evaluation[n_cuts - 1] = 1;
        self.solved.resize(n_cuts, Pair::default());
        self.relaxed.resize(n_cuts, Pair::default());
        (self.solved[0].right, self.relaxed[0].right) = whole;
        (self.solved[n_cuts - 1].left, self.relaxed[n_cuts - 1].left) = whole;
    }

    fn lay_cuts(&mut self, samples: &Samples, view: &View, f: usize) {
        let (ranks, list) = (samples.ranks_of(f), view.list(f));
        let (low, high) = view.ends(samples);
        let smallest = samples.leaf_size;
        let mut histogram: Histogram = [Sums::default(); N_BINS];
        let mut range = 0.0;
        let mut before = None;
        for (k, &i) in list.iter().enumerate() {
            let i = i as usize;
            let is_cut = before.is_none_or(|rank| rank != ranks[i]);
            if k == 0 || (is_cut && k >= smallest && view.len - k >= smallest) {
                self.positions.push(k as u32);
                self.ranges.push(range);
            }
            if k.is_multiple_of(self.part_size) {
                self.parts.push(histogram);
            }
            before = Some(ranks[i]);
            range += samples.error_range(i, low, high);
            histogram[samples.bins.of_sample[i] as usize] += samples.sums[i];
        }
        self.positions.push(view.len as u32);
        self.ranges.push(range);
        if view.len.is_multiple_of(self.part_size) {
            self.parts.push(histogram);
        }
    }

    /// Fill in the least error of one constant on either side of every cut of feature `f`, all samples on the right.
    pub(crate) fn lay_leaves(
        &mut self,
        samples: &Samples,
        view: &View,
        f: usize,
        sides: &mut Sides,
        scanner: &mut Scanner,
    ) {
        self.leaves.resize(self.positions.len(), Pair::default());
        if samples.slopes.is_none() {
            return self.lay_means(samples, view.list(f), view.sums(samples));
        }
        let (left, right) = scanner.errors(samples, view, f, sides, 1);
        for (leaf, &k) in self.leaves.iter_mut().zip(&self.positions) {
            *leaf = Pair { left: left[k as usize], right: right[k as usize] };
        }
    }

    fn lay_means(&mut self, samples: &Samples, list: &[u32], total: Sums) {
        let (mut left, mut k) = (Sums::default(), 0);
        for (cut, leaf) in self.leaves.iter_mut().enumerate() {
            while k < self.positions[cut] as usize {
                left += samples.sums[list[k] as usize];
                k += 1;
            }
            *leaf = Pair { left: left.squared_error(), right: (total - left).squared_error() };
        }
    }

    /// Index of the trivial cut at the end.
    pub(crate) fn last(&self) -> usize {
        self.positions.len() - 1
    }

    /// All the cuts that split, None when there are none.
    pub(crate) fn whole(&self) -> Option<Interval> {
        Interval::between(0, self.last())
    }

    /// Least error of as many constants as a child has leaves (`times` children), for the samples between two cuts.
    fn clusters(&self, samples: &Samples, from: usize, to: usize, times: usize) -> f64 {
        let first = (self.positions[from] as usize).div_ceil(self.part_size);
        let last = self.positions[to] as usize / self.part_size;
        if first >= last || last >= self.parts.len() {
            return 0.0;
        }
        let (low, high) = (&self.parts[first], &self.parts[last]);
        let between: Histogram = std::array::from_fn(|bin| high[bin] - low[bin]);
        samples.bins.bound(&between, times * self.n_leaves, samples.slopes)
    }

    /// Lower bound of the children of every cut between two solved ones.
    pub(crate) fn least(&self, samples: &Samples, interval: &Interval) -> f64 {
        let Interval { a, b, .. } = *interval;
        let relaxed = self.relaxed[a].left + self.relaxed[b].right;
        self.by_range(interval).max(relaxed + self.clusters(samples, a, b, 2))
    }

    /// The same by cost ranges alone.
    fn by_range(&self, &Interval { a, b, .. }: &Interval) -> f64 {
        self.solved[b].left + self.solved[a].right - (self.ranges[b] - self.ranges[a])
    }

    /// Shrink an interval to cuts whose children may cost less than `target` together; None when there are none.
    pub(crate) fn narrow(&self, samples: &Samples, mut interval: Interval, target: f64) -> Option<Interval> {
        let Interval { a, b, .. } = interval;
        let relaxed = self.relaxed[a].left + self.relaxed[b].right;
        if relaxed.max(self.by_range(&interval)) >= target {
            return None;
        }
        // Half as many constants err by more, and are found sooner.
        let is_near = relaxed + self.clusters(samples, a, b, 1) >= target;
        if is_near && relaxed + self.clusters(samples, a, b, 2) >= target {
            return None;
        }
        // Clusters left of k, range right: r(L(a)) + e(R(a)) - (range(k) - range(a)) < target is needed; and mirrored.
        let from = self.ranges[a] + self.relaxed[a].left + self.solved[a].right - target;
        interval.low += self.ranges[interval.low..=interval.high].partition_point(|&range| range <= from);
        let to = self.ranges[b] - (self.solved[b].left + self.relaxed[b].right - target);
        let kept = self.ranges.get(interval.low..=interval.high)?.partition_point(|&range| range < to);
        if kept == 0 {
            return None;
        }
        interval.high = interval.low + kept - 1;
        Some(interval)
    }

    /// Lower bounds of both children of cut `k`, and those for leaves of any size, from the solved cuts around it.
    pub(crate) fn bounds(&self, samples: &Samples, interval: &Interval, k: usize) -> [Pair; 2] {
        let [left, left_relaxed] = self.left_bound(samples, interval, k);
        let [right, right_relaxed] = self.right_bound(samples, interval, k);
        [Pair { left, right }, Pair { left: left_relaxed, right: right_relaxed }]
    }

    /// The same of the left child.
    fn left_bound(&self, samples: &Samples, &Interval { a, b, .. }: &Interval, k: usize) -> [f64; 2] {
        let relaxed = self.relaxed[a].left + self.clusters(samples, a, k, 1);
        [relaxed.max(self.solved[b].left - (self.ranges[b] - self.ranges[k])), relaxed]
    }

    /// The same of the right child.
    fn right_bound(&self, samples: &Samples, &Interval { a, b, .. }: &Interval, k: usize) -> [f64; 2] {
        let relaxed = self.relaxed[b].right + self.clusters(samples, k, b, 1);
        [relaxed.max(self.solved[a].right - (self.ranges[k] - self.ranges[a])), relaxed]
    }

    /// Lower bounds at cut `k` of what is bounded like children, one for each entry at the ends of the interval.
    pub(crate) fn inherit(
        &self,
        samples: &Samples,
        interval: &Interval,
        k: usize,
        (before, after): (&[Pair], &[Pair]),
        found: &mut Vec<Pair>,
    ) {
        let Interval { a, b, .. } = *interval;
        let clusters = (self.clusters(samples, a, k, 1), self.clusters(samples, k, b, 1));
        let ranges = (self.ranges[k] - self.ranges[a], self.ranges[b] - self.ranges[k]);
        found.clear();
        found.extend(before.iter().zip(after).map(|(before, after)| Pair {
            left: (before.left + clusters.0).max(after.left - ranges.1),
            right: (after.right + clusters.1).max(before.right - ranges.0),
        }));
    }

    /// The open cut nearest the middle of the interval whose children's bounds stay below `target`.
    pub(crate) fn pick(&self, samples: &Samples, interval: &Interval, target: f64) -> Option<usize> {
        let middle = interval.low + (interval.high - interval.low) / 2;
        interval.nearest(middle, target, |first, last| {
            self.left_bound(samples, interval, first)[0] + self.right_bound(samples, interval, last)[0]
        })
    }

    /// Cost range between `k` and the farther end of the interval: what a child's bound is worth to its neighbours.
    pub(crate) fn slack(&self, interval: &Interval, k: usize) -> f64 {
        (self.ranges[k] - self.ranges[interval.low]).max(self.ranges[interval.high] - self.ranges[k])
    }
}

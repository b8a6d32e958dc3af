//! One feature of a node: its cuts, what is known of them, and the proofs by which runs of cuts are dropped.
//!
//! Notation: cut `k` sends a set L(k) left and R(k) right, `e` is the added cost of the best tree of the children's
//! depth, `range(k)` the total cost range of L(k). For cuts a < k < b:
//!
//! * monotone: `e(L(k)) >= e(L(a))` and `e(R(k)) >= e(R(b))`: the best tree for the larger set, used on the smaller
//!   one, costs no more there. False when leaves have a least size (the tree may be infeasible on the smaller set): it
//!   then holds of the free bounds beside them (`node::beside`), as does the bound of mixed labels. In a narrow run of
//!   cuts it holds of more: a leaf of `s` samples of L(k) has `s - (k - a)` of L(a) at least. So with `e_r` the least
//!   cost of leaves of `r` samples or more, `e_s(L(k)) >= e_r(L(a))` where `k - a <= s - r`, and with mixed labels.
//! * cost range: `e(L(k)) >= e(L(b)) - (range(b) - range(k))` and `e(R(k)) >= e(R(a)) - (range(k) - range(a))`: the
//!   best tree for the smaller set is feasible on the larger and costs at most the range of the new samples more.
//! * mixed labels: `e(L(k)) >= e(L(a)) + g(a, k)`, g the least cost of the samples between when only as many labels
//!   may be predicted as the child has leaves: each of them lands in some leaf of the same tree. Needs monotone.
//! * price: a side is a leaf or pays for a split (`node::price`), for any size of leaves; and where trees of fewer
//!   levels are known, one side has all the levels of a child, and pays for as many splits. A log has no line for it.
//! * small sides: one of fewer than two leaves of the least size is a leaf (`small_sides`). Nor for this.

mod mixed;
mod prices;
mod small_sides;

use crate::node::price::Prices;
use crate::node::result::Solved;
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_frame::interval::Interval;

use mixed::MixedLabels;
use small_sides::SmallSides;

/// Bounds of the children of a cut with leaves of any size, and with leaves as small as `Axis::sizes`.
pub type Beside = [[i64; 2]; 2];

/// Cuts of a feature in order; the first and the last are the trivial ones that leave a side empty.
#[derive(Debug, Default)]
pub(crate) struct Axis {
    /// Samples left of each cut.
    pub(crate) positions: Vec<u32>,
    /// Total cost range left of each cut.
    pub(crate) total_range: Vec<i64>,
    /// Lower bound of the left child; of the cuts that were solved.
    pub(crate) left: Vec<i64>,
    /// Lower bound of the right child; of the cuts that were solved.
    pub(crate) right: Vec<i64>,
    /// The same of both children with leaves of any size, and with leaves as small as `sizes`; not where leaves of any
    /// size are the problem itself.
    free: [[Vec<i64>; 2]; 2],
    leaf_size: usize,
    is_beside: bool,
    mixed: MixedLabels,
    /// Least cost of both children by price and labels, or by earlier searches; never falls as a child grows.
    least_of: [Vec<i64>; 2],
    /// Whether anything is known of that.
    has_least: bool,
    /// Sides that can only be leaves, where leaves have a least size.
    small: SmallSides,
    has_small: bool,
    /// Least cost of one of the children, where only trees of all levels are wanted; 0 where others are.
    of_all_levels: i64,
    n_cuts: usize,
    is_monotone: bool,
    has_range: bool,
}

impl Axis {
    /// Lay out the cuts of feature `f`, with `whole` a lower bound of the child problem on all samples.
    pub(crate) fn lay(
        &mut self,
        samples: &Samples,
        view: &View,
        (f, leaf_size): (usize, usize),
        n_leaves: usize,
        whole: i64,
        switches: &Switches,
    ) {
        self.is_beside = samples.free.is_some() && switches.monotone;
        self.is_monotone = (leaf_size == 1 || self.is_beside) && switches.monotone;
        self.has_range = switches.cost_range;
        self.make_room(view.len + 1);
        self.lay_cuts(samples, view, (f, leaf_size));
        if switches.mixed_labels && self.is_monotone {
            self.mixed.lay(samples, view, f, n_leaves, &self.positions[..self.n_cuts]);
        } else {
            self.mixed.leave_out();
        }
        self.of_all_levels = 0;
        self.has_small = false;
        self.has_least = samples.penalty > 0 && switches.price;
        if self.has_least {
            let mut prices = Prices::new(samples, view, n_leaves, std::mem::take(&mut self.least_of));
            let mut from = 0;
            for (&to, &total_range) in self.positions.iter().zip(&self.total_range).take(self.n_cuts) {
                view.list(f)[from..to as usize].iter().for_each(|&i| samples.count(i, 1, &mut prices.gains));
                prices.push(total_range);
                from = to as usize;
            }
            self.least_of = prices.least;
        } else {
            self.least_of = Default::default();
        }
        let last = self.last();
        self.enter(0, [0, whole], [[0, whole]; 2]);
        self.enter(last, [whole, 0], [[whole, 0]; 2]);
    }

    /// Know what the sides cost that are too small for two leaves (not for a log).
    pub(crate) fn know_small_sides(&mut self, samples: &Samples, view: &View, f: usize) {
        if self.leaf_size > 1 {
            let (positions, range) = (&self.positions[..self.n_cuts], &self.total_range[..self.n_cuts]);
            self.small.lay(samples, view, (f, self.leaf_size), positions, range);
            self.has_small = true;
        }
    }

    /// Lay out the cuts alone.
    pub(crate) fn lay_positions(&mut self, samples: &Samples, view: &View, f: usize) {
        self.make_room(view.len + 1);
        self.lay_cuts(samples, view, (f, samples.leaf_size));
    }

    /// Positions and total ranges: of every sample one, where no two have the same value.
    fn lay_cuts(&mut self, samples: &Samples, view: &View, (f, leaf_size): (usize, usize)) {
        self.leaf_size = leaf_size;
        let smallest = leaf_size.max(1);
        self.n_cuts = 0;
        self.push(0, 0);
        if !samples.has_ties[f] && smallest == 1 && samples.range_of_all.is_some() {
            let each = samples.range_of_all.unwrap_or(0);
            (1..view.len).for_each(|k| self.push(k, k as i64 * each));
        } else {
            let (ranks, list) = (samples.ranks_of(f), view.list(f));
            let mut rank = list.first().map_or(0, |&i| ranks[i as usize]);
            let mut total_range = 0;
            for (k, &i) in list.iter().enumerate() {
                let next = ranks[i as usize];
                if next != rank && k >= smallest && view.len - k >= smallest {
                    self.push(k, total_range);
                }
                rank = next;
                total_range += samples.range_of(i);
            }
        }
        self.push(view.len, view.total_range);
    }

    /// Lists are only ever grown: what lies past the last cut, or belongs to cuts not solved, is never read.
    fn make_room(&mut self, n_cuts: usize) {
        let room = self.positions.len().max(n_cuts);
        self.positions.resize(room, 0);
        for list in [&mut self.total_range, &mut self.left, &mut self.right] {
            list.resize(room, 0);
        }
        if self.is_beside {
            self.free.iter_mut().flatten().for_each(|list| list.resize(room, 0));
        }
    }

    #[inline(always)]
    fn push(&mut self, position: usize, total_range: i64) {
        self.positions[self.n_cuts] = position as u32;
        self.total_range[self.n_cuts] = total_range;
        self.n_cuts += 1;
    }

    /// Enter a solved cut: lower bounds of its children, and of the same with leaves of any size and of `sizes`.
    #[inline(always)]
    pub(crate) fn enter(&mut self, k: usize, bounds: [i64; 2], free: Beside) {
        [self.left[k], self.right[k]] = bounds;
        if self.is_beside {
            for (lists, bounds) in self.free.iter_mut().zip(free) {
                [lists[0][k], lists[1][k]] = bounds;
            }
        }
    }

    /// Bounds of left or right children that hold of all larger ones in the interval.
    #[inline(always)]
    fn grown(&self, side: usize) -> &[i64] {
        match (self.is_beside, side) {
            (true, side) => &self.free[1][side],
            (_, 0) => &self.left,
            _ => &self.right,
        }
    }

    /// Index of the trivial cut at the end.
    pub(crate) fn last(&self) -> usize {
        self.n_cuts - 1
    }

    /// All the cuts that split, None when there are none.
    pub(crate) fn whole(&self) -> Option<Interval> {
        Interval::between(0, self.last())
    }

    /// Take up the bounds of cuts of feature `f` that were solved before; returns their indices, ascending.
    pub(crate) fn take_up(&mut self, f: usize, solved: &[Solved]) -> Vec<usize> {
        let mut cuts = Vec::new();
        for known in solved.iter().filter(|known| known.feature == f) {
            if let Some(k) = self.cut_at(known.position) {
                let free = if self.has_least { [0, 1].map(|side| self.least_of[side][k]) } else { [0, 0] };
                self.enter(k, known.bounds, [free; 2]);
                cuts.push(k);
            }
        }
        cuts.sort_unstable();
        cuts.dedup();
        cuts
    }

    /// The runs of open cuts between solved ones.
    pub(crate) fn gaps<'a>(&'a self, solved: &'a [usize]) -> impl Iterator<Item = Interval> + 'a {
        let ends = std::iter::once(0).chain(solved.iter().copied());
        let others = solved.iter().copied().chain(std::iter::once(self.last()));
        ends.zip(others).filter_map(|(a, b)| Interval::between(a, b))
    }

    /// The cut that splits with so many samples left of it.
    pub(crate) fn cut_at(&self, position: usize) -> Option<usize> {
        let inner = self.positions.get(1..self.last())?;
        inner.binary_search(&(position as u32)).ok().map(|k| k + 1)
    }

    /// Shrink an interval to cuts whose children may cost less than `target` together; None when there are none.
    pub(crate) fn narrow(&self, mut interval: Interval, target: i64) -> Option<Interval> {
        let Interval { a, b, .. } = interval;
        // cost range on both sides: e(L(k)) + e(R(k)) >= e(L(b)) + e(R(a)) - (range(b) - range(a)) for every k between
        if self.has_range && self.left[b] + self.right[a] - (self.total_range[b] - self.total_range[a]) >= target {
            return None;
        }
        if self.is_monotone {
            // monotone on both sides
            let (left, right) = (self.grown(0), self.grown(1));
            if left[a] + right[b] >= target {
                return None;
            }
            if self.has_range {
                // monotone left of k, range right: e(L(a)) + e(R(a)) - (range(k) - range(a)) < target is needed
                let from = self.total_range[a] + left[a] + self.right[a] - target;
                interval.low += self.total_range[interval.low..=interval.high].partition_point(|&m| m <= from);
                let to = self.total_range[b] - (self.left[b] + right[b] - target);
                let kept = self.total_range.get(interval.low..=interval.high)?.partition_point(|&m| m < to);
                if kept == 0 {
                    return None;
                }
                interval.high = interval.low + kept - 1;
            }
        }
        (interval.low <= interval.high).then_some(interval)
    }

    /// Lower bounds of both children of cut `k`, from the solved cuts around it and from prices.
    pub(crate) fn bounds(&self, interval: &Interval, k: usize) -> (i64, i64) {
        self.bounds_of_run(interval, (k, k))
    }

    /// The same of all cuts from one to another.
    #[inline(always)]
    fn bounds_of_run(&self, interval: &Interval, (first, last): (usize, usize)) -> (i64, i64) {
        let (mut left, mut right) = self.by_neighbours(interval, first);
        if first != last {
            right = self.by_neighbours(interval, last).1;
        }
        if self.has_least {
            (left, right) = (left.max(self.least_of[0][first]), right.max(self.least_of[1][last]));
        }
        if self.has_small {
            let leaves = self.small.least(first, last);
            (left, right) = (left.max(leaves[0]), right.max(leaves[1]));
        }
        (left, right)
    }

    /// The same of a solved cut with leaves of any size.
    pub(crate) fn free_at(&self, k: usize) -> [i64; 2] {
        if self.is_beside { [0, 1].map(|side| self.free[0][side][k]) } else { [0, 0] }
    }

    /// The same of their trees with leaves of any size, and with leaves of `sizes`.
    pub(crate) fn free_bounds(&self, interval: &Interval, k: usize) -> Beside {
        if !self.is_beside {
            return Beside::default();
        }
        let Interval { a, b, .. } = *interval;
        let between = [self.between(a, k), self.between(k, b)];
        let [mut free, grown] = [0, 1].map(|of| [self.free[of][0][a] + between[0], self.free[of][1][b] + between[1]]);
        if self.has_range {
            free[0] = free[0].max(self.free[0][0][b] - (self.total_range[b] - self.total_range[k]));
            free[1] = free[1].max(self.free[0][1][a] - (self.total_range[k] - self.total_range[a]));
        }
        if self.has_least {
            free = [0, 1].map(|side| free[side].max(self.least_of[side][k]));
        }
        let free = free.map(|bound| bound.max(0));
        [free, [0, 1].map(|side| free[side].max(grown[side]))]
    }

    /// Sizes of leaves for which the left child of cut `k` bounds those of the cuts after it in the interval, and the
    /// right child those of the cuts before it (monotone, above).
    pub(crate) fn sizes(&self, interval: &Interval, k: usize) -> [usize; 2] {
        let [low, k, high] = [interval.low, k, interval.high].map(|cut| self.positions[cut] as usize);
        [high - k, k - low].map(|width| self.leaf_size.saturating_sub(width).max(1))
    }

    #[inline]
    fn by_neighbours(&self, interval: &Interval, k: usize) -> (i64, i64) {
        let Interval { a, b, .. } = *interval;
        let (mut left, mut right) = (0, 0);
        if self.has_range {
            left = self.left[b] - (self.total_range[b] - self.total_range[k]);
            right = self.right[a] - (self.total_range[k] - self.total_range[a]);
        }
        if self.is_monotone {
            left = left.max(self.grown(0)[a] + self.between(a, k));
            right = right.max(self.grown(1)[b] + self.between(k, b));
        }
        (left.max(0), right.max(0))
    }

    /// Least cost of the samples between two cuts under as many labels as a child has leaves.
    #[inline]
    fn between(&self, from: usize, to: usize) -> i64 {
        let n = self.positions[to] - self.positions[from];
        self.mixed.cost((from, to), n, self.total_range[to] - self.total_range[from])
    }

    /// Lower bound of the children of any cut of an interval.
    pub(crate) fn least(&self, interval: &Interval) -> i64 {
        let bounds = (interval.low..=interval.high).map(|k| self.together(self.bounds(interval, k)));
        bounds.min().unwrap_or(i64::MAX)
    }

    /// The open cut nearest the middle of the interval whose children's bounds stay below `target`.
    pub(crate) fn pick(&self, interval: &Interval, target: i64) -> Option<usize> {
        let middle = interval.low + (interval.high - interval.low) / 2;
        if self.mixed.is_nothing() && !self.has_least && !self.has_small {
            return Some(middle);
        }
        interval.nearest(middle, target, |first, last| self.together(self.bounds_of_run(interval, (first, last))))
    }

    /// Cost range between `k` and the farther end of the interval: what a child's bound is worth to its neighbours.
    pub(crate) fn slack(&self, interval: &Interval, k: usize) -> i64 {
        (self.total_range[k] - self.total_range[interval.low])
            .max(self.total_range[interval.high] - self.total_range[k])
    }
}

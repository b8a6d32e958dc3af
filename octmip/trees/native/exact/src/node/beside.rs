//! A problem of leaves of a least size beside its free one, in which leaves may have any size.
//!
//! The free problem is nearly free to solve, and a relaxation: `e_s(S) >= e(S)`, with `e_s` the least cost where leaves
//! hold `s` samples or more, `e` where they may have any size. Its bounds are monotone, and those of `e_s` are not. So
//!
//! * the free problem of a node is solved first. Where it costs the budget or more the node is closed; where its tree
//!   has large leaves, or can be given them at no cost, it is the best one of both problems;
//! * else the cuts of the node are searched with two pairs of bounds (`axis`), for trees below `e + 1`, then below more
//!   and more: what such a search finds is the best tree, and what it does not find bounds the node;
//! * a cut is solved in the free problem first, with slack; only where both its sides together stay below the target
//!   they are solved again with their own size, and with little slack;
//! * in a narrow run of cuts they are solved with smaller leaves before that, of as many samples as a large leaf keeps
//!   of its own in the farthest cut of the run (`axis`), without slack, and not in the free problem where these are
//!   half as large or more: what trees of smaller leaves cost bounds `e_s` as `e` does.
//!
//! Wherever a bound of `e` is used in the place of one of `e_s` it is lower, so nothing is lost.

use crate::node::axis::{Axis, Beside};
use crate::node::children::{Both, Children};
use crate::node::kept::Kept;
use crate::node::log::Log;
use crate::node::plan::Plan;
use crate::node::result::{FeatureIncumbent, NodeResult, Solved};
use crate::node::search::{Cut, Search};
use crate::samples::Samples;
use crate::stumps::place::{Place, Stump, StumpSolver};
use crate::view::View;
use octmip_frame::interval::Interval;

/// Shares of what the free tree of a node costs by which trees may cost more at first: one in so many.
const FIRST: i64 = 64;

/// Share of the least size whose usual cost is the slack of a child: without any it closes few neighbours, and much
/// more is seldom reached.
const SLACK: usize = 4;

/// The first step above what the free problem costs, a cost of the usual size of one sample at least.
pub(crate) fn first_step(free: i64, view: &View) -> i64 {
    (free / FIRST).max(view.total_range / (view.len as i64).max(1)).max(1)
}

impl<'a> Search<'a> {
    /// The samples that histograms count: leaves of any size.
    pub(super) fn free_samples(&self) -> &'a Samples {
        self.samples.free.as_deref().unwrap_or(self.samples)
    }

    /// The search that the stump solvers belong to.
    pub(super) fn of_stumps(&mut self) -> &mut Search<'a> {
        match self.free {
            Some(ref mut free) => free,
            None => self,
        }
    }

    /// The best tree of at most `depth` levels below `upper`, what its free problem costs being known.
    pub(super) fn beside(
        &mut self,
        view: &View,
        depth: usize,
        upper: i64,
        floor: i64,
        (free, is_child): (NodeResult, bool),
    ) -> NodeResult {
        let Some((cost, plan)) = free.best.filter(|_| !self.is_stopped()) else {
            return NodeResult::none(free.lower.max(floor));
        };
        let mut best = match self.fitted(view, &plan) {
            Some((cost, plan)) => NodeResult::cheapest(cost, plan, upper),
            None => NodeResult::none(upper),
        };
        if self.takes_first {
            // So does the search of the free problem: its tree is no bound.
            return if best.best.is_some() { best } else { self.by_cuts(view, depth, upper, floor) };
        }
        let floor = floor.max(cost);
        // The budget of a child is little above its free cost; and a log names the cuts once, of the last step.
        let mut step = if is_child || self.log.is_some() { i64::MAX } else { first_step(cost, view) };
        let mut proven = floor;
        while proven < best.cost(upper) && !self.is_stopped() {
            let asked = best.cost(upper).min(proven.max(cost).saturating_add(step));
            let found = self.by_cuts(view, depth, asked, floor);
            if found.best.is_some() {
                best = found;
                break;
            }
            (proven, step) = (asked, step.saturating_mul(2));
        }
        best.closed(upper)
    }

    /// A tree of a plan on a view whose leaves are large enough, last splits chosen anew; splits that leave a side too
    /// small are dropped.
    pub(crate) fn fitted(&mut self, view: &View, plan: &Plan) -> Option<(i64, Plan)> {
        let leaf = (view.leaf(), Plan::Leaf);
        let found = match plan {
            Plan::Leaf => None,
            Plan::Stump => Some((self.fitting.whole(self.samples, view, self.leaf_size, leaf.0).value, Plan::Stump)),
            Plan::Split { feature, cut, sides } => {
                let ranks = self.samples.ranks_of(*feature);
                let k = view.list(*feature).partition_point(|&i| ranks[i as usize] <= *cut);
                let small = [k, view.len - k].map(|len| len < self.leaf_size);
                if small[0] || small[1] {
                    return self.fitted(view, &sides[usize::from(small[0])]);
                }
                let [left, right] = [0, 1].map(|side| {
                    let part = view.side(self.samples, *feature, k, side);
                    self.fitted(&part, &sides[side])
                });
                let ((left, left_plan), (right, right_plan)) = (left?, right?);
                let sides = Box::new([left_plan, right_plan]);
                Some((left + right + self.samples.penalty, Plan::Split { feature: *feature, cut: *cut, sides }))
            }
            Plan::Whole(tree) => return self.fitted(view, &Plan::of(self.samples, tree)?),
        };
        Some(found.filter(|found| found.0 < leaf.0).unwrap_or(leaf))
    }

    /// Trees of fewer levels on a node: of the free problem, where one stands beside. With the cuts solved at their
    /// root, and each feature's incumbent.
    pub(crate) fn shallower(
        &mut self,
        view: &View,
        depth: usize,
        upper: i64,
        floor: i64,
    ) -> (NodeResult, Vec<Solved>, Vec<FeatureIncumbent>) {
        let result = match self.free.as_deref_mut() {
            Some(free) => free.solve(view, depth, upper, 0),
            None => self.solve(view, depth, upper, floor),
        };
        let searched = self.of_stumps();
        (result, std::mem::take(&mut searched.solved), std::mem::take(&mut searched.incumbents))
    }

    /// The record of the node last closed by the search that `shallower` asks.
    pub(crate) fn last_record(&mut self) -> Option<String> {
        self.of_stumps().log.as_mut().and_then(Log::take)
    }

    /// The best stump of a view by its best free one; exact below `upper`.
    pub(super) fn fitting_stump(&mut self, solver: &dyn StumpSolver, view: &View, free: Stump, upper: i64) -> i64 {
        if self.free.is_none() {
            return free.value;
        }
        let (place, sizes) = (Place::whole(view), [self.leaf_size]);
        self.fitting.stump(self.samples, &place, (1, sizes), upper, solver.sums(1), |f| solver.reach(f, 1))[0].value
    }

    /// Best stumps of both sides of cut `k` of an interval by their best free ones: exact unless their bounds reach the
    /// target of the cut or `threshold` together. And what bounds neighbouring cuts.
    pub(super) fn fitting_stumps(
        &mut self,
        solver: &dyn StumpSolver,
        place: &Place<'_>,
        threshold: i64,
        mut stumps: [Stump; 2],
        (axis, interval, k): (&Axis, &Interval, usize),
    ) -> ([Stump; 2], Beside) {
        let free = stumps.map(|stump| stump.lower);
        if self.free.is_none() {
            return (stumps, [free; 2]);
        }
        let (bounds, sizes) = (axis.bounds(interval, k), self.near(axis.sizes(interval, k)));
        let mut within = axis.free_bounds(interval, k)[1];
        for (side, bound) in [bounds.0, bounds.1].into_iter().enumerate() {
            within[side] = within[side].max(free[side]);
            stumps[side].lower = within[side].max(bound);
        }
        let first = usize::from(2 * place.k > place.view.len); // the smaller one fails sooner
        for side in [first, 1 - first].into_iter().filter(|&side| place.leaf_side != Some(side)) {
            let upper = threshold - stumps[1 - side].lower;
            if stumps[0].lower + stumps[1].lower >= place.target {
                stumps[side].value = i64::MAX; // none is known, none is wanted
                continue;
            }
            let sizes = [sizes[side], self.leaf_size];
            let (sums, reach) = (solver.sums(side), |f| solver.reach(f, side));
            let [near, own] = self.fitting.stump(self.samples, place, (side, sizes), upper, sums, reach);
            within[side] = within[side].max(near.lower);
            stumps[side] = Stump { lower: own.lower.max(stumps[side].lower), ..own };
        }
        (stumps, [free, within])
    }

    /// Sizes of leaves for bounds of neighbouring cuts: any, where a log is written, which has no line for others.
    fn near(&self, sizes: [usize; 2]) -> [usize; 2] {
        if self.log.is_some() { [1, 1] } else { sizes }
    }

    /// Solve both children of a cut, in the free problem first.
    pub(super) fn children_beside(&mut self, view: &View, depth: usize, cut: &Cut, sides: &mut [View; 2]) -> Children {
        let mut children =
            Children { bounds: cut.bounds, free: cut.free, tree: None, record: String::new(), kept: Kept::default() };
        let (own, near) = (self.leaf_size, self.near(cut.sizes));
        // In a narrow run the leaves of any size tell little more than those nearly as large as wanted.
        let both = match self.free.as_deref_mut().filter(|_| 2 * near[0].min(near[1]) <= own) {
            Some(free) => free.both(view, depth, cut, cut.free[0], sides),
            None => {
                let plans = cut.free[1].map(|bound| Some((bound, Plan::Leaf)));
                Some(Both { bounds: cut.free[0], plans, records: [None, None], is_split: false })
            }
        };
        let Some(Both { bounds: free, plans, records, is_split }) = both else { return children };
        let mut records = [records, [None, None]];
        let mut within = [0, 1].map(|side| cut.free[1][side].max(free[side]));
        let mut bounds = [0, 1].map(|side| cut.bounds[side].max(within[side]));
        if bounds[0] + bounds[1] < cut.target && !is_split {
            self.split(view, cut, sides);
        }
        let first = usize::from(2 * cut.position > view.len); // the smaller one fails sooner
        let mut found = [None, None];
        let mut results = plans.map(|plan| plan.map(|(cost, plan)| NodeResult::found(cost, plan)));
        let usual = view.total_range / (view.len as i64).max(1);
        for (sizes, is_own) in [(near, false), ([own; 2], true)] {
            let slack = if is_own { cut.slack.min((own / SLACK) as i64 * usual) } else { 0 };
            for side in [first, 1 - first].into_iter().filter(|&side| is_own || sizes[side] > 1) {
                if bounds[0] + bounds[1] >= cut.target {
                    break;
                }
                let (budget, floor) = (cut.target + slack - bounds[1 - side], [within[side], bounds[side]]);
                self.leaf_size = sizes[side];
                let known = results[side].take();
                let result = self.solve_beside(&sides[side], depth - 1, budget, floor[usize::from(is_own)], known);
                self.leaf_size = own;
                if self.is_stopped() {
                    return Children { bounds: cut.bounds, free: cut.free, ..children };
                }
                bounds[side] = bounds[side].max(result.lower);
                if is_own {
                    found[side] = result.best;
                    records[1][side] = self.log.as_mut().and_then(Log::take);
                } else {
                    within[side] = within[side].max(result.lower);
                    results[side] = Some(result);
                }
            }
        }
        self.log_cut(view, cut, &records);
        children.free = [free, within];
        Children { bounds, tree: self.joined(view, cut, found), ..children }
    }
}

//! The best tree of at most two levels: bisection over the cuts of the root, both children solved by best stumps; or of
//! at most two splits, where one of the children is a leaf.

use crate::node::plan::Plan;
use crate::node::result::{FeatureIncumbent, NodeResult, Solved};
use crate::node::search::Search;
use crate::stumps::place::{Place, StumpSolver};
use crate::view::View;
use octmip_frame::interval::Interval;

/// The side of the root's cut that is a leaf, if one has to be.
type LeafSide = Option<usize>;

impl Search<'_> {
    /// The best tree of at most two levels if it costs less than `upper`, else the proof that none does.
    ///
    /// `floor` is a bound known beforehand: a tree that costs no more ends the search.
    pub(crate) fn depth_two(&mut self, view: &View, upper: i64, floor: i64) -> NodeResult {
        self.two_levels(view, upper, floor, &[None])
    }

    /// The same of at most two splits.
    pub(crate) fn two_splits(&mut self, view: &View, upper: i64, floor: i64) -> NodeResult {
        self.two_levels(view, upper, floor, &[Some(0), Some(1)])
    }

    fn two_levels(&mut self, view: &View, upper: i64, floor: i64, leaf_sides: &[LeafSide]) -> NodeResult {
        let leaf = view.leaf();
        if upper <= floor {
            return NodeResult::none(floor);
        }
        if leaf <= floor.max(self.samples.penalty) || view.len < 2 * self.leaf_size {
            return NodeResult::cheapest(leaf, Plan::Leaf, upper);
        }
        let mut solver = self.take_solver(view);
        let stump = solver.load(self.free_samples(), view);
        self.n_evaluated += 1;
        let scores = solver.scores().to_vec();
        let value = self.fitting_stump(&*solver, view, stump, upper);
        let mut best = NodeResult::cheapest(value, Plan::Stump, upper);
        self.incumbents.clear();
        self.solved.clear();
        self.incumbents.resize(self.samples.p, FeatureIncumbent::NOTHING);
        for f in self.features_by(|f| -scores[f]) {
            for &leaf_side in leaf_sides {
                if best.cost(upper) <= floor || self.is_stopped() {
                    break;
                }
                self.depth_two_feature(&mut *solver, view, (f, leaf_side), stump.lower, upper, &mut best);
            }
            self.report_effort();
        }
        self.report_effort();
        self.return_solver(view, solver);
        best.closed(upper)
    }

    fn depth_two_feature(
        &mut self,
        solver: &mut dyn StumpSolver,
        view: &View,
        (f, leaf_side): (usize, LeafSide),
        whole: i64,
        upper: i64,
        best: &mut NodeResult,
    ) {
        let samples = self.samples;
        let mut current = best.cost(upper);
        let holding = view.holding(f);
        let view = holding.as_ref().unwrap_or(view);
        let mut axis = std::mem::take(&mut self.axis);
        axis.lay(samples, view, (f, self.leaf_size), 2, whole, &self.switches);
        if self.switches.free && self.log.is_none() {
            axis.know_small_sides(samples, view, f);
        }
        axis.want_levels(samples, 1);
        if let Some(side) = leaf_side {
            axis.take_up_leaves(samples, view, f, side);
        }
        let mut is_fresh = true;
        let mut counted = Vec::new();
        let mut open: Vec<Interval> = axis.whole().into_iter().collect();
        while let Some(interval) = open.pop() {
            let target = current - samples.penalty;
            let Some(interval) = axis.narrow(interval, target) else {
                continue;
            };
            let Some(k) = axis.pick(&interval, target) else {
                continue;
            };
            if self.is_stopped() {
                break;
            }
            let threshold = target + if self.switches.slack { axis.slack(&interval, k) } else { 0 };
            if std::mem::take(&mut is_fresh) {
                solver.rewind();
            }
            let k_left = axis.positions[k] as usize;
            let place = Place::new(samples, view, f, k_left, target).with_leaf(leaf_side);
            let stumps = solver.both(self.free_samples(), &place, threshold);
            counted.push(k_left as u32);
            self.n_evaluated += 1;
            let around = (&axis, &interval, k);
            let ([left, right], free) = self.fitting_stumps(&*solver, &place, threshold, stumps, around);
            axis.enter(k, [left.lower, right.lower], free);
            if samples.penalty > 0 {
                self.solved.push(Solved { feature: f, position: k_left, bounds: free[0] });
            }
            let cost = left.value.saturating_add(right.value).saturating_add(samples.penalty);
            self.incumbents[f].see(cost, k_left);
            if cost < current {
                current = cost;
                let sides = [0, 1].map(|side| if leaf_side == Some(side) { Plan::Leaf } else { Plan::Stump });
                *best = NodeResult::found(cost, Plan::split(samples, view, f, place.k, sides));
            }
            open.extend(interval.halves(k).into_iter().rev().flatten());
        }
        if let Some(log) = &mut self.log {
            samples.rows_left(view.list(f), &mut counted);
            log.counted(samples.features[f], &mut counted);
        }
        self.axis = axis;
    }
}

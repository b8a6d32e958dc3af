//! Branch and bound over the cuts of the root, children solved by the same search one level lower.

use std::collections::VecDeque;

use crate::node::axis::{Axis, Beside};
use crate::node::by_values::ByValues;
use crate::node::kept::{Seen, Shared, keeps};
use crate::node::log::Log;
use crate::node::plan::Plan;
use crate::node::price::at_all_levels;
use crate::node::result::{FeatureIncumbent, NodeResult, Solved};
use crate::samples::Samples;
use crate::stumps::fitting::Fitting;
use crate::stumps::place::StumpSolver;
use crate::stumps::{solver, width};
use crate::switches::Switches;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::interval::Interval;

/// A cut to be solved.
#[derive(Debug, Clone, Copy)]
pub struct Cut {
    /// Usable feature.
    pub feature: usize,
    /// Samples left of it.
    pub position: usize,
    /// Known lower bounds of both children.
    pub bounds: [i64; 2],
    /// The same with leaves of any size, and with leaves of `sizes`; 0 where that is the problem itself.
    pub free: Beside,
    /// Sizes of leaves for which the children bound neighbouring cuts.
    pub sizes: [usize; 2],
    /// Both children together must cost less.
    pub target: i64,
    /// Whether leaves may have any size, where the problem's have a least one.
    pub is_free: bool,
    /// Worth of a child's bound to neighbouring cuts.
    pub slack: i64,
}

/// Buffers of one level of the recursion.
#[derive(Debug, Default)]
struct Level {
    axis: Axis,
    sides: [View; 2],
    queue: VecDeque<Interval>,
    takes_first: bool,
}

/// One thread's search: workspaces and counters.
pub struct Search<'a> {
    /// Samples that are searched.
    pub(crate) samples: &'a Samples,
    /// Fewest samples in a leaf: those of the samples, or less where neighbouring cuts are to be bounded.
    pub(super) leaf_size: usize,
    /// Prunes that are on.
    pub(crate) switches: Switches,
    /// Cuts evaluated by stumps.
    pub(crate) n_evaluated: u64,
    /// Incumbent of each feature at the root of the last search (`p`).
    pub(crate) incumbents: Vec<FeatureIncumbent>,
    /// The cuts solved at the root of the last search of two levels or more, feature after feature, where a split has a
    /// price.
    pub(crate) solved: Vec<Solved>,
    /// Whether any tree below the budget will do: the search ends with the first one at its root.
    pub(crate) takes_first: bool,
    /// The records of what is proven, when a proof is written.
    pub(crate) log: Option<Log>,
    pub(super) axis: Axis,
    control: &'a Control,
    levels: Vec<Level>,
    solvers: [Option<Box<dyn StumpSolver>>; 3],
    pub(super) marks: Vec<bool>,
    /// Whether results are kept: where nodes are met again, for trees of four levels or more that pay for splits.
    pub(super) keeps: bool,
    pub(super) known: Seen<'a>,
    pub(super) by_values: ByValues,
    /// The search of the same problem with leaves of any size, where its bounds are carried beside.
    pub(super) free: Option<Box<Search<'a>>>,
    pub(super) fitting: Fitting,
    pub(super) totals: Vec<i64>,
}

impl<'a> Search<'a> {
    /// Workspaces for searches of at most `depth` levels.
    pub fn new(samples: &'a Samples, switches: Switches, control: &'a Control, depth: usize) -> Self {
        Self {
            samples,
            leaf_size: samples.leaf_size,
            switches,
            n_evaluated: 0,
            incumbents: Vec::new(),
            solved: Vec::new(),
            takes_first: false,
            log: None,
            axis: Axis::default(),
            control,
            levels: (0..=depth).map(|_| Level::default()).collect(),
            solvers: [None, None, None],
            marks: vec![false; samples.n],
            keeps: keeps(samples, &switches, depth),
            known: Seen::default(),
            by_values: ByValues::default(),
            free: samples.free.as_deref().map(|free| Box::new(Search::new(free, switches, control, depth))),
            fitting: Fitting::default(),
            totals: Vec::new(),
        }
    }

    /// The same for cuts of a root whose trees have `last` levels at most: it sees what other cuts have shown.
    pub(crate) fn sharing(mut self, shared: &'a Shared, last: usize) -> Self {
        self.keeps = keeps(self.samples, &self.switches, last);
        self.known = Seen::of(shared);
        if let Some(free) = &mut self.free {
            free.keeps = self.keeps;
        }
        self
    }

    /// The same with a log of what is proven, of the free problem too.
    pub(crate) fn logging(mut self) -> Self {
        self.log = Some(Log::default());
        self.free = self.free.map(|free| Box::new(free.logging()));
        self
    }

    /// Whether the search is stopped; what is returned after that proves nothing.
    pub fn is_stopped(&self) -> bool {
        self.control.is_stopped()
    }

    /// The best tree of at most `depth` levels if it costs less than `upper`, else the proof that none does.
    pub(crate) fn solve(&mut self, view: &View, depth: usize, upper: i64, floor: i64) -> NodeResult {
        self.solve_beside(view, depth, upper, floor, None)
    }

    /// The same, where the free problem of the node may be solved: its record then need not be written again.
    pub(super) fn solve_beside(
        &mut self,
        view: &View,
        depth: usize,
        upper: i64,
        floor: i64,
        free: Option<NodeResult>,
    ) -> NodeResult {
        let least = free.as_ref().map(|free| free.lower);
        let Some(log) = &mut self.log else {
            return self.solve_unlogged(view, depth, upper, floor, free);
        };
        let outer = log.open();
        if upper <= floor {
            log.pass_over(outer);
            return NodeResult::none(floor);
        }
        let result = self.solve_unlogged(view, depth, upper, 0, free);
        if let Some(log) = self.log.as_mut().filter(|_| least.is_some_and(|least| result.lower <= least)) {
            log.pass_over(outer);
            return result;
        }
        let base: i64 = view.ids(self.samples).map(|i| self.samples.base[i as usize]).sum();
        if let Some(log) = &mut self.log {
            log.close(outer, depth, self.samples.leaf_size, base + self.samples.cost(result.lower));
        }
        result
    }

    pub(super) fn searched(&mut self, view: &View, depth: usize, upper: i64, floor: i64) -> NodeResult {
        match &mut self.free {
            Some(free) => {
                // Not where results are kept: the first tree is no bound.
                free.takes_first = self.takes_first && !self.keeps;
                let result = free.solve(view, depth, upper, 0);
                free.takes_first = false;
                self.beside(view, depth, upper, floor, (result, false))
            }
            None => self.by_cuts(view, depth, upper, floor),
        }
    }

    /// The same by a search of the node's own cuts.
    pub(super) fn by_cuts(&mut self, view: &View, depth: usize, upper: i64, floor: i64) -> NodeResult {
        if depth == 2 { self.depth_two(view, upper, floor) } else { self.deep(view, depth, upper, floor) }
    }

    /// The price that bounds are allowed to see; 0 where a split costs nothing.
    pub(super) fn price(&self) -> i64 {
        if self.switches.price { self.samples.penalty } else { 0 }
    }

    pub(super) fn depth_one(&mut self, view: &View, upper: i64) -> NodeResult {
        let mut solver = self.take_solver(view);
        let stump = solver.load(self.free_samples(), view);
        let value = self.fitting_stump(&*solver, view, stump, upper);
        self.return_solver(view, solver);
        self.n_evaluated += 1;
        NodeResult::cheapest(value, Plan::Stump, upper)
    }

    fn deep(&mut self, view: &View, depth: usize, upper: i64, floor: i64) -> NodeResult {
        let takes_first = std::mem::take(&mut self.takes_first);
        self.levels[depth].takes_first = takes_first;
        let leaf = view.leaf();
        // One level shallower first: its tree is an incumbent, its cost bounds the children of the trivial cuts, and
        // the features are taken in the order of their incumbents.
        let mut best = NodeResult::cheapest(leaf, Plan::Leaf, upper);
        let mut whole = 0;
        let mut fewer = Vec::new();
        let mut open = vec![true; self.samples.p];
        let mut order: Vec<usize> = (0..self.samples.p).collect();
        if depth == 3 {
            self.prepare(view);
        }
        let shallower = if self.keeps && self.samples.has_few_boxes() { 2 } else { depth - 1 };
        if self.switches.shallower_first {
            if shallower < depth - 1 {
                self.forget();
            }
            let (result, solved, incumbents) = self.shallower(view, shallower, leaf + 1, floor);
            whole = at_all_levels(result.lower, shallower, depth - 1, self.price());
            fewer = solved;
            let record = self.last_record();
            if let Some(log) = self.log.as_mut().filter(|_| depth > 2) {
                log.shallower(record);
            }
            if self.free.is_none() && result.cost(i64::MAX) < best.cost(upper) {
                best = result;
            }
            if incumbents.len() == self.samples.p {
                order = self.features_by(|f| incumbents[f].cost);
            }
            // Trees of fewer levels are known, and those of more pay for as many splits.
            let are_known = self.price() > 0 && self.free.is_none();
            if are_known && best.cost(upper) <= self.price().saturating_mul(shallower as i64 + 1) {
                self.solved = fewer; // as good as solved at this level
                return best.closed(upper);
            }
            open = self.open_features(view, depth, best.cost(upper), whole);
            if !open.contains(&true) {
                self.solved = fewer;
                return best.closed(upper);
            }
        }
        let mut incumbents = vec![FeatureIncumbent::NOTHING; self.samples.p];
        let mut solved = Vec::new();
        for f in order.into_iter().filter(|&f| open[f]) {
            let is_done = takes_first && best.best.is_some();
            if best.cost(upper) <= floor || is_done || self.is_stopped() {
                break;
            }
            let before = best.cost(upper);
            let result =
                self.deep_feature(view, depth, (f, &fewer, whole, shallower), before, &mut incumbents[f], &mut solved);
            if result.cost(i64::MAX) < before {
                best = result;
            }
        }
        self.incumbents = incumbents;
        self.solved = solved;
        best.closed(upper)
    }

    /// The best tree with feature `f` at its root, if it costs less than `upper`.
    fn deep_feature(
        &mut self,
        view: &View,
        depth: usize,
        (f, fewer, whole, shallower): (usize, &[Solved], i64, usize),
        upper: i64,
        seen: &mut FeatureIncumbent,
        solved: &mut Vec<Solved>,
    ) -> NodeResult {
        let samples = self.samples;
        let mut level = std::mem::take(&mut self.levels[depth]);
        level.axis.lay(samples, view, (f, self.leaf_size), 1 << (depth - 1).min(20), whole, &self.switches);
        if self.switches.free && self.log.is_none() {
            level.axis.know_small_sides(samples, view, f);
        }
        if self.switches.shallower_first && self.free.is_none() {
            level.axis.want_levels(samples, shallower);
            level.axis.take_up_fewer(f, fewer);
        }
        level.queue.clear();
        level.queue.extend(level.axis.whole());
        let mut best = NodeResult::none(upper);
        while let Some(interval) = level.queue.pop_front() {
            let target = best.cost(upper) - samples.penalty;
            let Some(interval) = level.axis.narrow(interval, target) else {
                continue;
            };
            let Some(k) = level.axis.pick(&interval, target) else {
                continue;
            };
            let slack = if self.switches.slack { level.axis.slack(&interval, k) } else { 0 };
            let cut = Cut {
                feature: f,
                position: level.axis.positions[k] as usize,
                bounds: level.axis.bounds(&interval, k).into(),
                free: level.axis.free_bounds(&interval, k),
                sizes: level.axis.sizes(&interval, k),
                target,
                is_free: false,
                slack,
            };
            let children = self.children(view, depth, &cut, &mut level.sides);
            if self.is_stopped() {
                break;
            }
            level.axis.enter(k, children.bounds, children.free);
            if samples.penalty > 0 {
                let bounds = if self.free.is_some() { children.free[0] } else { children.bounds };
                solved.push(Solved { feature: f, position: cut.position, bounds });
            }
            if let Some((cost, plan)) = children.tree {
                seen.see(cost, cut.position);
                if cost < best.cost(upper) {
                    best = NodeResult::found(cost, plan);
                    if level.takes_first {
                        break;
                    }
                }
            }
            level.queue.extend(interval.halves(k).into_iter().flatten());
        }
        self.levels[depth] = level;
        best.closed(upper)
    }

    /// Whether a leaf is best without a look at the cuts.
    pub(crate) fn is_leaf_best(&self, (leaf, len): (i64, usize), depth: usize, floor: i64) -> bool {
        let is_cheap = leaf <= floor.max(self.samples.penalty) || self.samples.n_labels == 1;
        depth == 0 || is_cheap || len < 2 * self.leaf_size || self.samples.p == 0
    }

    /// Add the cuts evaluated here to those of the other threads.
    pub(crate) fn report_effort(&mut self) {
        let n_counted = std::mem::take(&mut self.by_values.n_counted);
        self.control.add(std::mem::take(&mut self.n_evaluated) + n_counted);
        if let Some(free) = &mut self.free {
            free.report_effort();
        }
    }

    /// Features ordered by a key, ties by index.
    pub(super) fn features_by(&self, key: impl Fn(usize) -> i64) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.samples.p).collect();
        if self.switches.feature_order {
            order.sort_by_key(|&f| key(f));
        }
        order
    }

    /// Lay out the buckets that the children of this view share.
    pub fn prepare(&mut self, view: &View) {
        self.forget();
        let mut own = self.take_solver(view);
        own.prepare(self.free_samples(), view);
        self.return_solver(view, own);
    }

    /// Forget what was laid out: the samples that follow are not a part of those before.
    pub(crate) fn forget(&mut self) {
        let searched = self.of_stumps();
        searched.solvers.iter_mut().flatten().for_each(|solver| solver.forget());
    }

    /// The stump solver for a view of this total range.
    pub(super) fn take_solver(&mut self, view: &View) -> Box<dyn StumpSolver> {
        let searched = self.of_stumps();
        searched.solvers[width(view.total_range)]
            .take()
            .unwrap_or_else(|| solver(searched.samples, view.total_range, &searched.switches))
    }

    /// Give the solver back.
    pub(super) fn return_solver(&mut self, view: &View, solver: Box<dyn StumpSolver>) {
        self.of_stumps().solvers[width(view.total_range)] = Some(solver);
    }
}

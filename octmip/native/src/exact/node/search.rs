//! Branch and bound over the cuts of the root, children solved by the same search one level lower.

use std::collections::VecDeque;

use crate::exact::effort::Control;
use crate::exact::node::axis::{Axis, Interval};
use crate::exact::node::log::Log;
use crate::exact::node::plan::Plan;
use crate::exact::node::result::{Answer, Reached};
use crate::exact::samples::Samples;
use crate::exact::stumps::place::Stumps;
use crate::exact::stumps::{finder, width};
use crate::exact::switches::Switches;
use crate::exact::view::View;

/// A cut to be solved.
#[derive(Debug, Clone, Copy)]
pub struct Cut {
    /// Usable feature.
    pub feature: usize,
    /// Samples left of it.
    pub position: usize,
    /// Known lower bounds of both children.
    pub bounds: [i64; 2],
    /// Both children together must cost less.
    pub target: i64,
    /// What a child's bound is worth to neighbouring cuts.
    pub slack: i64,
}

/// What became of a cut.
#[derive(Debug)]
pub struct Children {
    /// Lower bounds of both children.
    pub bounds: [i64; 2],
    /// Cost and plan when both were found, the cut itself included.
    pub tree: Option<(i64, Plan)>,
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
    /// What is searched.
    pub samples: &'a Samples,
    /// Which prunes are on.
    pub switches: Switches,
    /// Cuts evaluated by stumps.
    pub n_evaluated: u64,
    /// Best cut seen of each feature at the root of the last search (`p`).
    pub attained: Vec<Reached>,
    /// Whether any tree below the budget will do: the search ends with the first one at its root.
    pub takes_first: bool,
    /// The records of what is proven, when a proof is written.
    pub(crate) log: Option<Log>,
    pub(super) axis: Axis,
    pub(super) positions: Vec<u32>,
    control: &'a Control,
    levels: Vec<Level>,
    finders: [Option<Box<dyn Stumps>>; 3],
    marks: Vec<bool>,
}

impl<'a> Search<'a> {
    /// Workspaces for searches of at most `depth` levels.
    pub fn new(samples: &'a Samples, switches: Switches, control: &'a Control, depth: usize) -> Self {
        Self {
            samples,
            switches,
            n_evaluated: 0,
            attained: Vec::new(),
            takes_first: false,
            log: None,
            axis: Axis::default(),
            positions: vec![0; samples.n],
            control,
            levels: (0..=depth).map(|_| Level::default()).collect(),
            finders: [None, None, None],
            marks: vec![false; samples.n],
        }
    }

    /// Whether someone said stop; what is returned after that proves nothing.
    pub fn is_stopped(&self) -> bool {
        self.control.is_stopped()
    }

    /// The best tree of at most `depth` levels if it costs less than `upper`, else the proof that none does.
    pub fn solve(&mut self, view: &View, depth: usize, upper: i64, floor: i64) -> Answer {
        let Some(log) = &mut self.log else {
            return self.solve_unlogged(view, depth, upper, floor);
        };
        let outer = log.open();
        if upper <= floor {
            log.pass_over(outer);
            return Answer::none(floor);
        }
        let answer = self.solve_unlogged(view, depth, upper, 0);
        let base: i64 = view.ids(self.samples).map(|i| self.samples.base[i as usize]).sum();
        if let Some(log) = &mut self.log {
            log.close(outer, depth, self.samples.leaf_size, base + answer.lower);
        }
        answer
    }

    fn solve_unlogged(&mut self, view: &View, depth: usize, upper: i64, floor: i64) -> Answer {
        if upper <= floor {
            return Answer::none(floor);
        }
        let leaf = view.leaf();
        let is_leaf_best = leaf <= floor.max(self.samples.penalty) || self.samples.n_columns == 1;
        if depth == 0 || is_leaf_best || view.len < 2 * self.samples.leaf_size || self.samples.p == 0 {
            return Answer::cheapest(leaf, Plan::Leaf, upper);
        }
        if self.label_bound(view, depth) >= upper {
            return Answer::none(upper);
        }
        match depth {
            1 => self.depth_one(view, upper),
            2 => self.depth_two(view, upper, floor),
            _ => self.deep(view, depth, upper, floor),
        }
    }

    /// A tree of this depth predicts at most `2^depth` labels: the samples of all others are lost.
    fn label_bound(&self, view: &View, depth: usize) -> i64 {
        let n_leaves = 1usize << depth.min(20);
        if !self.switches.label_count || !self.samples.is_single || self.samples.n_columns <= n_leaves {
            return 0;
        }
        let mut totals = view.totals.clone();
        totals.sort_unstable_by(|a, b| b.cmp(a));
        view.mass - totals[..n_leaves].iter().sum::<i64>()
    }

    fn depth_one(&mut self, view: &View, upper: i64) -> Answer {
        let mut finder = self.take_finder(view);
        let stump = finder.load(self.samples, view);
        self.return_finder(view, finder);
        self.n_evaluated += 1;
        Answer::cheapest(stump.value, Plan::Stump, upper)
    }

    fn deep(&mut self, view: &View, depth: usize, upper: i64, floor: i64) -> Answer {
        let takes_first = std::mem::take(&mut self.takes_first);
        self.levels[depth].takes_first = takes_first;
        let leaf = view.leaf();
        // One level shallower first: its tree is an incumbent, its cost bounds the children of the trivial cuts, and
        // the features are taken in the order of what they reached.
        let mut best = Answer::cheapest(leaf, Plan::Leaf, upper);
        let mut whole = 0;
        let mut order: Vec<usize> = (0..self.samples.p).collect();
        if depth == 3 {
            self.prepare(view);
        }
        if self.switches.shallower_first {
            let answer = self.solve(view, depth - 1, leaf + 1, floor);
            whole = answer.lower;
            if let Some(log) = self.log.as_mut().filter(|_| depth > 2) {
                log.shallower();
            }
            if answer.cost(i64::MAX) < best.cost(upper) {
                best = answer;
            }
            if self.attained.len() == self.samples.p {
                let attained = std::mem::take(&mut self.attained);
                order = self.features_by(|f| attained[f].cost);
            }
        }
        let mut attained = vec![Reached::NOTHING; self.samples.p];
        for f in order {
            let is_done = takes_first && best.best.is_some();
            if best.cost(upper) <= floor || is_done || self.is_stopped() {
                break;
            }
            let before = best.cost(upper);
            let answer = self.deep_feature(view, depth, f, whole, before, &mut attained[f]);
            if answer.cost(i64::MAX) < before {
                best = answer;
            }
        }
        self.attained = attained;
        best.closed(upper)
    }

    /// The best tree with feature `f` at its root, if it costs less than `upper`.
    fn deep_feature(
        &mut self,
        view: &View,
        depth: usize,
        f: usize,
        whole: i64,
        upper: i64,
        seen: &mut Reached,
    ) -> Answer {
        let samples = self.samples;
        let mut level = std::mem::take(&mut self.levels[depth]);
        level.axis.lay(samples, view, f, 1 << (depth - 1).min(20), whole, &self.switches);
        level.queue.clear();
        level.queue.extend(level.axis.whole());
        let mut best = Answer::none(upper);
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
                target,
                slack,
            };
            let children = self.children(view, depth, &cut, &mut level.sides);
            if self.is_stopped() {
                break;
            }
            [level.axis.left[k], level.axis.right[k]] = children.bounds;
            if let Some((cost, plan)) = children.tree {
                seen.see(cost, cut.position);
                if cost < best.cost(upper) {
                    best = Answer::found(cost, plan);
                    if level.takes_first {
                        break;
                    }
                }
            }
            if interval.low < k {
                level.queue.push_back(Interval { a: interval.a, b: k, low: interval.low, high: k - 1 });
            }
            if interval.high > k {
                level.queue.push_back(Interval { a: k, b: interval.b, low: k + 1, high: interval.high });
            }
        }
        self.levels[depth] = level;
        best.closed(upper)
    }

    /// Solve both children of a cut: their bounds, and the tree when both are found.
    ///
    /// With slack a child is solved although the pair is known to lose: its bound then rules out neighbours too.
    pub(crate) fn children(&mut self, view: &View, depth: usize, cut: &Cut, sides: &mut [View; 2]) -> Children {
        let mut marks = std::mem::take(&mut self.marks);
        view.split(self.samples, cut.feature, cut.position, &mut marks, sides);
        self.marks = marks;
        let mut bounds = cut.bounds;
        let first = usize::from(sides[1].len > sides[0].len);
        let mut plans = [None, None];
        let mut records = [None, None];
        for side in [first, 1 - first] {
            let budget = cut.target + cut.slack - bounds[1 - side];
            let answer = self.solve(&sides[side], depth - 1, budget, bounds[side]);
            if self.is_stopped() {
                return Children { bounds: cut.bounds, tree: None };
            }
            bounds[side] = bounds[side].max(answer.lower);
            plans[side] = answer.best;
            records[side] = self.log.as_mut().and_then(Log::take);
        }
        if let Some(log) = &mut self.log {
            log.cut(self.samples.features[cut.feature], cut.position, records);
        }
        let tree = match plans {
            [Some((left, left_plan)), Some((right, right_plan))] => {
                let sides = [left_plan, right_plan];
                let plan = Plan::split(self.samples, view, cut.feature, cut.position, sides);
                Some((left + right + self.samples.penalty, plan))
            }
            _ => None,
        };
        Children { bounds, tree }
    }

    /// Tell the other threads how many cuts were evaluated here.
    pub fn report_effort(&mut self) {
        self.control.add(std::mem::take(&mut self.n_evaluated));
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
        let mut own = self.take_finder(view);
        own.prepare(self.samples, view);
        self.return_finder(view, own);
    }

    /// The samples that follow are not a part of those before.
    pub fn forget(&mut self) {
        self.finders.iter_mut().flatten().for_each(|finder| finder.forget());
    }

    /// The stump finder for a view of this swing.
    pub(super) fn take_finder(&mut self, view: &View) -> Box<dyn Stumps> {
        self.finders[width(view.mass)].take().unwrap_or_else(|| finder(self.samples, view.mass, &self.switches))
    }

    /// Give the finder back.
    pub(super) fn return_finder(&mut self, view: &View, finder: Box<dyn Stumps>) {
        self.finders[width(view.mass)] = Some(finder);
    }
}

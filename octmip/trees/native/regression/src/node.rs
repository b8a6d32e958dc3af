//! The search of one node: a tree of at most so many levels below a cost, or the proof that there is none.

use std::collections::VecDeque;

use crate::axis::{Axis, Pair};
use crate::depth_two::TwoLevels;
use crate::result::NodeResult;
use crate::samples::Samples;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::interval::Interval;
use octmip_frame::tree::Tree;

/// Share of the least size whose usual cost is the slack of a child with large leaves.
const SLACK: f64 = 0.25;

/// Buffers of one level of nodes.
#[derive(Debug, Default)]
struct Level {
    axis: Axis,
    queue: VecDeque<Interval>,
    sides: [View; 2],
}

/// A search of nodes: the samples and its buffers.
#[derive(Debug)]
pub(crate) struct Search<'a> {
    pub(crate) samples: &'a Samples,
    control: &'a Control,
    /// Best cost seen with each feature at the root, of the last node.
    incumbents: Vec<f64>,
    two_levels: TwoLevels<'a>,
    levels: Vec<Level>,
    marks: Vec<bool>,
    /// The search of the same problem with leaves of any size, where they have a least one.
    free: Option<Box<Search<'a>>>,
}

/// A cut whose children are to be solved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cut {
    /// Feature.
    pub feature: usize,
    /// Samples left of it.
    pub position: usize,
    /// Known lower bounds of the children.
    pub bounds: Pair,
    /// The same for leaves of any size.
    pub relaxed: Pair,
    /// The children together must cost less.
    pub target: f64,
    /// So much more is spent on a child's bound.
    pub slack: f64,
}

/// What became of the children of a cut.
#[derive(Debug, Clone)]
pub(crate) struct Children {
    /// Lower bounds.
    pub(crate) bounds: Pair,
    /// Lower bounds for leaves of any size.
    pub(crate) relaxed: Pair,
    /// Cost and tree of the cut, if both children were found.
    pub(crate) tree: Option<(f64, Tree)>,
}

impl<'a> Search<'a> {
    /// A search of at most `depth` levels.
    pub(crate) fn new(samples: &'a Samples, control: &'a Control, depth: usize) -> Self {
        Self {
            samples,
            control,
            incumbents: Vec::new(),
            two_levels: TwoLevels::new(samples, control),
            levels: (0..=depth).map(|_| Level::default()).collect(),
            marks: vec![false; samples.n],
            free: samples.free.as_deref().map(|free| Box::new(Search::new(free, control, depth))),
        }
    }

    /// Hand out the search of the problem with leaves of any size.
    pub(crate) fn take_free(&mut self) -> Option<Search<'a>> {
        self.free.take().map(|free| *free)
    }

    /// Put it back.
    pub(crate) fn put_back(&mut self, free: Search<'a>) {
        self.free = Some(Box::new(free));
    }

    /// Whether the search is stopped.
    pub(crate) fn is_stopped(&self) -> bool {
        self.control.is_stopped()
    }

    /// The best tree of at most `depth` levels if it costs less than `upper`, else the proof that none does.
    ///
    /// `floor` is a bound known beforehand: a tree that costs no more ends the search.
    pub(crate) fn solve(&mut self, view: &View, depth: usize, upper: f64, floor: f64) -> NodeResult {
        match self.free.as_mut().filter(|_| depth > 1 && upper > floor && view.has_room(self.samples, depth)) {
            Some(free) => {
                let free = free.solve(view, depth, upper, 0.0);
                self.beside(view, depth, upper, floor, free)
            }
            None => self.searched(view, depth, upper, floor),
        }
    }

    /// The same, the problem with leaves of any size being solved: that is a bound, and where its leaves are large
    /// enough its tree is the best one.
    fn beside(&mut self, view: &View, depth: usize, upper: f64, floor: f64, free: NodeResult) -> NodeResult {
        if let Some(search) = &self.free {
            self.incumbents.clone_from(&search.incumbents);
        }
        let Some((cost, tree)) = free.best.filter(|(cost, _)| *cost < upper) else {
            return NodeResult { lower: free.lower.max(floor), relaxed: free.lower, best: None };
        };
        if view.holds_leaves(self.samples, &tree, self.samples.leaf_size) {
            return NodeResult { lower: cost, relaxed: cost, best: Some((cost, tree)) };
        }
        let found = self.searched(view, depth, upper, floor.max(cost));
        NodeResult { lower: found.lower.max(cost), relaxed: found.relaxed.max(cost), ..found }
    }

    fn searched(&mut self, view: &View, depth: usize, upper: f64, floor: f64) -> NodeResult {
        let samples = self.samples;
        let clusters = view.cluster_bound(samples, 1 << depth.min(20));
        if upper <= floor.max(clusters) {
            return NodeResult { relaxed: clusters, ..NodeResult::none(floor.max(clusters)) };
        }
        let leaf = view.leaf(samples);
        let is_leaf_best = leaf <= floor.max(samples.penalty);
        if depth == 0 || is_leaf_best || view.len < 2 * samples.leaf_size || samples.p == 0 {
            let result = NodeResult::cheapest(leaf, Tree::leaf(0), upper);
            // A set too small to split may be split where leaves are of any size.
            return NodeResult { relaxed: if depth == 0 { leaf } else { leaf.min(clusters) }, ..result };
        }
        match depth {
            1 | 2 => {
                let result = self.two_levels.solve(view, depth, upper, floor);
                self.incumbents.clone_from(&self.two_levels.incumbents);
                result.closed(upper, samples, clusters)
            }
            _ => self.deep(view, depth, upper, floor).closed(upper, samples, clusters),
        }
    }

    fn deep(&mut self, view: &View, depth: usize, upper: f64, floor: f64) -> NodeResult {
        let leaf = view.leaf(self.samples);
        // One level shallower first: its tree is an incumbent, its cost bounds the children of the trivial cuts, and
        // the features are taken in the order of their incumbents.
        let mut best = NodeResult::cheapest(leaf, Tree::leaf(0), upper);
        self.incumbents.clear();
        let shallower = self.solve(view, depth - 1, leaf, floor);
        let whole = (shallower.lower, shallower.relaxed);
        if shallower.cost(f64::INFINITY) < best.cost(upper) {
            best = shallower;
        }
        let order = self.features_by_incumbent();
        let mut incumbents = vec![f64::INFINITY; self.samples.p];
        for f in order {
            if best.cost(upper) <= floor || self.is_stopped() {
                break;
            }
            let before = best.cost(upper);
            if let Some(found) = self.deep_feature(view, depth, f, whole, before, &mut incumbents[f]) {
                best.best = Some(found);
            }
        }
        self.incumbents = incumbents;
        best
    }

    /// Features, those first that had the best cost at the root of the last node.
    pub(crate) fn features_by_incumbent(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.samples.p).collect();
        if self.incumbents.len() == self.samples.p {
            order.sort_by(|&f, &g| self.incumbents[f].total_cmp(&self.incumbents[g]));
        }
        order
    }

    /// The best tree with feature `f` at its root, if it costs less than `upper`.
    fn deep_feature(
        &mut self,
        view: &View,
        depth: usize,
        f: usize,
        whole: (f64, f64),
        upper: f64,
        seen: &mut f64,
    ) -> Option<(f64, Tree)> {
        let samples = self.samples;
        let mut level = std::mem::take(&mut self.levels[depth]);
        level.axis.lay(samples, view, f, 1 << (depth - 1).min(20), whole);
        level.queue.clear();
        level.queue.extend(level.axis.whole());
        let (mut best, mut current) = (None, upper);
        while let Some(interval) = level.queue.pop_front() {
            let target = current - samples.penalty;
            let Some((interval, cut)) = next_cut(samples, &level.axis, interval, target, f) else { continue };
            let k = cut.0;
            let children = self.children(view, depth, &cut.1, &mut level.sides);
            if self.is_stopped() {
                break;
            }
            (level.axis.solved[k], level.axis.relaxed[k]) = (children.bounds, children.relaxed);
            if let Some((cost, tree)) = children.tree {
                *seen = seen.min(cost);
                if cost < current {
                    (best, current) = (Some((cost, tree)), cost);
                }
            }
            level.queue.extend(interval.halves(k).into_iter().flatten());
        }
        self.levels[depth] = level;
        best
    }

    /// What is spent on the bound of a child with large leaves beyond the target of its cut.
    fn slack(&self, view: &View, cut: &Cut) -> f64 {
        let usual = view.leaf(self.samples) / view.len.max(1) as f64;
        cut.slack.min(SLACK * self.samples.leaf_size as f64 * usual)
    }

    /// Solve both children of a cut: their bounds, and the tree when both are found.
    ///
    /// With slack a child is solved although the pair is known to lose: its bound then rules out neighbours too.
    pub(crate) fn children(&mut self, view: &View, depth: usize, cut: &Cut, sides: &mut [View; 2]) -> Children {
        view.split(self.samples, cut.feature, cut.position, &mut self.marks, sides);
        self.control.add(1);
        let mut bounds = [cut.bounds.left.max(0.0), cut.bounds.right.max(0.0)];
        let mut relaxed = [cut.relaxed.left.max(0.0), cut.relaxed.right.max(0.0)];
        let mut trees = [None, None];
        let first = usize::from(sides[1].len > sides[0].len);
        let mut found = [None, None];
        for side in [first, 1 - first] {
            let budget = cut.target + cut.slack - bounds[1 - side];
            let view = &sides[side];
            if let Some(free) = self.free.as_mut().filter(|_| view.has_room(self.samples, depth - 1)) {
                let result = free.solve(view, depth - 1, budget, relaxed[side]);
                relaxed[side] = relaxed[side].max(result.lower);
                found[side] = Some(result);
            } else {
                let result = self.searched(view, depth - 1, budget, bounds[side]);
                relaxed[side] = relaxed[side].max(result.relaxed);
                bounds[side] = bounds[side].max(result.lower);
                trees[side] = result.best;
            }
            bounds[side] = bounds[side].max(relaxed[side]);
        }
        for side in [first, 1 - first] {
            if let Some(free) = found[side].take()
                && bounds[0] + bounds[1] < cut.target
                && !self.is_stopped()
            {
                let budget = cut.target + self.slack(&sides[side], cut) - bounds[1 - side];
                let result = self.beside(&sides[side], depth - 1, budget, bounds[side], free);
                bounds[side] = bounds[side].max(result.lower);
                trees[side] = result.best;
            }
        }
        let tree = match trees {
            [Some((left, left_tree)), Some((right, right_tree))] if !self.is_stopped() => {
                let rank = view.rank_before(self.samples, cut.feature, cut.position);
                let tree = Tree::join(self.samples.features[cut.feature], rank, &left_tree, &right_tree);
                Some((left + right + self.samples.penalty, tree))
            }
            _ => None,
        };
        let pair = |values: [f64; 2]| Pair { left: values[0], right: values[1] };
        Children { bounds: pair(bounds), relaxed: pair(relaxed), tree }
    }
}

/// The cut to solve next in an interval, if one may be cheap enough: the interval's open part, index and cut.
pub(crate) fn next_cut(
    samples: &Samples,
    axis: &Axis,
    interval: Interval,
    target: f64,
    feature: usize,
) -> Option<(Interval, (usize, Cut))> {
    let interval = axis.narrow(samples, interval, target)?;
    let k = axis.pick(samples, &interval, target)?;
    let [bounds, relaxed] = axis.bounds(samples, &interval, k);
    let slack = axis.slack(&interval, k);
    let position = axis.positions[k] as usize;
    Some((interval, (k, Cut { feature, position, bounds, relaxed, target, slack })))
}

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
        }
    }

    /// Whether the search is stopped.
    pub(crate) fn is_stopped(&self) -> bool {
        self.control.is_stopped()
    }

    /// The best tree of at most `depth` levels if it costs less than `upper`, else the proof that none does.
    ///
    /// `floor` is a bound known beforehand: a tree that costs no more ends the search.
    pub(crate) fn solve(&mut self, view: &View, depth: usize, upper: f64, floor: f64) -> NodeResult {
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

    /// Solve both children of a cut: their bounds, and the tree when both are found.
    ///
    /// With slack a child is solved although the pair is known to lose: its bound then rules out neighbours too.
    pub(crate) fn children(&mut self, view: &View, depth: usize, cut: &Cut, sides: &mut [View; 2]) -> Children {
        view.split(self.samples, cut.feature, cut.position, &mut self.marks, sides);
        self.control.add(1);
        let mut bounds = [cut.bounds.left.max(0.0), cut.bounds.right.max(0.0)];
        let mut relaxed = [0.0; 2];
        let mut trees = [None, None];
        let first = usize::from(sides[1].len > sides[0].len);
        for side in [first, 1 - first] {
            let budget = cut.target + cut.slack - bounds[1 - side];
            let result = self.solve(&sides[side], depth - 1, budget, bounds[side]);
            bounds[side] = bounds[side].max(result.lower);
            relaxed[side] = result.relaxed;
            trees[side] = result.best;
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
    let [bounds, _] = axis.bounds(samples, &interval, k);
    let slack = axis.slack(&interval, k);
    let position = axis.positions[k] as usize;
    Some((interval, (k, Cut { feature, position, bounds, target, slack })))
}

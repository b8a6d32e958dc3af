//! The best tree of at most so many splits.
//!
//! Where the splits suffice for every tree of the depth, the search without a number answers. Else one of them is the
//! root's, and the others are shared out: for every share `(a, b)` the cuts of every feature are searched with the
//! bounds of `node::axis`, which hold for any two kinds of trees on the two sides.

use std::collections::{HashMap, VecDeque};

use crate::node::axis::Axis;
use crate::node::plan::Plan;
use crate::node::result::NodeResult;
use crate::node::search::Search;
use crate::samples::Samples;
use crate::shaped::wanted::Known;
use crate::switches::Switches;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::interval::Interval;

/// Nodes whose results are kept.
pub(super) const MOST_KEPT: usize = 1 << 18;

/// Samples of a node as bits, its depth and splits.
pub(super) type Key = (Vec<u64>, usize, usize);

/// Splits for both sides of a cut, and what is known of the node with fewer.
#[derive(Debug, Clone, Copy)]
struct Share<'l> {
    depth: usize,
    sides: [usize; 2],
    /// Lower bounds of the node's trees of 0, 1, 2, ... splits.
    lows: &'l [i64],
}

/// A search for trees of few splits: workspaces and results.
pub(super) struct Few<'a> {
    pub(super) samples: &'a Samples,
    pub(super) search: Search<'a>,
    pub(super) depth: usize,
    pub(super) splits: usize,
    pub(super) control: &'a Control,
    kept: HashMap<Key, NodeResult>,
    marks: Vec<bool>,
}

impl<'a> Few<'a> {
    /// Workspaces for trees of at most `depth` levels and `splits` splits.
    pub(super) fn new(samples: &'a Samples, control: &'a Control, depth: usize, splits: usize) -> Self {
        let (depth, splits) = least_size(depth, splits);
        let search = Search::new(samples, Switches::default(), control, depth);
        Self { samples, search, depth, splits, control, kept: HashMap::new(), marks: vec![false; samples.n] }
    }

    /// Search all samples for trees that cost less than `upper`.
    pub(super) fn search(mut self, view: &View, upper: i64, known: &Known) {
        let result = self.solve(view, self.depth, self.splits, upper);
        if let Some((cost, plan)) = result.best {
            known.see(cost, || plan.tree(self.samples, view));
        }
        if !self.control.is_stopped() {
            known.raise(result.lower);
        }
    }

    /// The best tree of at most `depth` levels and `splits` splits if it costs less than `upper`, else the proof that
    /// none does.
    pub(super) fn solve(&mut self, view: &View, depth: usize, splits: usize, upper: i64) -> NodeResult {
        let (depth, splits) = least_size(depth, splits);
        if upper <= 0 {
            return NodeResult::none(0);
        }
        let is_whole = splits + 1 == 1 << depth.min(20);
        if is_whole {
            self.search.forget(); // the buckets laid out last may be those of other samples
            let result = self.search.solve(view, depth, upper, 0);
            self.search.report_effort();
            return result;
        }
        let leaf = view.leaf();
        let is_cheap = leaf <= self.samples.penalty || self.samples.n_labels == 1;
        if is_cheap || view.len < 2 * self.samples.leaf_size || self.samples.p == 0 {
            return NodeResult::cheapest(leaf, Plan::Leaf, upper);
        }
        let key = (self.bits(view), depth, splits);
        if let Some(known) = self.kept.get(&key) {
            match &known.best {
                Some((cost, plan)) => return NodeResult::cheapest(*cost, plan.clone(), upper),
                None if known.lower >= upper => return NodeResult::none(upper),
                None => {}
            }
        }
        let result = self.by_number(view, depth, splits, upper);
        if !self.control.is_stopped() && (self.kept.len() < MOST_KEPT || self.kept.contains_key(&key)) {
            self.kept.insert(key, result.clone());
        }
        result
    }

    pub(super) fn bits(&self, view: &View) -> Vec<u64> {
        let mut bits = vec![0; self.samples.n.div_ceil(64)];
        view.ids(self.samples).for_each(|i| bits[i as usize / 64] |= 1 << (i % 64));
        bits
    }

    /// One split, two, three, ...: each number bounds the children of the trivial cuts of those that follow.
    fn by_number(&mut self, view: &View, depth: usize, splits: usize, upper: i64) -> NodeResult {
        let mut best = NodeResult::cheapest(view.leaf(), Plan::Leaf, upper);
        let mut lows = vec![view.leaf()];
        for number in 1..=splits {
            let before = best.cost(upper);
            let (levels, number) = least_size(depth, number);
            let result = if number + 1 == 1 << levels {
                self.solve(view, levels, number, before)
            } else {
                self.shared_out(view, levels, number, before, &lows)
            };
            if self.control.is_stopped() {
                return if result.best.is_some() { result } else { best };
            }
            lows.push(result.lower.min(before));
            if result.cost(i64::MAX) < before {
                best = result;
            }
        }
        best.closed(upper)
    }

    fn shared_out(&mut self, view: &View, depth: usize, splits: usize, upper: i64, lows: &[i64]) -> NodeResult {
        let most = (1 << (depth - 1).min(20)) - 1;
        let mut best = NodeResult::none(upper);
        for f in 0..self.samples.p {
            for left in (splits - 1).saturating_sub(most)..=most.min(splits - 1) {
                let share = Share { depth: depth - 1, sides: [left, splits - 1 - left], lows };
                let result = self.feature(view, f, share, best.cost(upper));
                if result.best.is_some() {
                    best = result;
                }
                if self.control.is_stopped() {
                    return best;
                }
            }
        }
        best.closed(upper)
    }

    /// The best tree with feature `f` at its root and its splits shared out so, if it costs less than `upper`.
    fn feature(&mut self, view: &View, f: usize, share: Share<'_>, upper: i64) -> NodeResult {
        let switches = Switches::default();
        let mut axis = Axis::default();
        let n_leaves = (share.sides[0].max(share.sides[1]) + 1).next_power_of_two();
        axis.lay(self.samples, view, f, n_leaves, 0, &switches);
        let last = axis.last();
        (axis.left[last], axis.right[0]) = (share.lows[share.sides[0]], share.lows[share.sides[1]]);
        let mut queue: VecDeque<Interval> = axis.whole().into_iter().collect();
        let mut best = NodeResult::none(upper);
        let mut sides = [View::default(), View::default()];
        while let Some(interval) = queue.pop_front() {
            let target = best.cost(upper) - self.samples.penalty;
            let Some(interval) = axis.narrow(interval, target) else { continue };
            let Some(k) = axis.pick(&interval, target) else { continue };
            let position = axis.positions[k] as usize;
            view.split(self.samples, f, position, &mut self.marks, &mut sides);
            let mut bounds: [i64; 2] = axis.bounds(&interval, k).into();
            let budget = target + axis.slack(&interval, k);
            let mut plans = [None, None];
            let first = usize::from(share.sides[1] < share.sides[0]); // the side of fewer splits is solved sooner
            for side in [first, 1 - first] {
                let result = self.solve(&sides[side], share.depth, share.sides[side], budget - bounds[1 - side]);
                if self.control.is_stopped() {
                    return best;
                }
                bounds[side] = bounds[side].max(result.lower);
                plans[side] = result.best;
            }
            axis.enter(k, bounds, [0, 0]);
            if let [Some((left, left_plan)), Some((right, right_plan))] = plans {
                let cost = left + right + self.samples.penalty;
                if cost < best.cost(upper) {
                    let plan = Plan::split(self.samples, view, f, position, [left_plan, right_plan]);
                    best = NodeResult::found(cost, plan);
                }
            }
            queue.extend(interval.halves(k).into_iter().flatten());
        }
        best.closed(upper)
    }
}

/// Levels and splits as far as they allow each other: `s` splits make at most `s` levels, and a tree of `d` levels has
/// fewer than `2^d` splits.
pub(super) fn least_size(depth: usize, splits: usize) -> (usize, usize) {
    let depth = depth.min(splits);
    (depth, splits.min((1 << depth.min(20)) - 1))
}

//! The best tree of at most so many splits.
//!
//! Where the splits suffice for every tree of the depth, the search without a number answers, and two splits on two
//! levels are one pass over the cuts as well (`node::depth_two`). Else the problem without a number stands beside: what
//! it costs is a bound, and its tree is the best one where it has few splits. One split is the root's, and the others
//! are shared out. A cut's sides are solved with all their splits first; only where these stay below the target
//! together, they are solved with the splits of every share. A share's bounds are those of `node::axis`, which hold for
//! any two kinds of trees on the two sides.

use std::collections::VecDeque;

use crate::node::axis::{Axis, Beside};
use crate::node::beside::first_step;
use crate::node::plan::Plan;
use crate::node::result::NodeResult;
use crate::node::search::Search;
use crate::samples::Samples;
use crate::shaped::wanted::Known;
use crate::switches::Switches;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::interval::Interval;

/// Each search asks for trees so many times as far above the problem without a number as the one before: cuts are
/// searched anew, and with few splits the best tree is far above.
const GROWTH: i64 = 4;

/// Samples of a node as bits, its depth and splits.
pub(super) type Key = (Vec<u64>, usize, usize);

/// Splits of the left and the right side of a cut.
type Share = [usize; 2];

/// A search for trees of few splits: workspaces.
pub(super) struct Few<'a> {
    pub(super) samples: &'a Samples,
    pub(super) search: Search<'a>,
    pub(super) depth: usize,
    pub(super) splits: usize,
    pub(super) control: &'a Control,
    marks: Vec<bool>,
}

/// What is known of a node before its cuts are searched.
struct Begun {
    /// Cost of the best tree of any number of splits.
    free: i64,
    /// Features, by the trees that the free search saw at their cuts.
    order: Vec<usize>,
    /// What trees of one level fewer and of 0, 1, 2, ... splits cost at least.
    lows: Vec<i64>,
    /// The best of them.
    best: NodeResult,
}

/// One side of a cut, and what its trees of 0, 1, 2, ... splits are known to cost.
struct Side {
    view: View,
    lower: Vec<i64>,
    best: Vec<Option<(i64, Plan)>>,
}

impl Side {
    /// Take up a bound of trees of at most `splits` splits: those of fewer cost no less.
    fn raise(&mut self, splits: usize, lower: i64) {
        self.lower[..=splits].iter_mut().for_each(|known| *known = lower.max(*known));
    }
}

impl<'a> Few<'a> {
    /// Workspaces for trees of at most `depth` levels and `splits` splits.
    pub(super) fn new(samples: &'a Samples, control: &'a Control, depth: usize, splits: usize) -> Self {
        let (depth, splits) = least_size(depth, splits);
        let search = Search::new(samples, Switches::default(), control, depth);
        Self { samples, search, depth, splits, control, marks: vec![false; samples.n] }
    }

    /// Search all samples for trees that cost less than `upper`: first for those little above what the problem without
    /// a number costs, then above more and more.
    pub(super) fn search(mut self, view: &View, upper: i64, known: &Known) {
        let size = (self.depth, self.splits);
        if self.is_one_search(size) {
            let result = self.solve(view, self.depth, self.splits, upper);
            return self.show(view, result, known);
        }
        let begun = match self.begin(view, size, upper) {
            Ok(begun) => begun,
            Err(result) => return self.show(view, result, known),
        };
        self.show(view, NodeResult { lower: begun.free, ..begun.best.clone() }, known);
        let (upper, mut proven) = (known.best().0.min(upper), begun.free);
        let mut step = GROWTH * first_step(proven, view);
        while proven < upper && !self.control.is_stopped() {
            let asked = upper.min(proven.saturating_add(step));
            let result = self.by_cuts(view, size, asked, &begun);
            (proven, step) = (result.cost(asked), step.saturating_mul(GROWTH));
            let is_found = result.best.is_some();
            self.show(view, result, known);
            if is_found {
                break;
            }
        }
    }

    /// Show a tree and a bound.
    fn show(&self, view: &View, result: NodeResult, known: &Known) {
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
        self.search.forget(); // the buckets laid out last may be those of other samples
        self.node(view, (depth, splits), upper, 0)
    }

    /// Whether one pass over the cuts finds the best tree.
    fn is_one_search(&self, (depth, splits): (usize, usize)) -> bool {
        depth <= 2 || splits + 1 == 1 << depth.min(20)
    }

    pub(super) fn bits(&self, view: &View) -> Vec<u64> {
        let mut bits = vec![0; self.samples.n.div_ceil(64)];
        view.ids(self.samples).for_each(|i| bits[i as usize / 64] |= 1 << (i % 64));
        bits
    }

    /// The same of a node whose samples are some of those whose buckets are laid out.
    fn node(&mut self, view: &View, (depth, splits): (usize, usize), upper: i64, floor: i64) -> NodeResult {
        let size @ (depth, splits) = least_size(depth, splits);
        if upper <= floor {
            return NodeResult::none(floor);
        }
        let leaf = view.leaf();
        if self.search.is_leaf_best((leaf, view.len), depth, floor) {
            return NodeResult::cheapest(leaf, Plan::Leaf, upper);
        }
        if self.is_one_search(size) {
            let result = match splits {
                2 if depth == 2 => self.search.two_splits(view, upper, floor),
                _ => self.search.solve(view, depth, upper, floor),
            };
            self.search.report_effort();
            return result;
        }
        match self.begin(view, size, upper) {
            Ok(begun) => {
                let found = self.by_cuts(view, size, begun.best.cost(upper), &begun);
                if found.best.is_some() { found } else { begun.best.closed(upper) }
            }
            Err(result) => result,
        }
    }

    /// Solve the problem without a number and that of one level fewer; the result itself where these tell it.
    fn begin(&mut self, view: &View, size: (usize, usize), upper: i64) -> Result<Begun, NodeResult> {
        let free = self.search.solve(view, size.0, upper, 0);
        self.search.report_effort();
        let Some((cost, plan)) = free.best.filter(|_| !self.control.is_stopped()) else {
            return Err(NodeResult::none(free.lower));
        };
        if plan.tree(self.samples, view).n_splits() <= size.1 {
            return Err(NodeResult::found(cost, plan));
        }
        let incumbents = std::mem::take(&mut self.search.incumbents);
        let mut order: Vec<usize> = (0..self.samples.p).collect();
        if incumbents.len() == self.samples.p {
            order.sort_by_key(|&f| incumbents[f].cost);
        }
        let (lows, best) = self.shallower(view, size, upper);
        Ok(Begun { free: cost, order, lows, best })
    }

    /// The best tree with a cut at its root below `upper`.
    fn by_cuts(&mut self, view: &View, size: (usize, usize), upper: i64, begun: &Begun) -> NodeResult {
        let mut best = NodeResult::none(upper);
        if size.0 == 3 {
            self.search.prepare(view);
        }
        let shares = shares(size);
        for &f in &begun.order {
            if best.cost(upper) <= begun.free || self.control.is_stopped() {
                break;
            }
            let found = self.feature(view, f, size.0 - 1, (&shares, &begun.lows), best.cost(upper));
            if found.best.is_some() {
                best = found;
            }
        }
        best.closed(upper)
    }

    /// What trees of one level fewer and of 0, 1, 2, ... splits cost on all samples of a node at least, and the best of
    /// them below `upper`.
    fn shallower(&mut self, view: &View, (depth, splits): (usize, usize), upper: i64) -> (Vec<i64>, NodeResult) {
        let (depth, most) = least_size(depth - 1, splits);
        if depth == 2 {
            self.search.prepare(view);
        }
        let mut all = Side { view: View::default(), lower: vec![0; most + 1], best: Vec::new() };
        let mut best = NodeResult::cheapest(view.leaf(), Plan::Leaf, upper);
        all.lower[0] = view.leaf();
        for splits in (1..=most).rev().filter(|&splits| splits == most || depth == 2) {
            let result = self.node(view, (depth, splits), upper, all.lower[splits]);
            all.raise(splits, result.lower);
            if result.cost(i64::MAX) < best.cost(upper) {
                best = result;
            }
        }
        if depth > 2 {
            self.search.forget();
        }
        (all.lower, best)
    }

    /// The best tree with feature `f` at its root and `depth` levels below, if it costs less than `upper`.
    fn feature(
        &mut self,
        view: &View,
        f: usize,
        depth: usize,
        (shares, lows): (&[Share], &[i64]),
        upper: i64,
    ) -> NodeResult {
        let mut axes: Vec<Axis> = shares.iter().map(|&share| self.axis(view, f, share, lows)).collect();
        let mut queue: VecDeque<Interval> = axes[0].whole().into_iter().collect();
        let mut best = NodeResult::none(upper);
        let side = || Side { view: View::default(), lower: Vec::new(), best: Vec::new() };
        let mut sides = [side(), side()];
        while let Some(interval) = queue.pop_front() {
            let target = best.cost(upper) - self.samples.penalty;
            let open: Vec<(Interval, usize)> = axes.iter().filter_map(|axis| open(axis, interval, target)).collect();
            let Some(&(first, k)) = open.first() else { continue };
            // What is closed for every share is left out.
            let low = open.iter().map(|(interval, _)| interval.low).min().unwrap_or(first.low);
            let high = open.iter().map(|(interval, _)| interval.high).max().unwrap_or(first.high);
            let interval = Interval { low, high, ..interval };
            let position = axes[0].positions[k] as usize;
            self.lay(view, (f, position), lows.len(), &mut sides);
            for (axis, share) in axes.iter().zip(shares) {
                let (left, right) = axis.bounds(&interval, k);
                sides[0].raise(share[0], left);
                sides[1].raise(share[1], right);
            }
            let slack = axes[0].slack(&interval, k);
            if shares.len() > 1 {
                // What both sides cost with all their splits closes most cuts.
                self.share(&mut sides, depth, [lows.len() - 1; 2], (target, slack / 2));
            }
            for share in shares {
                let target = best.cost(upper) - self.samples.penalty;
                let plans = self.share(&mut sides, depth, *share, (target, slack));
                if self.control.is_stopped() {
                    return best;
                }
                if let Some((cost, plans)) = plans.filter(|(cost, _)| *cost < target) {
                    let plan = Plan::split(self.samples, view, f, position, plans);
                    best = NodeResult::found(cost + self.samples.penalty, plan);
                }
            }
            for (axis, share) in axes.iter_mut().zip(shares) {
                axis.enter(k, [0, 1].map(|side| sides[side].lower[share[side]]), Beside::default());
            }
            queue.extend(interval.halves(k).into_iter().flatten());
        }
        best.closed(upper)
    }

    /// The cuts of a feature for the trees of a share.
    fn axis(&self, view: &View, f: usize, share: Share, lows: &[i64]) -> Axis {
        let mut axis = Axis::default();
        let n_leaves = share[0].max(share[1]) + 1;
        axis.lay(self.samples, view, (f, self.samples.leaf_size), n_leaves, 0, &Switches::default());
        let last = axis.last();
        (axis.left[last], axis.right[0]) = (lows[share[0]], lows[share[1]]);
        for side in [0, 1].into_iter().filter(|&side| share[side] == 0) {
            axis.take_up_leaves(self.samples, view, f, side);
        }
        axis
    }

    /// Part the samples at a cut; nothing is known of the sides but what their leaves cost.
    fn lay(&mut self, view: &View, (f, position): (usize, usize), n_sizes: usize, sides: &mut [Side; 2]) {
        let mut views = sides.each_mut().map(|side| std::mem::take(&mut side.view));
        view.split(self.samples, f, position, &mut self.marks, &mut views);
        for (side, view) in sides.iter_mut().zip(views) {
            let leaf = view.leaf();
            *side = Side { view, lower: vec![0; n_sizes], best: vec![None; n_sizes] };
            (side.lower[0], side.best[0]) = (leaf, Some((leaf, Plan::Leaf)));
        }
    }

    /// Solve both sides with the splits of a share, where they may cost less than the target together; the best pair
    /// where both are found.
    fn share(
        &mut self,
        sides: &mut [Side; 2],
        depth: usize,
        share: Share,
        (target, slack): (i64, i64),
    ) -> Option<(i64, [Plan; 2])> {
        let first = usize::from(share[1] < share[0]); // the side of fewer splits is solved sooner
        for side in [first, 1 - first] {
            let [own, other] = [side, 1 - side].map(|side| sides[side].lower[share[side]]);
            if own + other >= target {
                return None;
            }
            if sides[side].best[share[side]].is_none() {
                if depth > 2 {
                    self.search.forget();
                }
                let result = self.node(&sides[side].view, (depth, share[side]), target + slack - other, own);
                sides[side].raise(share[side], result.lower);
                let fewest = result.best.as_ref().map_or(share[side], |(_, plan)| most_splits(plan).min(share[side]));
                sides[side].best[fewest..=share[side]].fill(result.best);
            }
        }
        let [Some(left), Some(right)] = [0, 1].map(|side| sides[side].best[share[side]].clone()) else { return None };
        Some((left.0 + right.0, [left.1, right.1]))
    }
}

/// The cuts of an interval that a feature's axis leaves open, and the next of them.
pub(super) fn open(axis: &Axis, interval: Interval, target: i64) -> Option<(Interval, usize)> {
    let interval = axis.narrow(interval, target)?;
    axis.pick(&interval, target).map(|k| (interval, k))
}

/// The ways to share out all splits but the root's.
fn shares((depth, splits): (usize, usize)) -> Vec<Share> {
    let most = (1 << (depth - 1).min(20)) - 1;
    ((splits - 1).saturating_sub(most)..=most.min(splits - 1)).map(|left| [left, splits - 1 - left]).collect()
}

/// Levels and splits as far as they allow each other: `s` splits make at most `s` levels, and a tree of `d` levels has
/// fewer than `2^d` splits.
pub(super) fn least_size(depth: usize, splits: usize) -> (usize, usize) {
    let depth = depth.min(splits);
    (depth, splits.min((1 << depth.min(20)) - 1))
}

/// Splits of a plan's tree at most.
fn most_splits(plan: &Plan) -> usize {
    match plan {
        Plan::Leaf => 0,
        Plan::Stump => 1,
        Plan::Split { sides, .. } => 1 + most_splits(&sides[0]) + most_splits(&sides[1]),
        Plan::Whole(tree) => tree.n_splits(),
    }
}

//! The best tree of at most two levels: bisection over the cuts of the root, both children solved by best stumps.
//!
//! For every evaluated cut the least relaxed error of each feature is kept for both sides. The same bounds that hold
//! for the best stump (see `axis`) hold for the best cut of each feature, so that most features need no scan at a cut
//! between two others.

use crate::axis::{Axis, Pair};
use crate::buckets::Buckets;
use crate::few_cuts::FewCuts;
use crate::result::NodeResult;
use crate::samples::Samples;
use crate::scan::Scanner;
use crate::sides::Sides;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::interval::Interval;
use octmip_frame::tree::Tree;

/// A feature whose bounds by a few cuts have spared so many scans fewer than they have not is scanned without.
const LEAST_SPARED: i32 = -2;

/// So is one whose bounds are too low for that where they are this share of its least error, as they are on average.
const SHARE: f64 = 15.0 / 16.0;

/// The search for trees of two levels and its buffers.
#[derive(Debug)]
pub(crate) struct TwoLevels<'a> {
    samples: &'a Samples,
    control: &'a Control,
    /// Best cost seen with each feature at the root, of the last node.
    pub(crate) incumbents: Vec<f64>,
    sides: Sides,
    scanner: Scanner,
    /// Where they serve; else every scan is one of samples, and so it is where they give bounds alone.
    buckets: Option<Buckets>,
    few_cuts: FewCuts,
    axis: Axis,
    /// Lower bounds of each feature's least relaxed error on both sides, evaluation after evaluation.
    kept: Vec<Pair>,
    now: Vec<Pair>,
    is_known: Vec<[bool; 2]>,
    /// Which of them are bounded by a few cuts.
    is_bounded: Vec<[bool; 2]>,
    /// Of each feature, how many scans such bounds have spared at this node less those that they have not.
    spared: Vec<i32>,
}

impl<'a> TwoLevels<'a> {
    /// A search of these samples.
    pub(crate) fn new(samples: &'a Samples, control: &'a Control) -> Self {
        Self {
            samples,
            control,
            incumbents: Vec::new(),
            sides: Sides::new(samples.n),
            scanner: Scanner::default(),
            buckets: Buckets::new(samples),
            few_cuts: FewCuts::default(),
            axis: Axis::default(),
            kept: Vec::new(),
            now: Vec::new(),
            is_known: Vec::new(),
            is_bounded: Vec::new(),
            spared: Vec::new(),
        }
    }
}

/// The best stump found on one side: its cost and feature, None for a leaf.
#[derive(Debug, Clone, Copy)]
struct Stump {
    cost: f64,
    feature: Option<usize>,
}

impl Stump {
    fn see(&mut self, g: usize, error: f64, penalty: f64) {
        if error + penalty < self.cost {
            *self = Self { cost: error + penalty, feature: Some(g) };
        }
    }
}

impl TwoLevels<'_> {
    /// The best tree of at most two levels (or one) if it costs less than `upper`.
    pub(crate) fn solve(&mut self, view: &View, depth: usize, upper: f64, floor: f64) -> NodeResult {
        let samples = self.samples;
        let penalty = samples.penalty;
        let leaf = view.leaf(samples);
        self.sides.rewind(samples, view);
        self.few_cuts.leave_node();
        let (stump, whole) = self.whole(view, leaf);
        self.control.add(1);
        let mut best = NodeResult::cheapest(stump.cost, self.stump_tree(view, 1, &stump), upper);
        if depth == 1 {
            return best;
        }
        let least = whole.iter().copied().fold(f64::INFINITY, f64::min);
        let relaxed = leaf.min(least + penalty);
        self.spared.clear();
        self.spared.extend(whole.iter().map(|error| if error * SHARE > least { 0 } else { LEAST_SPARED }));
        self.incumbents.clear();
        self.incumbents.resize(samples.p, f64::INFINITY);
        let mut order: Vec<usize> = (0..samples.p).collect();
        order.sort_by(|&f, &g| whole[f].total_cmp(&whole[g]));
        for f in order {
            let current = best.cost(upper);
            if current <= floor || self.control.is_stopped() {
                break;
            }
            if let Some(found) = self.feature(view, f, &whole, (stump.cost, relaxed), current) {
                best.best = Some(found);
            }
        }
        best
    }

    /// The best stump of all samples, all on the right, and the least relaxed error of each feature.
    fn whole(&mut self, view: &View, leaf: f64) -> (Stump, Vec<f64>) {
        let samples = self.samples;
        if let Some(buckets) = &mut self.buckets {
            buckets.begin();
            buckets.load(samples, view);
        }
        self.now.clear();
        self.now.resize(samples.p, Pair::default());
        self.is_known.clear();
        self.is_known.resize(samples.p, [true, false]);
        let mut stumps = [Stump { cost: 0.0, feature: None }, Stump { cost: leaf, feature: None }];
        self.sweep(view, 0, &mut stumps);
        while let Some(g) = (0..samples.p).find(|&g| !self.is_known[g][1]) {
            self.look(view, g, &mut stumps, [false, true]);
        }
        let whole: Vec<f64> = self.now.iter().map(|pair| pair.right).collect();
        if let Some(buckets) = &mut self.buckets {
            buckets.reorder(&whole);
            buckets.load(samples, view);
        }
        (stumps[1], whole)
    }

    /// A stump of one side of the cut as a tree.
    fn stump_tree(&mut self, view: &View, side: usize, stump: &Stump) -> Tree {
        let Some(g) = stump.feature else { return Tree::leaf(0) };
        let needs = [side == 0, side == 1];
        let found = self.scanner.scan(self.samples, view, g, &mut self.sides, needs)[side];
        if found.error.is_infinite() {
            return Tree::leaf(0); // rounding alone made it cheaper than the leaf
        }
        Tree::join(self.samples.features[g], found.rank, &Tree::leaf(0), &Tree::leaf(0))
    }

    /// Pass over the buckets of all features that may hold a better stump on either side.
    fn sweep(&mut self, view: &View, f: usize, stumps: &mut [Stump; 2]) {
        let (samples, penalty) = (self.samples, self.samples.penalty);
        let Self { buckets, sides, now, .. } = self;
        let Some(buckets) = buckets else { return };
        for group in 0..buckets.n_groups() {
            let features = buckets.group(group);
            let may = |m: usize| features.iter().any(|&g| now[g].of(m) + penalty < stumps[m].cost);
            let needs = [may(0), may(1)];
            if needs == [false, false] {
                continue;
            }
            let found = buckets.sweep(samples, sides, group, view.list(f), needs);
            for (lane, &g) in buckets.group(group).iter().enumerate() {
                for m in [0, 1].into_iter().filter(|&m| needs[m]) {
                    now[g].raise(m, found.lower[m][lane]);
                    if buckets.is_exact {
                        stumps[m].see(g, found.edge[m][lane], penalty);
                    }
                }
            }
        }
    }

    /// Find the best cut of a feature on the sides that need it.
    fn look(&mut self, view: &View, g: usize, stumps: &mut [Stump; 2], needs: [bool; 2]) {
        let Self { samples, buckets, scanner, sides, now, is_known, .. } = self;
        let penalty = samples.penalty;
        let found = match buckets {
            Some(buckets) if buckets.is_exact => [0, 1].map(|m| match needs[m] {
                true => buckets.look_inside(samples, view, g, sides, (m, stumps[m].cost - penalty)),
                false => (f64::INFINITY, 0.0),
            }),
            _ => scanner.scan(samples, view, g, sides, needs).map(|best| (best.error, best.relaxed)),
        };
        for m in [0, 1] {
            if needs[m] {
                stumps[m].see(g, found[m].0, penalty);
                now[g].raise(m, found[m].1);
                is_known[g][m] = true;
            }
        }
    }

    fn feature(&mut self, view: &View, f: usize, whole: &[f64], stump: (f64, f64), upper: f64) -> Option<(f64, Tree)> {
        let samples = self.samples;
        let mut axis = std::mem::take(&mut self.axis);
        axis.lay(samples, view, f, 2, stump);
        let mut open: Vec<Interval> = axis.whole().into_iter().collect();
        let (mut best, mut current) = (None, upper);
        let mut is_fresh = true;
        while let Some(interval) = open.pop() {
            let target = current - samples.penalty;
            let Some(interval) = axis.narrow(samples, interval, target) else { continue };
            let Some(k) = axis.pick(samples, &interval, target) else { continue };
            if self.control.is_stopped() {
                break;
            }
            if std::mem::take(&mut is_fresh) {
                self.begin_feature(view, f, &mut axis, whole);
            }
            let threshold = target + axis.slack(&interval, k);
            let stumps = self.evaluate(view, f, &mut axis, &interval, k, threshold);
            let cost = stumps[0].cost + stumps[1].cost + samples.penalty;
            self.incumbents[f] = self.incumbents[f].min(cost);
            if cost < current {
                let [left, right] = [0, 1].map(|side| self.stump_tree(view, side, &stumps[side]));
                let rank = view.rank_before(samples, f, axis.positions[k] as usize);
                (best, current) = (Some((cost, Tree::join(samples.features[f], rank, &left, &right))), cost);
            }
            open.extend(interval.halves(k).into_iter().rev().flatten());
        }
        self.axis = axis;
        best
    }

    fn begin_feature(&mut self, view: &View, f: usize, axis: &mut Axis, whole: &[f64]) {
        let Self { sides, scanner, kept, buckets, .. } = self;
        sides.rewind(self.samples, view);
        if let Some(buckets) = buckets {
            buckets.rewind(self.samples, view);
        }
        if !buckets.as_ref().is_some_and(|buckets| buckets.is_exact) {
            axis.lay_leaves(self.samples, view, f, sides, scanner);
        }
        kept.clear();
        kept.extend(whole.iter().map(|&right| Pair { left: 0.0, right }));
        kept.extend(whole.iter().map(|&left| Pair { left, right: 0.0 }));
    }

    /// The best stumps on both sides of cut `k`, or the proof that they cost `threshold` together.
    fn evaluate(
        &mut self,
        view: &View,
        f: usize,
        axis: &mut Axis,
        interval: &Interval,
        k: usize,
        threshold: f64,
    ) -> [Stump; 2] {
        let (samples, penalty) = (self.samples, self.samples.penalty);
        let p = samples.p;
        self.control.add(1);
        let Self { sides, buckets, few_cuts, kept, now, is_known, is_bounded, .. } = self;
        sides.move_to(samples, view, f, axis.positions[k] as usize, |i, to| {
            if let Some(buckets) = buckets {
                buckets.pass(samples, i, to);
            }
        });
        let of = |cut: usize| axis.evaluation[cut] as usize * p;
        let neighbours = (&kept[of(interval.a)..][..p], &kept[of(interval.b)..][..p]);
        axis.inherit(samples, interval, k, neighbours, now);
        is_known.clear();
        is_known.resize(p, [false; 2]);
        few_cuts.leave_cut();
        is_bounded.clear();
        is_bounded.resize(p, [false; 2]);
        let leaves = match buckets {
            Some(buckets) if buckets.is_exact => buckets.leaves(samples, sides),
            _ => [axis.leaves[k].left, axis.leaves[k].right],
        };
        let mut stumps = leaves.map(|cost| Stump { cost, feature: None });
        let mut is_swept = false;
        let lower = loop {
            let open = [0, 1].map(|side| self.first_open(side, stumps[side].cost));
            let lower = [0, 1].map(|side| open[side].map_or(stumps[side].cost, |(least, _)| least));
            let widest = usize::from(stumps[1].cost - lower[1] > stumps[0].cost - lower[0]);
            let Some((_, g)) = open[widest] else { break lower };
            if lower[0] + lower[1] >= threshold {
                break lower;
            }
            if !is_swept && self.buckets.is_some() {
                is_swept = true;
                self.sweep(view, f, &mut stumps);
                continue;
            }
            let is_open = |m: usize| self.now[g].of(m) + penalty < stumps[m].cost && !self.is_known[g][m];
            let needs = [is_open(0), is_open(1)];
            if self.bound_by_few_cuts(view, g, needs) {
                continue;
            }
            self.look(view, g, &mut stumps, needs);
        };
        for (spared, (bounded, known)) in self.spared.iter_mut().zip(self.is_bounded.iter().zip(&self.is_known)) {
            for side in [0, 1].into_iter().filter(|&side| bounded[side]) {
                *spared += if known[side] { -1 } else { 1 };
            }
        }
        let relaxed = |side: usize| {
            if samples.leaf_size == 1 {
                return lower[side];
            }
            self.now.iter().fold(leaves[side], |least, pair| least.min(pair.of(side) + penalty))
        };
        axis.relaxed[k] = Pair { left: relaxed(0), right: relaxed(1) };
        axis.solved[k] = Pair { left: lower[0], right: lower[1] };
        axis.evaluation[k] = (self.kept.len() / p) as u32;
        self.kept.extend_from_slice(&self.now);
        stumps
    }

    /// Bound the best cut of a feature on the sides that need it, before it is scanned; whether that was to be done.
    fn bound_by_few_cuts(&mut self, view: &View, g: usize, needs: [bool; 2]) -> bool {
        if self.buckets.is_some() {
            return false;
        }
        let is_wanted = |m: usize| {
            self.spared[g] > LEAST_SPARED
                && needs[m]
                && !self.is_bounded[g][m]
                && FewCuts::serve(self.samples, self.sides.counts[m])
        };
        let wanted = [is_wanted(0), is_wanted(1)];
        for m in [0, 1].into_iter().filter(|&m| wanted[m]) {
            let bound = self.few_cuts.bound(self.samples, view, &self.sides, g, m);
            self.now[g].raise(m, bound);
            self.is_bounded[g][m] = true;
        }
        wanted != [false; 2]
    }

    /// The feature that may hold the best stump of a side, and what it costs at least; None where none is below `cost`.
    fn first_open(&self, side: usize, cost: f64) -> Option<(f64, usize)> {
        let mut best = None;
        let mut least = cost;
        for (g, (pair, is_known)) in self.now.iter().zip(&self.is_known).enumerate() {
            let own = pair.of(side) + self.samples.penalty;
            if own < least && !is_known[side] {
                (least, best) = (own, Some((own, g)));
            }
        }
        best
    }
}

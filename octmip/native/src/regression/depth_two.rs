//! The best tree of at most two levels: bisection over the cuts of the root, both children solved by best stumps.
//!
//! For every evaluated cut the least relaxed error of each feature is kept for both sides. The same bounds that hold
//! for the best stump (see `axis`) hold for the best cut of each feature, so that most features need no scan at a cut
//! between two others.

use crate::regression::axis::{Axis, Interval, Pair};
use crate::regression::histograms::Histograms;
use crate::regression::medians::Medians;
use crate::regression::result::{Effort, NodeResult};
use crate::regression::samples::Samples;
use crate::regression::scan::{BestCut, Scanner};
use crate::regression::sides::Sides;
use crate::regression::view::View;
use crate::tree::Tree;

/// The search for trees of two levels and its buffers.
#[derive(Debug)]
pub(crate) struct TwoLevels<'a> {
    samples: &'a Samples,
    effort: &'a Effort,
    /// Best cost seen with each feature at the root, of the last node.
    pub(crate) incumbents: Vec<f64>,
    sides: Sides,
    scanner: Scanner,
    /// Of squared errors where no leaf size binds.
    histograms: Option<Histograms>,
    medians: Medians,
    axis: Axis,
    /// Lower bounds of each feature's least relaxed error on both sides, evaluation after evaluation.
    kept: Vec<Pair>,
    now: Vec<Pair>,
    orders: [Vec<u32>; 2],
    is_scanned: Vec<bool>,
}

impl<'a> TwoLevels<'a> {
    /// A search of these samples.
    pub(crate) fn new(samples: &'a Samples, effort: &'a Effort) -> Self {
        Self {
            samples,
            effort,
            incumbents: Vec::new(),
            sides: Sides::new(samples.n),
            scanner: Scanner::default(),
            histograms: Histograms::serve(samples).then(Histograms::default),
            medians: Medians::default(),
            axis: Axis::default(),
            kept: Vec::new(),
            now: Vec::new(),
            orders: [Vec::new(), Vec::new()],
            is_scanned: Vec::new(),
        }
    }
}

/// The best stump found on one side, and how good one can be.
#[derive(Debug, Clone, Copy)]
struct Stump {
    cost: f64,
    /// Feature and largest rank left of the cut; None is a leaf.
    cut: Option<(usize, u32)>,
}

impl Stump {
    fn see(&mut self, g: usize, found: &BestCut, penalty: f64) {
        if found.error + penalty < self.cost {
            (self.cost, self.cut) = (found.error + penalty, Some((g, found.rank)));
        }
    }

    fn tree(&self, samples: &Samples) -> Tree {
        match self.cut {
            None => Tree::leaf(0),
            Some((g, rank)) => Tree::join(samples.features[g], rank, &Tree::leaf(0), &Tree::leaf(0)),
        }
    }
}

impl TwoLevels<'_> {
    /// The best tree of at most two levels (or one) if it costs less than `upper`.
    pub(crate) fn solve(&mut self, view: &View, depth: usize, upper: f64, floor: f64) -> NodeResult {
        let samples = self.samples;
        let penalty = samples.penalty;
        let leaf = view.leaf(samples);
        let Self { sides, scanner, histograms, .. } = self;
        sides.load(samples, view);
        if let Some(histograms) = histograms {
            histograms.load(samples, view);
        }
        let mut stump = Stump { cost: leaf, cut: None };
        let mut whole = Vec::with_capacity(samples.p);
        for g in 0..samples.p {
            let [_, found] = match histograms {
                Some(histograms) => histograms.scan(samples, view, g, sides, [f64::INFINITY; 2]),
                None => scanner.scan(samples, view, g, sides, [false, true]),
            };
            stump.see(g, &found, penalty);
            whole.push(found.relaxed);
        }
        self.effort.count();
        let mut best = NodeResult::cheapest(stump.cost, stump.tree(samples), upper);
        if depth == 1 {
            return best;
        }
        let relaxed = whole.iter().fold(leaf, |least, error| least.min(error + penalty));
        self.incumbents.clear();
        self.incumbents.resize(samples.p, f64::INFINITY);
        let mut order: Vec<usize> = (0..samples.p).collect();
        order.sort_by(|&f, &g| whole[f].total_cmp(&whole[g]));
        for f in order {
            let current = best.cost(upper);
            if current <= floor || self.effort.is_stopped() {
                break;
            }
            if let Some(found) = self.feature(view, f, &whole, (stump.cost, relaxed), current) {
                best.best = Some(found);
            }
        }
        best
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
            if self.effort.is_stopped() {
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
                let [left, right] = stumps.map(|stump| stump.tree(samples));
                let rank = view.rank_before(samples, f, axis.positions[k] as usize);
                (best, current) = (Some((cost, Tree::join(samples.features[f], rank, &left, &right))), cost);
            }
            open.extend(interval.halves(k).into_iter().rev().flatten());
        }
        self.axis = axis;
        best
    }

    fn begin_feature(&mut self, view: &View, f: usize, axis: &mut Axis, whole: &[f64]) {
        let Self { sides, medians, kept, histograms, .. } = self;
        sides.rewind(self.samples, view);
        if let Some(histograms) = histograms {
            histograms.rewind();
        }
        axis.lay_leaves(self.samples, view, f, sides, medians);
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
        let Self { sides, scanner, histograms, kept, now, orders, is_scanned, .. } = self;
        self.effort.count();
        sides.move_to(samples, view, f, axis.positions[k] as usize, |i, own, to| {
            if let Some(histograms) = histograms {
                histograms.pass(i, own, to);
            }
        });
        let of = |cut: usize| axis.evaluation[cut] as usize * p;
        let neighbours = (&kept[of(interval.a)..][..p], &kept[of(interval.b)..][..p]);
        axis.inherit(samples, interval, k, neighbours, now);
        for (side, order) in orders.iter_mut().enumerate() {
            order.clear();
            order.extend(0..p as u32);
            order.sort_unstable_by(|&g, &h| now[g as usize].of(side).total_cmp(&now[h as usize].of(side)));
        }
        is_scanned.clear();
        is_scanned.resize(p, false);
        let mut stumps = [0, 1].map(|side| Stump { cost: axis.leaves[k].of(side), cut: None });
        let mut next = [0; 2];
        let lower = loop {
            let mut lower = [0.0; 2];
            let mut wanted = [None; 2];
            for side in [0, 1] {
                while next[side] < p && is_scanned[orders[side][next[side]] as usize] {
                    next[side] += 1;
                }
                let g = orders[side].get(next[side]).map(|&g| g as usize);
                let least = g.map_or(f64::INFINITY, |g| now[g].of(side) + penalty);
                lower[side] = least.min(stumps[side].cost);
                wanted[side] = g.filter(|_| least < stumps[side].cost);
            }
            let Some(g) = wanted[0].or(wanted[1]) else { break lower };
            if lower[0] + lower[1] >= threshold {
                break lower;
            }
            let needs = [0, 1].map(|side| now[g].of(side) + penalty < stumps[side].cost);
            let found = match histograms {
                Some(histograms) => {
                    let beat = [0, 1].map(|side| if needs[side] { stumps[side].cost - penalty } else { -1.0 });
                    histograms.scan(samples, view, g, sides, beat)
                }
                None => scanner.scan(samples, view, g, sides, needs),
            };
            is_scanned[g] = true;
            for side in [0, 1] {
                if needs[side] {
                    stumps[side].see(g, &found[side], penalty);
                    now[g].raise(side, found[side].relaxed);
                }
            }
        };
        let relaxed = |side: usize| {
            if samples.leaf_size == 1 {
                return lower[side];
            }
            now.iter().fold(axis.leaves[k].of(side), |least, pair| least.min(pair.of(side) + penalty))
        };
        axis.relaxed[k] = Pair { left: relaxed(0), right: relaxed(1) };
        axis.solved[k] = Pair { left: lower[0], right: lower[1] };
        axis.evaluation[k] = (kept.len() / p) as u32;
        kept.extend_from_slice(now);
        stumps
    }
}

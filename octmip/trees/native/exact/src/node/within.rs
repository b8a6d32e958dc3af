//! The cuts of a node that trees below a fixed cost may have, none missed: a node's search whose target never falls.
//!
//! A cut is passed over only where the bounds of `axis` prove that its children together cost no less than the target,
//! exactly as in the search for the best tree; there the target follows the best tree, here it stays.

use std::collections::VecDeque;

use crate::node::axis::Axis;
use crate::node::result::Solved;
use crate::node::search::{Cut, Search};
use crate::stumps::place::{Place, StumpSolver};
use crate::view::View;
use octmip_frame::interval::Interval;

impl Search<'_> {
    /// Lower bound, up to `upper`, of the trees of one level less than `depth` on all samples of a node.
    pub fn shallower_bound(&mut self, view: &View, depth: usize, upper: i64) -> i64 {
        if depth == 3 {
            self.prepare(view);
        }
        self.shallower(view, depth - 1, upper, 0).0.lower
    }

    /// Cuts at the root of trees of at most `depth` levels (2 or more) that may cost less than `upper`, with lower
    /// bounds of both children that together stay below it; of the usable features `features`, None when stopped.
    ///
    /// `whole` is the node's `shallower_bound`.
    pub fn cuts_within(
        &mut self,
        view: &View,
        depth: usize,
        upper: i64,
        whole: i64,
        features: std::ops::Range<usize>,
    ) -> Option<Vec<Solved>> {
        let mut found = Vec::new();
        let target = upper.saturating_sub(self.samples.penalty);
        if target <= 0 || view.len < 2 * self.samples.leaf_size || features.is_empty() {
            return Some(found);
        }
        if self.samples.n_labels == 1 {
            features.for_each(|f| self.every_cut(view, f, &mut found));
        } else if depth == 2 {
            let mut solver = self.take_solver(view);
            let whole = solver.load(self.free_samples(), view).lower;
            for f in features {
                self.stump_cuts(&mut *solver, view, f, whole, target, &mut found);
            }
            self.return_solver(view, solver);
        } else {
            if depth == 3 {
                self.prepare(view);
            }
            for f in features {
                self.deep_cuts(view, depth, f, whole, target, &mut found);
            }
        }
        self.report_effort();
        (!self.is_stopped()).then_some(found)
    }

    /// All cuts of feature `f`, where one label is best for all samples and nothing is to be bounded.
    fn every_cut(&mut self, view: &View, f: usize, found: &mut Vec<Solved>) {
        self.axis.lay(self.samples, view, (f, self.leaf_size), 2, 0, &self.switches);
        let inner = &self.axis.positions[1..self.axis.last().max(1)];
        found.extend(inner.iter().map(|&k| Solved { feature: f, position: k as usize, bounds: [0, 0] }));
    }

    /// Cuts of feature `f` whose sides' best stumps cost less than `target` together.
    fn stump_cuts(
        &mut self,
        solver: &mut dyn StumpSolver,
        view: &View,
        f: usize,
        whole: i64,
        target: i64,
        found: &mut Vec<Solved>,
    ) {
        let samples = self.samples;
        let mut axis = std::mem::take(&mut self.axis);
        axis.lay(samples, view, (f, self.leaf_size), 2, whole, &self.switches);
        let mut is_fresh = true;
        let mut open: Vec<Interval> = axis.whole().into_iter().collect();
        while let Some((interval, k)) = open.pop().map(|interval| next(&axis, interval, target)) {
            let Some((interval, k)) = interval.zip(k) else { continue };
            if self.is_stopped() {
                break;
            }
            if std::mem::take(&mut is_fresh) {
                solver.rewind();
            }
            let position = axis.positions[k] as usize;
            let place = Place::new(samples, view, f, position, target);
            let threshold = target + if self.switches.slack { axis.slack(&interval, k) } else { 0 };
            let stumps = solver.both(self.free_samples(), &place, threshold);
            self.n_evaluated += 1;
            let around = (&axis, &interval, k);
            let (stumps, free) = self.fitting_stumps(&*solver, &place, threshold, stumps, around);
            let bounds = stumps.map(|stump| stump.lower);
            axis.enter(k, bounds, free);
            if bounds[0] + bounds[1] < target {
                found.push(Solved { feature: f, position, bounds });
            }
            open.extend(interval.halves(k).into_iter().flatten());
        }
        self.axis = axis;
    }

    /// Cuts of feature `f` whose sides' best trees, one level lower, cost less than `target` together.
    fn deep_cuts(&mut self, view: &View, depth: usize, f: usize, whole: i64, target: i64, found: &mut Vec<Solved>) {
        let samples = self.samples;
        let mut axis = Axis::default();
        let mut sides = [View::default(), View::default()];
        axis.lay(samples, view, (f, self.leaf_size), 1 << (depth - 1).min(20), whole, &self.switches);
        let mut queue: VecDeque<Interval> = axis.whole().into_iter().collect();
        while let Some((interval, k)) = queue.pop_front().map(|interval| next(&axis, interval, target)) {
            let Some((interval, k)) = interval.zip(k) else { continue };
            let slack = if self.switches.slack { axis.slack(&interval, k) } else { 0 };
            let position = axis.positions[k] as usize;
            let cut = Cut {
                feature: f,
                position,
                bounds: axis.bounds(&interval, k).into(),
                free: axis.free_bounds(&interval, k),
                sizes: axis.sizes(&interval, k),
                target,
                is_free: false,
                slack,
            };
            let children = self.children(view, depth, &cut, &mut sides);
            if self.is_stopped() {
                break;
            }
            axis.enter(k, children.bounds, children.free);
            if children.bounds[0] + children.bounds[1] < target {
                found.push(Solved { feature: f, position, bounds: children.bounds });
            }
            queue.extend(interval.halves(k).into_iter().flatten());
        }
        self.report_effort();
    }
}

/// An interval less the cuts that are proven to cost too much, and the next cut of it to be solved.
fn next(axis: &Axis, interval: Interval, target: i64) -> (Option<Interval>, Option<usize>) {
    let narrowed = axis.narrow(interval, target);
    (narrowed, narrowed.and_then(|interval| axis.pick(&interval, target)))
}

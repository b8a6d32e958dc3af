//! Bounds for trees that change few splits of an old one, and the cuts that these leave open.
//!
//! A tree here may keep an old split that no longer parts anything, and its leaves have any size. Such trees cost no
//! more on fewer samples, and at most the range of the new samples more on more of them, so all the bounds of
//! `node::axis` hold for them, share by share of the changes. What they cost bounds the trees that are asked for, which
//! are searched only where these bounds stay below the target. A side without a change costs what it does: its leaves
//! are counted along the feature.

use std::collections::VecDeque;

use crate::node::axis::{Axis, Beside};
use crate::shaped::few::open;
use crate::shaped::parts::{Asked, Found, Parts, shares};
use crate::shaped::rules::Rules;
use crate::switches::Switches;
use crate::view::View;
use octmip_frame::interval::Interval;

/// Changes on the left and the right side of a cut, and what trees with them cost on all samples of a node at least.
struct Share {
    changes: [usize; 2],
    whole: [i64; 2],
}

impl Parts<'_> {
    /// Whether these bounds hold at a node.
    pub(super) fn has_few_changes(&self, asked: &Asked) -> bool {
        self.kept.is_some() && asked.given.is_none() && asked.old.is_some() && asked.changes > 0
    }

    /// The best tree that changes at most so many splits, if it costs less than `upper`.
    pub(super) fn by_changes(&mut self, view: &View, asked: &Asked, mut upper: i64) -> Found {
        let mut best = None;
        let kept = asked.old.map(|old| self.named_cuts(view, &self.rules.old[old])).unwrap_or_default();
        for cut in kept {
            if let Some(found) = self.both(view, asked, cut, upper) {
                upper = found.0;
                best = Some(found);
            }
        }
        let rows = self.rules_below(asked.old);
        let depth = asked.depth - 1;
        let shares: Vec<Share> = shares(asked.changes - 1, self.most_changes(rows, depth))
            .into_iter()
            .map(|changes| {
                let whole = [0, 1].map(|side| self.least(view, (depth, rows[side], changes[side]), upper));
                Share { changes, whole }
            })
            .collect();
        for f in 0..self.samples.p {
            if self.control.is_stopped() {
                break;
            }
            if let Some(found) = self.new_split(view, asked, f, &shares, upper) {
                upper = found.0;
                best = Some(found);
            }
        }
        best
    }

    /// The best tree with a new split of feature `f` at its root, if it costs less than `upper`.
    fn new_split(&mut self, view: &View, asked: &Asked, f: usize, shares: &[Share], mut upper: i64) -> Found {
        let rows = self.rules_below(asked.old);
        let depth = asked.depth - 1;
        let mut axes: Vec<Axis> = shares.iter().map(|share| self.axis(view, f, (depth, rows), share)).collect();
        let mut queue: VecDeque<Interval> = axes[0].whole().into_iter().collect();
        let mut views = [View::default(), View::default()];
        let mut best = None;
        while let Some(interval) = queue.pop_front() {
            let target = upper - self.samples.penalty;
            let left: Vec<_> = axes.iter().filter_map(|axis| open(axis, interval, target)).collect();
            let Some(&(first, k)) = left.first() else { continue };
            // What is closed for every share is left out.
            let low = left.iter().map(|(interval, _)| interval.low).min().unwrap_or(first.low);
            let high = left.iter().map(|(interval, _)| interval.high).max().unwrap_or(first.high);
            let interval = Interval { low, high, ..interval };
            let position = axes[0].positions[k] as usize;
            view.split(self.samples, f, position, &mut self.marks, &mut views);
            let slack = axes[0].slack(&interval, k);
            let (mut least, mut together) = ([i64::MAX; 2], i64::MAX);
            for (axis, Share { changes, .. }) in axes.iter_mut().zip(shares) {
                let mut bounds = <[i64; 2]>::from(axis.bounds(&interval, k));
                for side in [0, 1].into_iter().filter(|&side| changes[side] > 0) {
                    if bounds[0] + bounds[1] >= target {
                        break;
                    }
                    let most = target + slack - bounds[1 - side];
                    let found = self.least(&views[side], (depth, rows[side], changes[side]), most);
                    bounds[side] = bounds[side].max(found);
                }
                axis.enter(k, bounds, Beside::default());
                least = [0, 1].map(|side| least[side].min(bounds[side]));
                together = together.min(bounds[0] + bounds[1]);
            }
            if self.control.is_stopped() {
                return best;
            }
            if together < target
                && let Some(found) = self.both(view, asked, (f, position, least), upper)
            {
                upper = found.0;
                best = Some(found);
            }
            queue.extend(interval.halves(k).into_iter().flatten());
        }
        best
    }

    /// The cuts of a feature for trees of a share of the changes.
    fn axis(&self, view: &View, f: usize, (depth, rows): (usize, [Option<usize>; 2]), share: &Share) -> Axis {
        let (samples, kept) = (self.samples, self.kept.as_deref().unwrap_or_default());
        let kept = rows.map(|row| &kept[row.unwrap_or(kept.len() - 1)]);
        let n_leaves = kept.iter().map(|kept| kept.n_leaves).max().unwrap_or(1).max(1 << depth.min(20));
        let mut axis = Axis::default();
        axis.lay(samples, view, (f, samples.leaf_size), n_leaves, 0, &Switches::default());
        let last = axis.last();
        [axis.left[last], axis.right[0]] = share.whole;
        for side in [0, 1].into_iter().filter(|&side| share.changes[side] == 0) {
            let costs = kept[side].costs(samples, view, f, (&axis.positions[..=last], side));
            axis.take_up_costs(side, &costs);
        }
        axis
    }

    /// What trees of at most `depth` levels with so many changes of the old tree below a place cost at least: up to
    /// `upper`.
    fn least(&mut self, view: &View, (depth, row, changes): (usize, Option<usize>, usize), upper: i64) -> i64 {
        let kept = self.kept.as_deref().unwrap_or_default();
        let own = kept[row.unwrap_or(kept.len() - 1)].cost(self.samples, view);
        if changes == 0 || view.len == 0 {
            return own;
        }
        let rows = self.rules_below(row);
        if depth < 2 || row.is_none() || changes > 1 {
            let levels = if row.is_none() { depth.min(changes) } else { depth };
            return self.free[0].solve(view, levels, (1 << levels.min(20)) - 1, upper).lower.min(own);
        }
        // One change: of the root, of one side, or no change.
        let mut least = own;
        let price = self.samples.penalty;
        if kept_splits(self.rules, row) <= 1 {
            least = least.min(view.leaf());
        }
        for f in 0..self.samples.p {
            let kept = self.kept.as_deref().unwrap_or_default();
            let mut axis = Axis::default();
            axis.lay_positions(self.samples, view, f);
            let positions = &axis.positions[..=axis.last()];
            let costs = [0, 1]
                .map(|side| kept[rows[side].unwrap_or(kept.len() - 1)].costs(self.samples, view, f, (positions, side)));
            let both = costs[0].iter().zip(&costs[1]).map(|(left, right)| left + right + price).min();
            least = least.min(both.unwrap_or(i64::MAX));
        }
        let Some(views) = row.and_then(|row| self.kept_sides(view, row)) else { return 0 };
        for (side, other) in [(0, 1), (1, 0)] {
            let kept = self.kept.as_deref().unwrap_or_default();
            let fixed = kept[rows[other].unwrap_or(kept.len() - 1)].cost(self.samples, &views[other]) + price;
            if fixed < least {
                let changed = self.least(&views[side], (depth - 1, rows[side], changes), least.min(upper) - fixed);
                least = least.min(fixed + changed);
            }
        }
        least
    }

    /// The samples on both sides of an old split, one of them perhaps empty.
    fn kept_sides(&mut self, view: &View, row: usize) -> Option<[View; 2]> {
        let &[(column, Some(cut))] = self.rules.old[row].splits.as_slice() else { return None };
        let f = self.samples.features.iter().position(|&usable| usable == column)?;
        let ranks = self.samples.ranks_of(f);
        let position = view.list(f).partition_point(|&i| ranks[i as usize] <= cut);
        let mut views = [View::default(), View::default()];
        view.split(self.samples, f, position, &mut self.marks, &mut views);
        Some(views)
    }

    fn rules_below(&self, row: Option<usize>) -> [Option<usize>; 2] {
        row.map_or([None; 2], |row| self.rules.old[row].sides)
    }

    /// So many changes at most are of use on both sides of a cut.
    pub(super) fn most_changes(&self, rows: [Option<usize>; 2], depth: usize) -> [usize; 2] {
        rows.map(|row| kept_splits(self.rules, row) + (1 << depth.min(20)) - 1)
    }
}

fn kept_splits(rules: &Rules, row: Option<usize>) -> usize {
    row.map_or(0, |row| rules.old[row].n_splits)
}

//! Trees of which parts are asked for: given splits, features that may not follow each other, few changes of a tree.
//!
//! Each of them is settled by what lies above a node, so both sides of a cut are independent but for numbers that they
//! share:
//!
//! ```text
//! given splits     the node's own row of the table of given splits
//! path rules       the features that are banned below the splits above
//! few changes      the old tree's row at this place, and how many changes are left: shared out like splits
//! ```
//!
//! A node is solved without all that first, over the features that are not banned. What it costs then is a bound, and a
//! tree that obeys is the answer. Else its cuts are searched one by one.

use std::sync::Arc;

use crate::node::price::levels_below;
use crate::samples::Samples;
use crate::shaped::few::{Few, least_size};
use crate::shaped::last_cuts::{Cut, last_cuts};
use crate::shaped::left::{Left, with};
use crate::shaped::old_tree::Kept;
use crate::shaped::rules::{NO_LIMIT, Named, Rules};
use crate::shaped::wanted::Known;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::tree::Tree;

/// So many changes are allowed one by one before all are.
const MOST_CHANGES_FIRST: usize = 6;

/// What is asked for at a node.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    pub(super) given: Option<usize>,
    pub(super) old: Option<usize>,
    /// Changes that are left below.
    pub(super) changes: usize,
    /// Of each usable feature (`p`).
    pub(super) banned: Arc<[bool]>,
    /// The search that bounds this node: over features that hold all those left.
    free: usize,
    pub(super) depth: usize,
    splits: usize,
}

/// A tree that was found and its cost.
pub(super) type Found = Option<(i64, Tree)>;

/// A search for trees with parts that are asked for.
pub(super) struct Parts<'a> {
    pub(super) samples: &'a Samples,
    pub(super) rules: &'a Rules,
    /// Of each usable feature those that are banned below it.
    pub(super) bans: Vec<Vec<usize>>,
    lefts: &'a [Left],
    pub(super) free: Vec<Few<'a>>,
    pub(super) control: &'a Control,
    pub(super) marks: Vec<bool>,
    /// The old tree place by place, where its changes are bounded as in `changes`.
    pub(super) kept: Option<Vec<Kept>>,
    /// What the best tree of any number of changes costs; how many it makes, where it has the other parts, and itself.
    free_root: Option<(i64, Option<(usize, Tree)>)>,
    n_solved: u64,
}

impl<'a> Parts<'a> {
    /// Workspaces for trees of at most `depth` levels and `splits` splits.
    pub(super) fn new(
        samples: &'a Samples,
        rules: &'a Rules,
        lefts: &'a [Left],
        control: &'a Control,
        (depth, splits): (usize, usize),
    ) -> Self {
        let is_simple = samples.leaf_size <= 1 && lefts.len() == 1 && !rules.old.is_empty();
        Self {
            kept: if is_simple { Kept::of_all(samples, rules) } else { None },
            bans: rules.bans_of(&samples.features),
            free: lefts.iter().map(|left| Few::new(&left.samples, control, depth, splits)).collect(),
            marks: vec![false; samples.n],
            free_root: None,
            n_solved: 0,
            samples,
            rules,
            lefts,
            control,
        }
    }

    /// More than the best tree costs: one that has the parts has them still once only their splits are left.
    pub(super) fn beyond(samples: &Samples, view: &View, rules: &Rules) -> i64 {
        view.total_range + samples.penalty * (rules.given.len() + rules.old.len()) as i64 + 1
    }

    /// Search all samples, trees of fewer levels or changes first: they are found sooner, and cost little more.
    ///
    /// Trees of more levels than those searched so far pay for as many splits.
    pub(super) fn search(mut self, view: &View, (most, splits): (usize, usize), known: &Known) {
        let last = (most, self.rules.max_changes);
        let is_near = !self.rules.old.is_empty();
        let price = self.samples.penalty;
        known.raise(price * self.rules.given.iter().filter(|row| row.n_splits > 0).count() as i64);
        let sizes: Vec<(usize, usize)> = if is_near {
            (0..last.1.min(MOST_CHANGES_FIRST)).map(|changes| (most, changes)).collect()
        } else {
            (1..most).map(|depth| (depth, last.1)).collect()
        };
        for (depth, changes) in sizes.into_iter().chain([last]) {
            if let Some((cost, tree)) = self.free_within(changes) {
                known.see(cost, || tree);
            }
            let is_known = self.free_root.as_ref().is_some_and(|free| known.best().0 <= free.0);
            if is_known || (!is_near && depth > levels_below(known.best().0, price, most).max(1)) {
                break;
            }
            let asked = Asked {
                given: (!self.rules.given.is_empty()).then_some(0),
                old: is_near.then_some(0),
                changes,
                banned: self.lefts[0].banned.clone(),
                free: 0,
                depth,
                splits: least_size(depth, splits).1,
            };
            // What trees of more levels cost at least, where all changes are allowed.
            let others = match (is_near, (depth, changes) == last) {
                (_, true) => i64::MAX,
                (true, false) => 0,
                (false, false) => price.saturating_mul(depth as i64 + 1),
            };
            let found = self.solve_node(view, &asked, known.best().0, Some((known, others)));
            if let Some((cost, tree)) = found {
                known.see(cost, || tree);
            }
            if self.control.is_stopped() {
                return;
            }
            known.raise(known.best().0.min(others));
        }
        known.raise(known.best().0);
    }

    /// The best tree of any number of changes, where it is known and makes no more than so many.
    fn free_within(&self, changes: usize) -> Found {
        let (cost, Some((made, tree))) = self.free_root.as_ref()? else { return None };
        (*made <= changes).then(|| (*cost, tree.clone()))
    }

    /// The best tree of a node if it costs less than `upper`; at the root, bounds are shown.
    fn solve_node(&mut self, view: &View, asked: &Asked, upper: i64, known: Option<(&Known, i64)>) -> Found {
        self.count();
        if self.control.is_stopped() {
            return None;
        }
        let asked = self.reduced(asked, view.len, upper);
        let is_leaf = asked.given.is_some_and(|given| self.rules.given[given].is_leaf);
        let mut best = self.leaf(view, &asked, upper);
        let upper = best.as_ref().map_or(upper, |best| best.0);
        let is_small = view.len < 2 * self.samples.leaf_size || self.lefts[asked.free].columns.is_empty();
        if is_leaf || asked.depth == 0 || is_small || upper <= self.samples.penalty {
            return best;
        }
        // Where all splits stay there is one cut, and nothing to bound. All samples are searched once.
        let is_bounded = known.is_some() && self.free_root.is_some();
        if (asked.changes > 0 || asked.old.is_none()) && !is_bounded {
            let found = self.free_tree(view, &asked, upper);
            if self.control.is_stopped() {
                return best;
            }
            let ids: Vec<u32> = view.ids(self.samples).collect();
            let below = (asked.given, asked.old);
            let found = found.map(|(cost, free)| (cost, self.changes_of(&free, 0, &ids, below, &asked.banned), free));
            if let Some((cost, Some(changes), free)) = &found
                && *changes <= asked.changes
            {
                return Some((*cost, free.clone()));
            }
            let cost = found.as_ref().map_or(upper, |found| found.0);
            if let Some((known, others)) = known {
                known.raise(if asked.old.is_some() { cost } else { cost.min(others) });
            }
            if found.is_none() {
                return best;
            }
            if known.is_some() && asked.old.is_some() {
                self.free_root = Some((cost, found.and_then(|(_, changes, free)| Some((changes?, free)))));
            }
        }
        if self.has_few_changes(&asked) {
            return self.by_changes(view, &asked, upper).or(best);
        }
        let Some(mut cuts) = self.cuts(view, &asked, upper) else { return best };
        cuts.sort_by_key(|cut| cut.2[0] + cut.2[1]);
        let mut upper = upper;
        for cut in cuts {
            let bound = cut.2[0] + cut.2[1] + self.samples.penalty;
            if bound >= upper || self.control.is_stopped() {
                break;
            }
            if let Some((known, others)) = known {
                known.raise(bound.min(others));
            }
            if let Some(found) = self.both(view, &asked, cut, upper) {
                upper = found.0;
                best = Some(found);
            }
        }
        best
    }

    /// What is asked for, without numbers that rule nothing out.
    fn reduced(&self, asked: &Asked, n_samples: usize, upper: i64) -> Asked {
        let mut asked = asked.clone();
        let depth = levels_below(upper, self.samples.penalty, asked.depth);
        (asked.depth, asked.splits) = least_size(depth, asked.splits.min(n_samples - 1));
        if let Some(old) = asked.old {
            if asked.changes >= self.rules.old[old].n_splits + asked.splits {
                (asked.old, asked.changes) = (None, NO_LIMIT);
            }
        } else {
            // Below the old tree every split is a change.
            (asked.depth, asked.splits) = least_size(asked.depth, asked.splits.min(asked.changes));
            asked.changes = NO_LIMIT;
        }
        asked
    }

    fn leaf(&self, view: &View, asked: &Asked, upper: i64) -> Found {
        let is_split = asked.given.is_some_and(|given| self.rules.given[given].n_splits > 0);
        let gone = asked.old.map_or(0, |old| self.rules.old[old].n_splits);
        let cost = view.leaf();
        let is_allowed = !is_split && gone <= asked.changes && cost < upper;
        is_allowed.then(|| (cost, Tree::leaf(self.samples.labels[view.best_label()])))
    }

    /// The best tree over the features that are left, whatever else is asked, if it costs less than `upper`.
    fn free_tree(&mut self, view: &View, asked: &Asked, upper: i64) -> Found {
        let left = &self.lefts[asked.free];
        let own = self.own_view(view, asked.free);
        let own = own.as_ref().unwrap_or(view);
        let (cost, plan) = self.free[asked.free].solve(own, asked.depth, asked.splits, upper).best?;
        Some((cost, plan.tree(&left.samples, own)))
    }

    /// The samples of a node with the features that are left; None where all are.
    fn own_view(&self, view: &View, free: usize) -> Option<View> {
        let left = &self.lefts[free];
        let ids = || view.ids(self.samples).collect::<Vec<u32>>();
        (left.columns.len() < self.samples.p).then(|| View::subset(&left.samples, &ids()))
    }

    /// The cuts of a node that obey and whose sides may cost less than `upper` together; None when stopped.
    fn cuts(&mut self, view: &View, asked: &Asked, upper: i64) -> Option<Vec<Cut>> {
        let named = asked.given.map(|given| &self.rules.given[given]).filter(|named| !named.splits.is_empty());
        let kept = asked.old.filter(|_| asked.changes == 0).map(|old| &self.rules.old[old]);
        let fixed = [named, kept].into_iter().flatten();
        if let Some(only) = fixed.clone().find(|named| named.splits.iter().all(|(_, cut)| cut.is_some())) {
            let cuts = self.named_cuts(view, only);
            return Some(cuts.into_iter().filter(|cut| self.obeys(view, cut, asked)).collect());
        }
        let fixed: Vec<&Named> = fixed.collect();
        let is_wanted = |column: u32| fixed.iter().all(|named| named.splits.iter().any(|split| split.0 == column));
        let columns: Vec<usize> = self.lefts[asked.free].columns.clone();
        let wanted: Vec<usize> = (0..columns.len()).filter(|&g| is_wanted(self.samples.features[columns[g]])).collect();
        let found = self.found_cuts(view, asked, upper, &wanted)?;
        let cuts = found.into_iter().map(|(g, position, bounds)| (columns[g], position, bounds));
        Some(cuts.filter(|cut| self.obeys(view, cut, asked)).collect())
    }

    /// Cuts of some of the features that are left, numbered among these.
    fn found_cuts(&mut self, view: &View, asked: &Asked, upper: i64, wanted: &[usize]) -> Option<Vec<Cut>> {
        let own = self.own_view(view, asked.free);
        let own = own.as_ref().unwrap_or(view);
        // Below the one change that is left both sides stay, and to look at every cut is quicker than to bound it.
        let is_one_change = asked.old.is_some() && asked.changes == 1;
        if asked.depth == 1 || is_one_change {
            let samples = &self.lefts[asked.free].samples;
            let target = if asked.depth == 1 { upper - samples.penalty } else { i64::MAX };
            let cut = |(f, position, bounds): Cut| (f, position, if asked.depth == 1 { bounds } else { [0, 0] });
            let cuts = |&g: &usize| last_cuts(samples, own, g, target).into_iter().map(cut);
            return Some(wanted.iter().flat_map(cuts).collect());
        }
        let search = &mut self.free[asked.free].search;
        search.forget();
        let whole = search.shallower_bound(own, asked.depth, upper);
        let n_left = self.lefts[asked.free].columns.len();
        let ranges: Vec<_> = if wanted.len() == n_left {
            std::iter::once(0..n_left).collect()
        } else {
            wanted.iter().map(|&g| g..g + 1).collect()
        };
        let mut cuts = Vec::new();
        for range in ranges {
            search.forget();
            let found = search.cuts_within(own, asked.depth, upper, whole, range)?;
            cuts.extend(found.into_iter().map(|cut| (cut.feature, cut.position, cut.bounds)));
        }
        Some(cuts)
    }

    /// The best tree with this cut at its root, if it costs less than `upper`: splits and changes are shared out.
    pub(super) fn both(&mut self, view: &View, asked: &Asked, (f, position, bounds): Cut, mut upper: i64) -> Found {
        let mut views = [View::default(), View::default()];
        view.split(self.samples, f, position, &mut self.marks, &mut views);
        let cut = self.samples.ranks_of(f)[view.list(f)[position - 1] as usize];
        let is_kept = |old: &Named| self.is_named(old, f, position, view.list(f));
        let changes = match asked.old.map(|old| &self.rules.old[old]) {
            None => NO_LIMIT,
            Some(old) if is_kept(old) => asked.changes,
            Some(_) => asked.changes.checked_sub(1)?,
        };
        let sides = [0, 1].map(|side| self.below(asked, f, side));
        let most = (1 << (asked.depth - 1).min(20)) - 1;
        let most_changes = self.most_changes(sides.each_ref().map(|side| side.old), asked.depth - 1);
        let mut best = None;
        for splits in shares(asked.splits - 1, [most, most]) {
            for changes in shares(changes, most_changes) {
                let own = |side: usize| Asked { splits: splits[side], changes: changes[side], ..sides[side].clone() };
                let budget = upper - self.samples.penalty;
                let Some(left) = self.solve_node(&views[0], &own(0), budget - bounds[1], None) else { continue };
                let Some(right) = self.solve_node(&views[1], &own(1), budget - left.0, None) else { continue };
                upper = left.0 + right.0 + self.samples.penalty;
                best = Some((upper, Tree::join(self.samples.features[f], cut, &left.1, &right.1)));
            }
        }
        best
    }

    /// What is asked for on one side of a cut of feature `f`, its numbers not yet shared out.
    fn below(&self, asked: &Asked, f: usize, side: usize) -> Asked {
        let banned = with(&asked.banned, &self.bans[f]);
        let free = self.lefts.iter().position(|left| left.banned == banned).unwrap_or(asked.free);
        Asked {
            given: asked.given.and_then(|given| self.rules.given[given].sides[side]),
            old: asked.old.and_then(|old| self.rules.old[old].sides[side]),
            banned,
            free,
            depth: asked.depth - 1,
            ..asked.clone()
        }
    }

    fn count(&mut self) {
        self.n_solved += 1;
        if self.n_solved.is_multiple_of(64) {
            self.control.add(64);
        }
    }
}

/// The ways to share out a number between two sides that have use for so many at most: one where it suffices for both.
pub(super) fn shares(number: usize, most: [usize; 2]) -> Vec<[usize; 2]> {
    if number >= most[0] + most[1] {
        return vec![if number == NO_LIMIT { [NO_LIMIT; 2] } else { most }];
    }
    (number.saturating_sub(most[1])..=most[0].min(number)).map(|left| [left, number - left]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_shared_out_in_every_way_that_is_of_use() {
        assert_eq!(shares(2, [1, 3]), [[0, 2], [1, 1]]);
        assert_eq!(shares(3, [1, 1]), [[1, 1]]);
        assert_eq!(shares(0, [1, 1]), [[0, 0]]);
        assert_eq!(shares(NO_LIMIT, [3, 3]), [[NO_LIMIT; 2]]);
    }
}

//! Whether trees and cuts have the parts that are asked for.

use std::sync::Arc;

use crate::shaped::last_cuts::Cut;
use crate::shaped::left::with;
use crate::shaped::parts::{Asked, Parts};
use crate::shaped::rules::Named;
use crate::view::View;
use octmip_frame::tree::{Node as Row, Tree};

impl Parts<'_> {
    /// How many changes of the old tree a tree makes; None where it breaks a rule.
    pub(super) fn changes_of(
        &self,
        tree: &Tree,
        row: usize,
        ids: &[u32],
        (given, old): (Option<usize>, Option<usize>),
        banned: &Arc<[bool]>,
    ) -> Option<usize> {
        let named = given.map(|given| &self.rules.given[given]);
        let before = old.map(|old| &self.rules.old[old]);
        let Row::Split { feature, cut, left, right } = &tree.nodes[row] else {
            return named.is_none_or(|named| named.n_splits == 0).then(|| before.map_or(0, |old| old.n_splits));
        };
        let f = self.samples.features.iter().position(|usable| usable == feature)?;
        let ranks = self.samples.ranks_of(f);
        let (lefts, rights): (Vec<u32>, Vec<u32>) = ids.iter().partition(|&&i| ranks[i as usize] <= *cut);
        let sides = [lefts, rights];
        let is_named = |named: &Named| self.is_named(named, f, sides[0].len(), ids);
        if banned[f] || named.is_some_and(|named| named.is_leaf || (!named.splits.is_empty() && !is_named(named))) {
            return None;
        }
        let mut changes = usize::from(!before.is_some_and(is_named));
        let below = with(banned, &self.bans[f]);
        for (side, child) in [*left, *right].into_iter().enumerate() {
            let rows = (named.and_then(|named| named.sides[side]), before.and_then(|old| old.sides[side]));
            changes += self.changes_of(tree, child as usize, &sides[side], rows, &below)?;
        }
        Some(changes)
    }

    /// Whether a cut that sends so many samples left is the one that is named: it parts these samples alike.
    pub(super) fn is_named(&self, named: &Named, f: usize, n_left: usize, ids: &[u32]) -> bool {
        let ranks = self.samples.ranks_of(f);
        let count = |cut: u32| ids.iter().filter(|&&i| ranks[i as usize] <= cut).count();
        let column = self.samples.features[f];
        named.splits.iter().any(|&(of, cut)| of == column && cut.is_none_or(|cut| count(cut) == n_left))
    }

    /// The cuts that are named.
    pub(super) fn named_cuts(&self, view: &View, named: &Named) -> Vec<Cut> {
        let least = self.samples.leaf_size.max(1);
        let mut cuts = Vec::new();
        for &(column, cut) in &named.splits {
            let Some(f) = self.samples.features.iter().position(|&usable| usable == column) else { continue };
            let (ranks, list) = (self.samples.ranks_of(f), view.list(f));
            let position = list.partition_point(|&i| cut.is_none_or(|cut| ranks[i as usize] <= cut));
            if position >= least && view.len - position >= least {
                cuts.push((f, position, [0, 0]));
            }
        }
        cuts
    }

    /// Whether a cut has the parts that are asked for.
    pub(super) fn obeys(&self, view: &View, &(f, position, _): &Cut, asked: &Asked) -> bool {
        let is_named = |named: &Named| self.is_named(named, f, position, view.list(f));
        let is_kept = asked.changes > 0 || asked.old.is_none_or(|old| is_named(&self.rules.old[old]));
        let given = asked.given.map(|given| &self.rules.given[given]).filter(|named| !named.splits.is_empty());
        !asked.banned[f] && is_kept && given.is_none_or(is_named)
    }
}

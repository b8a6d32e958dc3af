//! A node before its search: what its leaf, results that are kept, or counts by value tell of it.

use crate::node::by_values::{Set, are_few};
use crate::node::kept::{Key, key};
use crate::node::plan::Plan;
use crate::node::price::levels_below;
use crate::node::result::NodeResult;
use crate::node::search::Search;
use crate::samples::levels_of;
use crate::view::View;

/// A node that needs a search: its key where results are kept, the levels that its trees may have, a bound.
pub(super) struct Unknown {
    key: Option<Key>,
    depth: usize,
    floor: i64,
}

impl Search<'_> {
    pub(super) fn solve_unlogged(
        &mut self,
        view: &View,
        depth: usize,
        upper: i64,
        floor: i64,
        free: Option<NodeResult>,
    ) -> NodeResult {
        let (len, totals, range) = (view.len, &view.totals[..], view.total_range);
        let has_ids = self.has_ids(len);
        let mut known = |ids: &[u32]| self.without_search(Set { len, ids, totals, range }, depth, upper, floor);
        let known = if has_ids { view.with_ids(&mut known) } else { known(&[]) };
        known.unwrap_or_else(|unknown| self.search_beside(view, depth, unknown, upper, free))
    }

    /// Whether the ids of a set of so many samples tell something without a search.
    fn has_ids(&self, len: usize) -> bool {
        self.samples.p > 0 && (self.keeps || self.counts(len))
    }

    /// Whether sets of so many samples are counted by value.
    pub(super) fn counts(&self, len: usize) -> bool {
        self.switches.by_values && self.price() > 0 && are_few(self.samples, len)
    }

    /// The result of a node where it takes no search.
    fn without_search(&mut self, set: Set<'_>, depth: usize, upper: i64, floor: i64) -> Result<NodeResult, Unknown> {
        // What the last search left is of another node.
        self.incumbents.clear();
        self.solved.clear();
        if upper <= floor {
            return Ok(NodeResult::none(floor));
        }
        let leaf = set.leaf();
        let mut depth = levels_below(upper.min(leaf), self.price(), depth);
        if self.leaf_size > 1 && self.log.is_none() {
            depth = depth.min(levels_of(set.len, self.leaf_size));
        }
        if self.is_leaf_best((leaf, set.len), depth, floor) {
            return Ok(NodeResult::cheapest(leaf, Plan::Leaf, upper));
        }
        let mut unknown = Unknown { key: None, depth, floor };
        if self.keeps && depth > 1 && self.leaf_size == self.samples.leaf_size {
            let key = key(self.samples, set.ids);
            match self.known.find(&key, depth, upper, self.samples.penalty) {
                Ok((result, incumbents)) => {
                    self.incumbents = incumbents;
                    return Ok(result);
                }
                Err(bound) => unknown = Unknown { key: Some(key), depth, floor: floor.max(bound) },
            }
        }
        if self.counts(set.len) {
            match self.by_values.solve(self.samples, set, depth, upper, unknown.floor) {
                Ok(result) => {
                    self.keep(unknown.key, depth, &result);
                    return Ok(result);
                }
                Err(bound) => unknown.floor = unknown.floor.max(bound),
            }
        }
        Err(unknown)
    }

    fn keep(&mut self, key: Option<Key>, depth: usize, result: &NodeResult) {
        if let Some(key) = key.filter(|_| !self.is_stopped()) {
            self.known.keep(key, depth, result, &self.incumbents);
        }
    }

    pub(super) fn search(&mut self, view: &View, asked: usize, unknown: Unknown, upper: i64) -> NodeResult {
        self.search_beside(view, asked, unknown, upper, None)
    }

    fn search_beside(
        &mut self,
        view: &View,
        asked: usize,
        unknown: Unknown,
        upper: i64,
        free: Option<NodeResult>,
    ) -> NodeResult {
        let Unknown { key, depth, floor } = unknown;
        if asked > 2 && depth <= 2 {
            self.forget(); // the buckets laid out last are those of a node of three levels somewhere else
        }
        if depth == 1 {
            return self.depth_one(view, upper);
        }
        let result = match free {
            Some(free) => self.beside(view, depth, upper, floor, (free, true)),
            None => self.searched(view, depth, upper, floor),
        };
        self.keep(key, depth, &result);
        result
    }

    /// The features that trees of `depth` levels below `upper` may have at the root of a node (`p`), by counts; no tree
    /// of a level less costs less than `whole`.
    pub(super) fn open_features(&mut self, view: &View, depth: usize, upper: i64, whole: i64) -> Vec<bool> {
        if !self.counts(view.len) {
            return vec![true; self.samples.p];
        }
        let (len, totals, range) = (view.len, &view.totals[..], view.total_range);
        let counted = view
            .with_ids(|ids| self.by_values.solve(self.samples, Set { len, ids, totals, range }, depth, upper, whole));
        let is_closed = counted.is_ok_and(|result| result.best.is_none());
        (0..self.samples.p).map(|f| !is_closed && self.by_values.is_open(f, self.price(), upper)).collect()
    }

    /// The result of one side of a cut where it takes no search, from the ids alone; None where they tell nothing.
    pub(super) fn part(
        &mut self,
        ids: &[u32],
        depth: usize,
        upper: i64,
        floor: i64,
    ) -> Result<NodeResult, Option<Unknown>> {
        if self.log.is_some() || !self.has_ids(ids.len()) {
            return Err(None);
        }
        let mut totals = std::mem::take(&mut self.totals);
        totals.clear();
        totals.resize(self.samples.n_labels, 0);
        ids.iter().for_each(|&i| self.samples.count(i, 1, &mut totals));
        let range = ids.iter().map(|&i| self.samples.ranges[i as usize]).sum();
        let found = self.without_search(Set { len: ids.len(), ids, totals: &totals, range }, depth, upper, floor);
        self.totals = totals;
        found.map_err(Some)
    }
}

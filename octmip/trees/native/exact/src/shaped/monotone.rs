//! The best tree whose predictions keep the order of some features.
//!
//! A node is searched beside leaves that are decided elsewhere in the tree. The best tree that need not keep any order
//! bounds it, and is the answer where it keeps the order by chance. Else all cuts of the root are taken whose sides'
//! free trees together stay below the best tree so far (`node::within`). The two sides of a cut of any other feature
//! than a monotone one are searched apart: their leaves part in the cut's feature, so nothing compares them. Those of a
//! monotone feature are `coupled`.
//!
//! Places of thresholds: a cut lies anywhere between two neighbouring ranks of its node, and where it lies decides
//! which boxes overlap. Move thresholds that are equal to the left together until they meet an end of another box or
//! the left end of the place of one of them: boxes overlap no more than before. So a cut of a node that is searched
//! beside decided leaves lies at an end of one of their boxes, or at its own left end.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use crate::samples::Samples;
use crate::shaped::boxes::{Bounds, Fixed, labels, order, side};
use crate::shaped::few::{Few, Key, least_size};
use crate::shaped::last_cuts::last_cuts;
use crate::shaped::wanted::{Known, Options};
use crate::view::View;
use octmip_check::problem::Problem;
use octmip_frame::tree::{Node as Row, Tree};

/// Cuts of nodes that are kept (16 MB at most; those of one more node may pass it).
const MOST_CUTS: usize = 1 << 19;

/// The cuts of a node are looked for in steps above the cost of its best tree in no order: by a `2^-FIRST_OF_COST` of
/// it, or a `2^-FIRST_OF_ROOM` of what lies between it and the budget, then `WIDER` times as far, and so on.
const FIRST_OF_COST: u32 = 8;
const FIRST_OF_ROOM: u32 = 10;
const WIDER: i64 = 4;

/// Samples of a node and its box.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub(super) view: View,
    pub(super) bounds: Bounds,
}

/// A cut of a node: feature, samples left of it, lower bounds of both sides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub feature: usize,
    pub position: usize,
    pub bounds: [i64; 2],
}

/// A tree that was found and its cost.
pub(super) type Found = Option<(i64, Tree)>;

/// Nodes whose best trees in no order are kept.
const MOST_KEPT: usize = 1 << 18;

/// The best tree of a node in no order, None where it was only proven to cost no less than the bound.
#[derive(Debug, Clone)]
struct Free {
    lower: i64,
    tree: Option<Tree>,
}

/// A search for monotone trees.
pub(super) struct Monotone<'a> {
    pub(super) samples: &'a Samples,
    pub(super) directions: Vec<i8>,
    pub(super) n_labels: u32,
    pub(super) penalty: i64,
    few: Few<'a>,
    known: &'a Known,
    /// The best trees of nodes in no order, or what they cost at least: a node comes again beside other decided leaves.
    free: HashMap<Key, Free>,
    /// Cuts of nodes at the root of trees that cost less than the budget beside them in no order.
    cuts: HashMap<Key, (i64, Rc<[Cut]>)>,
    n_cuts: usize,
    /// Cost of each label for each sample, above its base (`n * n_labels`).
    costs: Vec<i64>,
    marks: Vec<bool>,
    n_solved: u64,
}

impl<'a> Monotone<'a> {
    pub(super) fn new(problem: &Problem, options: &Options, few: Few<'a>, known: &'a Known) -> Self {
        let samples = few.samples;
        let cost = |i: usize, label: usize| {
            let row = &problem.costs[problem.labels[i] as usize * problem.n_classes..][..problem.n_classes];
            let least = row.iter().copied().min().unwrap_or(0);
            problem.weights[i] * (row[label] - least) / samples.unit
        };
        let costs = (0..samples.n).flat_map(|i| (0..problem.n_classes).map(move |label| (i, label)));
        Self {
            directions: samples.features.iter().map(|&f| options.directions[f as usize]).collect(),
            n_labels: problem.n_classes as u32,
            penalty: samples.penalty,
            known,
            free: HashMap::new(),
            cuts: HashMap::new(),
            n_cuts: 0,
            costs: costs.map(|(i, label)| cost(i, label)).collect(),
            marks: vec![false; samples.n],
            n_solved: 0,
            samples,
            few,
        }
    }

    /// Search all samples; `free` is the best tree in no order and its cost, where they are known.
    pub(super) fn search(mut self, view: &View, free: Found) {
        let largest = |f: usize| self.samples.ranks_of(f).iter().copied().max().unwrap_or(0);
        let bounds = (0..self.samples.p).map(|f| [0, largest(f)]).collect();
        let root = Node { view: view.clone(), bounds };
        let upper = self.known.best().0;
        let (depth, splits) = (self.few.depth, self.few.splits);
        if let Some((lower, tree)) = free {
            self.free.insert((self.few.bits(view), depth, splits), Free { lower, tree: Some(tree) });
        }
        let known = self.known;
        let found = self.solve_node(&root, (depth, splits), &[], upper, Some(known));
        let cost = found.as_ref().map_or(upper, |found| found.0);
        if let Some((cost, tree)) = found {
            known.see(cost, || tree);
        }
        if !self.is_stopped() {
            known.raise(cost);
        }
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.few.control.is_stopped()
    }

    /// The best tree of a node, in order with the decided leaves, if it costs less than `upper`.
    pub(super) fn solve(&mut self, node: &Node, size: (usize, usize), fixed: &[Fixed], upper: i64) -> Found {
        self.solve_node(node, size, fixed, upper, None)
    }

    fn solve_node(
        &mut self,
        node: &Node,
        (depth, splits): (usize, usize),
        fixed: &[Fixed],
        mut upper: i64,
        known: Option<&Known>,
    ) -> Found {
        self.count();
        if self.is_stopped() {
            return None;
        }
        let (depth, splits) = least_size(depth, splits);
        let fixed: Vec<Fixed> = fixed
            .iter()
            .filter(|leaf| order(&leaf.bounds, &node.bounds, &self.directions).is_some())
            .cloned()
            .collect();
        let mut best = self.best_leaf(node, &fixed, upper);
        upper = best.as_ref().map_or(upper, |best| best.0);
        if depth == 0 || upper <= self.penalty || !self.can_split(node) {
            return best;
        }
        let Some((cost, free)) = self.in_no_order(node, depth, splits, upper) else { return best };
        if self.keeps_order(node, &free, &fixed) {
            return Some((cost, free));
        }
        if let Some(known) = known {
            known.raise(cost);
        }
        if depth == 1 {
            return self.stump(node, &fixed, upper).or(best);
        }
        let mut tried = HashSet::new();
        let mut width = (cost >> FIRST_OF_COST).max((upper - cost) >> FIRST_OF_ROOM).max(1);
        loop {
            // Not those below `upper` at once: the first cuts may lower it far.
            let within = upper.min(cost + width);
            let Some(cuts) = self.cuts(node, depth, within) else { return best };
            for &cut in cuts.iter() {
                let bound = cut.bounds[0] + cut.bounds[1] + self.penalty;
                if bound >= within.min(upper) || self.is_stopped() {
                    break;
                }
                if !tried.insert((cut.feature, cut.position)) {
                    continue;
                }
                if let Some(known) = known {
                    known.raise(bound);
                }
                let views = self.split(node, &cut);
                for place in self.places(node, &cut, &fixed) {
                    if let Some(found) = self.both(node, &cut, place, &views, (depth, splits), &fixed, upper) {
                        upper = found.0;
                        if let Some(known) = known {
                            known.see(found.0, || found.1.clone());
                        }
                        best = Some(found);
                    }
                }
            }
            if within >= upper || self.is_stopped() {
                return best;
            }
            if let Some(known) = known {
                known.raise(within);
            }
            width *= WIDER;
        }
    }

    /// The best tree of a node in no order, if it costs less than `upper`; None also when stopped.
    fn in_no_order(&mut self, node: &Node, depth: usize, splits: usize, upper: i64) -> Found {
        let key = (self.few.bits(&node.view), depth, splits);
        match self.free.get(&key) {
            Some(Free { lower, tree: Some(tree) }) => return (*lower < upper).then(|| (*lower, tree.clone())),
            Some(Free { lower, tree: None }) if *lower >= upper => return None,
            _ => {}
        }
        let found = self.few.solve(&node.view, depth, splits, upper).best;
        if self.is_stopped() {
            return None;
        }
        let found = found.map(|(cost, plan)| (cost, plan.tree(self.samples, &node.view)));
        if self.free.len() < MOST_KEPT || self.free.contains_key(&key) {
            let lower = found.as_ref().map_or(upper, |found| found.0);
            self.free.insert(key, Free { lower, tree: found.as_ref().map(|found| found.1.clone()) });
        }
        found
    }

    /// The best tree with this cut at its root.
    #[allow(clippy::too_many_arguments)]
    fn both(
        &mut self,
        node: &Node,
        cut: &Cut,
        place: u32,
        views: &[View; 2],
        (depth, splits): (usize, usize),
        fixed: &[Fixed],
        mut upper: i64,
    ) -> Found {
        let part = |s: usize| Node { view: views[s].clone(), bounds: side(&node.bounds, cut.feature, place, s) };
        let sides = [part(0), part(1)];
        let most = (1 << (depth - 1).min(20)) - 1;
        let mut best = None;
        for left in (splits - 1).saturating_sub(most)..=most.min(splits - 1) {
            let sizes = [left, splits - 1 - left].map(|splits| (depth - 1, splits));
            let budget = upper - self.penalty;
            let Some(first) = self.solve(&sides[0], sizes[0], fixed, budget - cut.bounds[1]) else { continue };
            let Some(second) = self.solve(&sides[1], sizes[1], fixed, budget - first.0) else { continue };
            let found = self.joined(cut, place, first, second);
            if self.directions[cut.feature] == 0 || self.keeps_order(node, &found.1, fixed) {
                (upper, best) = (found.0, Some(found));
            }
        }
        if self.directions[cut.feature] == 0 || self.is_stopped() {
            return best;
        }
        // Each side alone bounds the two together; only where they do not fit are they searched as one.
        let bounds = [0, 1].map(|s| {
            let most = (depth - 1, splits - 1);
            let budget = upper - self.penalty - cut.bounds[1 - s];
            self.solve(&sides[s], most, fixed, budget).map_or(budget, |found| found.0)
        });
        if bounds[0] + bounds[1] + self.penalty >= upper {
            return best;
        }
        let budget = upper - self.penalty;
        let coupled = self.coupled(node, &sides, (depth - 1, splits - 1), fixed, bounds, budget);
        coupled.map(|sides| self.joined(cut, place, sides.0, sides.1)).or(best)
    }

    fn joined(&self, cut: &Cut, place: u32, left: (i64, Tree), right: (i64, Tree)) -> (i64, Tree) {
        let tree = Tree::join(self.samples.features[cut.feature], place, &left.1, &right.1);
        (left.0 + right.0 + self.penalty, tree)
    }

    pub(super) fn can_split(&self, node: &Node) -> bool {
        node.view.len >= 2 * self.samples.leaf_size && self.samples.p > 0
    }

    /// Cost of each label for all samples of a node (`n_labels`).
    pub(super) fn label_costs(&self, node: &Node) -> Vec<i64> {
        let mut sums = vec![0; self.n_labels as usize];
        for i in node.view.ids(self.samples) {
            sums.iter_mut().zip(self.costs_of(i)).for_each(|(sum, cost)| *sum += cost);
        }
        sums
    }

    /// Cost of each label for a sample (`n_labels`).
    pub(super) fn costs_of(&self, sample: u32) -> &[i64] {
        let n = self.n_labels as usize;
        &self.costs[sample as usize * n..][..n]
    }

    fn best_leaf(&self, node: &Node, fixed: &[Fixed], upper: i64) -> Found {
        let [low, high] = labels(&node.bounds, fixed, &self.directions, self.n_labels);
        let costs = self.label_costs(node);
        let label = (low..=high).min_by_key(|&label| costs[label as usize])?;
        let cost = costs[label as usize];
        (cost < upper).then(|| (cost, Tree::leaf(label)))
    }

    /// Cuts of a node at the root of trees whose sides cost less than `upper` together in no order, the one that may
    /// cost least first; None when stopped.
    pub(super) fn cuts(&mut self, node: &Node, depth: usize, upper: i64) -> Option<Rc<[Cut]>> {
        let key = (self.few.bits(&node.view), depth, 0);
        if let Some((within, cuts)) = self.cuts.get(&key)
            && *within >= upper
        {
            return Some(cuts.clone());
        }
        let mut cuts = self.cuts_within(node, depth, upper)?;
        cuts.sort_by_key(|cut| cut.bounds[0] + cut.bounds[1]);
        let cuts: Rc<[Cut]> = cuts.into();
        self.n_cuts += cuts.len();
        if self.n_cuts < MOST_CUTS {
            self.cuts.insert(key, (upper, cuts.clone()));
        }
        Some(cuts)
    }

    fn cuts_within(&mut self, node: &Node, depth: usize, upper: i64) -> Option<Vec<Cut>> {
        if depth == 1 {
            let target = upper - self.penalty;
            let found = (0..self.samples.p).flat_map(|f| last_cuts(self.samples, &node.view, f, target));
            let cut = |(feature, position, bounds)| Cut { feature, position, bounds };
            return Some(found.map(cut).collect());
        }
        let search = &mut self.few.search;
        search.forget();
        let whole = search.shallower_bound(&node.view, depth, upper);
        search.forget();
        let found = search.cuts_within(&node.view, depth, upper, whole, 0..self.samples.p)?;
        let cut = found.into_iter().map(|cut| Cut { feature: cut.feature, position: cut.position, bounds: cut.bounds });
        Some(cut.collect())
    }

    /// The samples on both sides of a cut.
    pub(super) fn split(&mut self, node: &Node, cut: &Cut) -> [View; 2] {
        let mut views = [View::default(), View::default()];
        node.view.split(self.samples, cut.feature, cut.position, &mut self.marks, &mut views);
        views
    }

    /// First and last place of a cut: the ranks that may be the largest of its left side.
    pub(super) fn ends(&self, node: &Node, cut: &Cut) -> [u32; 2] {
        let (ranks, list) = (self.samples.ranks_of(cut.feature), node.view.list(cut.feature));
        let rank = |position: usize| ranks[list[position] as usize];
        [rank(cut.position - 1), rank(cut.position) - 1]
    }

    /// The places of a cut that need a look, beside decided leaves.
    fn places(&self, node: &Node, cut: &Cut, fixed: &[Fixed]) -> Vec<u32> {
        let [first, last] = self.ends(node, cut);
        let mut places = ends_of(fixed, cut.feature);
        places.retain(|place| (first..=last).contains(place));
        places.push(first);
        places.sort_unstable();
        places.dedup();
        places
    }

    /// Whether a tree in a node's box is in order within itself and with the decided leaves.
    pub(super) fn keeps_order(&self, node: &Node, tree: &Tree, fixed: &[Fixed]) -> bool {
        let mut leaves = Vec::new();
        self.leaves(tree, 0, node.bounds.clone(), &mut leaves);
        let is_allowed = |leaf: &Fixed, others: &[Fixed]| {
            let [low, high] = labels(&leaf.bounds, others, &self.directions, self.n_labels);
            (low..=high).contains(&leaf.label)
        };
        (0..leaves.len()).all(|k| is_allowed(&leaves[k], fixed) && is_allowed(&leaves[k], &leaves[..k]))
    }

    fn leaves(&self, tree: &Tree, row: usize, bounds: Bounds, found: &mut Vec<Fixed>) {
        match &tree.nodes[row] {
            Row::Leaf { label } => found.push(Fixed { bounds, label: *label }),
            Row::Split { feature, cut, left, right } => {
                let f = self.samples.features.iter().position(|usable| usable == feature).unwrap_or(0);
                self.leaves(tree, *left as usize, side(&bounds, f, *cut, 0), found);
                self.leaves(tree, *right as usize, side(&bounds, f, *cut, 1), found);
            }
            Row::Hyperplane { .. } => {} // the exact core makes none
        }
    }

    fn count(&mut self) {
        self.n_solved += 1;
        if self.n_solved.is_multiple_of(64) {
            self.few.control.add(64);
        }
    }
}

/// Where boxes of decided leaves begin and end along a feature, as places of cuts.
pub(super) fn ends_of(fixed: &[Fixed], feature: usize) -> Vec<u32> {
    let ends = fixed.iter().map(|leaf| leaf.bounds[feature]);
    ends.flat_map(|[low, high]| [low.checked_sub(1), Some(high)]).flatten().collect()
}

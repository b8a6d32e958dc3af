//! Local search over whole trees: the best cut of one node after the other, labels, and perturbations of the best tree.
//!
//! No proof comes of it. One seed gives one tree unless time runs out.

use fastrand::Rng;

use crate::control::{KeepGoing, Limits, Progress, Stop};
use crate::problem::Problem;
use crate::supervise::Supervision;
use crate::tree::Tree;
use crate::worst_case::draft::{Cost, Draft, Spot};
use crate::worst_case::instance::{Bands, Instance};
use crate::worst_case::step::best_cut;

/// Pairs of labels that a split of two leaves is tried with.
const MOST_PAIRS: usize = 20;

/// The best tree that changes of single nodes lead to from some starts, its cost, and why the search ended.
pub fn search(
    problem: &Problem,
    bands: &Bands,
    starts: &[Tree],
    n_rounds: usize,
    seed: u64,
    limits: Limits,
    keep_going: KeepGoing<'_>,
) -> (Tree, i64, Stop) {
    let instance = Instance::new(problem, bands);
    let supervision = Supervision::new(limits);
    let state = Progress { seconds: 0.0, objective: i64::MAX, bound: 0, n_nodes: 0 };
    let (cost, draft) = supervision.run(
        || {
            LocalSearch { instance: &instance, supervision: &supervision, rng: Rng::with_seed(seed) }
                .run(starts, n_rounds)
        },
        || supervision.poll(&mut *keep_going, state),
    );
    let stop = match supervision.reason() {
        None | Some(Stop::Time) => Stop::Finished,
        Some(reason) => reason,
    };
    (draft.to_tree(&instance), cost.0, stop)
}

struct LocalSearch<'a> {
    instance: &'a Instance,
    supervision: &'a Supervision,
    rng: Rng,
}

impl LocalSearch<'_> {
    fn run(&mut self, starts: &[Tree], n_rounds: usize) -> (Cost, Draft) {
        let (cost, label) = self.instance.best_leaf();
        let mut best = ((cost, cost), Draft::leaf(self.instance, label));
        let drafts: Vec<Draft> = starts.iter().filter_map(|tree| Draft::of(self.instance, tree)).collect();
        for draft in drafts.into_iter().chain([best.1.clone()]) {
            if let Some(cost) = draft.cost(self.instance) {
                best = best.min_by_cost(self.descend((cost, draft)));
            }
        }
        for _ in 0..n_rounds {
            if self.supervision.is_stopped() {
                break;
            }
            let mut draft = best.1.clone();
            for _ in 0..1 + self.rng.usize(..2) {
                self.perturb(&mut draft);
            }
            if let Some(cost) = draft.cost(self.instance) {
                let found = self.descend((cost, draft));
                best = best.min_by_cost(found);
            }
        }
        best
    }

    /// Change one place at a time while that makes the tree better.
    fn descend(&mut self, mut now: (Cost, Draft)) -> (Cost, Draft) {
        loop {
            let before = now.0;
            let mut places: Vec<usize> = (0..now.1.spots.len()).filter(|&k| now.1.spots[k] != Spot::Empty).collect();
            self.rng.shuffle(&mut places);
            for place in places {
                if self.supervision.is_stopped() {
                    return now;
                }
                for changed in self.neighbours(&now.1, place) {
                    now = now.min_by_cost(changed);
                }
            }
            if now.0 == before {
                return now;
            }
        }
    }

    /// Trees that differ from a draft at one place: another cut, a leaf instead, a split instead of a leaf.
    fn neighbours(&mut self, draft: &Draft, place: usize) -> Vec<(Cost, Draft)> {
        let mut found = Vec::new();
        let has_room = 2 * place + 2 < draft.spots.len();
        let is_above_leaves = |side: usize| draft.spots.get(side).is_some_and(|spot| matches!(spot, Spot::Leaf(_)));
        match draft.spots[place] {
            Spot::Empty => {}
            Spot::Split(..) => {
                found.extend(best_cut(self.instance, draft, place));
                found.extend(self.leaves(draft, place));
                if is_above_leaves(2 * place + 1) && is_above_leaves(2 * place + 2) {
                    found.extend(self.stumps(draft, place));
                }
            }
            Spot::Leaf(_) => {
                found.extend(self.leaves(draft, place));
                if has_room {
                    found.extend(self.stumps(draft, place));
                }
            }
        }
        found
    }

    fn leaves(&self, draft: &Draft, place: usize) -> Vec<(Cost, Draft)> {
        let leaf = |label: usize| {
            let mut changed = draft.clone();
            changed.clear_below(place);
            changed.spots[place] = Spot::Leaf(label);
            changed.cost(self.instance).map(|cost| (cost, changed))
        };
        (0..self.instance.n_labels).filter_map(leaf).collect()
    }

    /// A split of two leaves at a place, for several pairs of labels.
    fn stumps(&mut self, draft: &Draft, place: usize) -> Vec<(Cost, Draft)> {
        let n = self.instance.n_labels;
        let mut pairs: Vec<(usize, usize)> = (0..n * n).map(|k| (k / n, k % n)).filter(|(a, b)| a != b).collect();
        self.rng.shuffle(&mut pairs);
        let with = |&(a, b): &(usize, usize)| {
            let mut changed = draft.clone();
            changed.clear_below(place);
            changed.spots[place] = Spot::Split(0, 0);
            (changed.spots[2 * place + 1], changed.spots[2 * place + 2]) = (Spot::Leaf(a), Spot::Leaf(b));
            if self.supervision.is_stopped() || self.instance.features.is_empty() {
                return None;
            }
            best_cut(self.instance, &changed, place)
        };
        pairs.iter().take(MOST_PAIRS).filter_map(with).collect()
    }

    /// Put a random cut at a random split, or a random split in place of a random leaf.
    fn perturb(&mut self, draft: &mut Draft) {
        let instance = self.instance;
        let places: Vec<usize> = (0..draft.spots.len() / 2).filter(|&k| draft.spots[k] != Spot::Empty).collect();
        if places.is_empty() || instance.features.is_empty() {
            return;
        }
        let place = places[self.rng.usize(..places.len())];
        let f = self.rng.usize(..instance.features.len());
        let feature = &instance.features[f];
        let cut = feature.ranks[crate::worst_case::instance::TRUE][self.rng.usize(..instance.n)]
            .min(feature.n_ranks as u32 - 2);
        if matches!(draft.spots[place], Spot::Leaf(_)) {
            for side in [2 * place + 1, 2 * place + 2] {
                draft.spots[side] = Spot::Leaf(self.rng.usize(..instance.n_labels));
            }
        }
        draft.spots[place] = Spot::Split(f, cut);
    }
}

trait Better {
    /// The better of two trees, the first among equals.
    fn min_by_cost(self, other: Self) -> Self;
}

impl Better for (Cost, Draft) {
    fn min_by_cost(self, other: Self) -> Self {
        if other.0 < self.0 { other } else { self }
    }
}

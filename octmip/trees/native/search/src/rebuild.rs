//! Subtrees rebuilt below another cut, by looking ahead with exact trees of two levels; restarts from a root cut.

use crate::axis::root_cuts::promising;
use crate::axis::scan::{Aim, best_cut};
use crate::gains::tally::Worth;
use crate::local_search::LocalSearch;
use crate::tree::allowance::{Allowance, paid_features};
use crate::tree::rule::{AxisCut, Rule};
use crate::tree::state::State;

/// Share of rebuilt subtrees whose cut moves along its own feature, and the share of the samples that it passes at
/// most.
const MOVED: f64 = 0.5;
const FURTHEST: f64 = 0.2;
/// The same where the subtree stays.
const SHIFTED_FURTHEST: f64 = 0.05;
/// Share of rebuilt subtrees of another feature that take its purest cut; the others take a random one.
const PUREST: f64 = 0.5;

impl LocalSearch<'_> {
    /// The tree below the `k`-th most promising cut of the root; below a random cut when there are no more.
    pub(crate) fn restart_from_root_cut(&mut self, k: usize, seed: u64) -> Option<State> {
        let problem = self.prepared.problem;
        if problem.depth < 2 {
            return None;
        }
        let (prepared, samples, control) = (self.prepared, self.samples, &self.watch.control);
        let root_cuts = prepared.root_cuts.get_or_init(|| promising(prepared, samples, control, seed));
        let cut = match root_cuts.get(k) {
            Some(&cut) => cut,
            None => {
                let feature = root_cuts.get(self.rng.usize(..root_cuts.len().max(1)))?.feature;
                let sample = self.rng.usize(..problem.n);
                AxisCut { feature, cut: problem.feature(feature as usize)[sample] }
            }
        };
        let mut state = State::leaf(problem);
        self.cut_and_look_ahead(&mut state, 0, cut, self.deepest).then_some(state)
    }

    /// Rebuild one of the subtrees of three levels or more below another cut.
    pub(crate) fn rebuild_at(&mut self, state: &mut State) {
        if let Some(v) = self.deep_split(state)
            && let Some(cut) = self.other_cut(state, v)
        {
            state.collapse(v);
            self.cut_and_look_ahead(state, v, cut, 2);
        }
    }

    /// Move the cut of one of the subtrees of three levels or more along its feature; what hangs below stays.
    pub(crate) fn shift_at(&mut self, state: &mut State) {
        let problem = self.prepared.problem;
        let Some(v) = self.deep_split(state) else {
            return;
        };
        let Some(AxisCut { feature, cut }) = self.moved_cut(state, v, SHIFTED_FURTHEST) else {
            return;
        };
        let rule = Rule::Axis { feature, cut };
        self.view.look(problem, &self.prepared.prices, state, v);
        self.view.fill(&mut self.tally, |j| rule.goes_left(problem, self.view.samples[j]));
        if self.tally.is_large_enough() {
            self.view.apply(problem, state, rule);
        }
    }

    /// A split that two levels at least may hang below.
    fn deep_split(&mut self, state: &State) -> Option<u32> {
        let depth = self.prepared.problem.depth;
        let is_deep = |&v: &u32| !state.is_leaf(v) && state.path(v).is_some_and(|path| path.len() + 2 <= depth);
        let nodes: Vec<u32> = state.below(0).into_iter().filter(is_deep).collect();
        (!nodes.is_empty()).then(|| nodes[self.rng.usize(..nodes.len())])
    }

    /// Split leaf `v` and look ahead below; whether both sides are large enough.
    fn cut_and_look_ahead(&mut self, state: &mut State, v: u32, cut: AxisCut, deepest: usize) -> bool {
        let problem = self.prepared.problem;
        let rule = Rule::Axis { feature: cut.feature, cut: cut.cut };
        let samples = &state.nodes[v as usize].samples;
        let n_left = samples.iter().filter(|&&i| rule.goes_left(problem, i)).count();
        if n_left.min(samples.len() - n_left) < problem.leaf_size {
            return false;
        }
        let level = state.path(v).map_or(0, |path| path.len() - 1);
        let mask = paid_features(problem, state);
        for child in state.split(problem, v, rule) {
            self.blocks.look_ahead(state, child, problem.depth - level - 1, deepest, mask.as_deref());
        }
        true
    }

    /// A cut near the present one, or one of another feature.
    fn other_cut(&mut self, state: &State, v: u32) -> Option<AxisCut> {
        let problem = self.prepared.problem;
        if self.rng.f64() < MOVED {
            return self.moved_cut(state, v, FURTHEST);
        }
        let features = Allowance::at(problem, state, v).axis_features();
        let feature = features[self.rng.usize(..features.len())];
        if self.rng.f64() < PUREST {
            return self.purest_cut(state, v, feature);
        }
        let samples = state.samples(v);
        let sample = samples[self.rng.usize(..samples.len())];
        Some(AxisCut { feature, cut: problem.feature(feature as usize)[sample as usize] })
    }

    /// A cut of the same feature, few samples away more often than many, `furthest` of them (a share) at most.
    fn moved_cut(&mut self, state: &State, v: u32, furthest: f64) -> Option<AxisCut> {
        let Rule::Axis { feature, cut } = state.nodes[v as usize].rule else {
            return None;
        };
        let ranks = self.prepared.problem.feature(feature as usize);
        let mut samples = state.samples(v);
        samples.sort_unstable_by_key(|&i| (ranks[i as usize], i));
        let here = samples.partition_point(|&i| ranks[i as usize] <= cut);
        let first = samples.partition_point(|&i| ranks[i as usize] < cut);
        let step = ((furthest * samples.len() as f64).max(1.0)).powf(self.rng.f64()) as usize;
        let position = if self.rng.bool() { here + step - 1 } else { first.checked_sub(step)? };
        let sample = *samples.get(position)?;
        Some(AxisCut { feature, cut: ranks[sample as usize] })
    }

    /// The cut of a feature that leaves the purest sides, the subtree at `v` taken as a leaf.
    fn purest_cut(&mut self, state: &State, v: u32, feature: u32) -> Option<AxisCut> {
        let mut leaf = state.clone();
        leaf.collapse(v);
        let (problem, orders) = (self.prepared.problem, &self.prepared.orders);
        self.view.look(problem, &self.prepared.prices, &leaf, v);
        let floor = Worth { gain: i64::MIN / 2, purity: 0.0 };
        let scratch = (&mut self.tally, &mut self.node_order);
        match best_cut(problem, orders, &self.view, &[feature], (Aim::Purity, floor), scratch, &|| true)?.0 {
            Rule::Axis { feature, cut } => Some(AxisCut { feature, cut }),
            _ => None,
        }
    }
}

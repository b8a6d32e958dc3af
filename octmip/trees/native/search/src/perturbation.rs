//! Perturbations: change a tree at random, descend where it was changed, keep the result where it is not worse.

use crate::greedy::BuildOptions;
use crate::local_search::LocalSearch;
use crate::soft_tree::refinement::refine_soft_tree;
use crate::soft_tree::schedule::{Reselection, Schedule};
use crate::tree::allowance::{Allowance, features_of, redrawn_sensors};
use crate::tree::rule::Rule;
use crate::tree::state::State;

/// A tree is near the best one when it costs this fraction more at most.
const NEAR_BEST: i64 = 50;
/// Share of the features that a subtree built again may look at in one node.
const RANDOM_SHARE: f64 = 0.4;
/// Share of the perturbations of a hyperplane tree that build a subtree again, and that refine one as a soft tree; the
/// others perturb one plane.
const BUILT_AGAIN: f64 = 0.2;
const SOFTENED: f64 = 0.05;
/// Share of the perturbations of an axis-aligned tree that shift a cut, and of the others that rebuild a subtree below
/// another cut.
const SHIFTED: f64 = 0.25;
const REBUILT: f64 = 0.6;
/// Gradient steps of a soft-tree refinement as a perturbation, and the range of its first inverse temperature.
const SOFT_TREE_STEPS: usize = 150;
const FIRST_INVERSE_TEMPERATURES: [f64; 2] = [3.0, 30.0];

impl LocalSearch<'_> {
    /// Perturb until `n_perturbations` perturbations in a row have not helped; returns the objective.
    pub(crate) fn perturb_until_no_improvement(&mut self, state: &mut State, n_perturbations: usize) -> i64 {
        let mut objective = state.objective(&self.prepared.prices);
        let mut n_without_improvement = 0;
        while n_without_improvement < n_perturbations && !self.is_best(state, objective) && self.goes_on() {
            let mut trial = state.clone();
            if self.has_planes {
                self.perturb_planes(&mut trial);
            } else {
                self.perturb_cuts(&mut trial, objective);
            }
            let found = trial.objective(&self.prepared.prices);
            n_without_improvement = if found < objective { 0 } else { n_without_improvement + 1 };
            self.report(found);
            if found <= objective {
                objective = found;
                *state = trial;
            }
        }
        objective
    }

    /// Perturb an axis-aligned tree and descend; near the best objective, settle.
    fn perturb_cuts(&mut self, state: &mut State, objective: i64) {
        if self.prepared.problem.sensor_limit.is_finite() && self.rng.bool() {
            self.change_sensors(state);
        } else {
            self.perturb_node(state);
        }
        state.compact();
        self.settle(state, 2);
        let settled = state.objective(&self.prepared.prices);
        // Deep blocks are expensive: they are tried as often as they have helped.
        let [helped, tried] = self.deep_tries;
        let chance = (3.0 + f64::from(helped)) / (3.0 + f64::from(tried));
        if settled <= objective + objective / NEAR_BEST + 1 && self.rng.f64() < chance {
            self.settle(state, self.deepest);
            let has_helped = state.objective(&self.prepared.prices) < settled;
            self.deep_tries = [helped + u32::from(has_helped), tried + 1];
        }
    }

    /// Give one node another cut, with its children as they are or rebuilt, or build its subtree again.
    fn perturb_node(&mut self, state: &mut State) {
        let nodes = state.below(0);
        let v = nodes[self.rng.usize(..nodes.len())];
        if self.prepared.problem.depth > 2 && self.rng.f64() < SHIFTED {
            return self.shift_at(state);
        }
        if self.prepared.problem.depth > 2 && self.rng.f64() < REBUILT {
            return self.rebuild_at(state);
        }
        if state.is_leaf(v) || self.rng.bool() {
            let options = BuildOptions { share: RANDOM_SHARE, has_planes: false };
            self.build_again(state, v, options);
        } else {
            self.cut_at_random(state, v);
        }
    }

    fn build_again(&mut self, state: &mut State, v: u32, options: BuildOptions) {
        let level = state.path(v).map_or(0, |path| path.len() - 1);
        state.collapse(v);
        self.build(state, v, self.prepared.problem.depth - level, options);
    }

    /// Build the tree again from other sensors within the budget.
    fn change_sensors(&mut self, state: &mut State) {
        let problem = self.prepared.problem;
        let sensors = redrawn_sensors(problem, state, &mut self.rng);
        let mask = features_of(problem, &sensors);
        *state = self.look_ahead(2, Some(&mask));
    }

    /// Give `v` a random cut, where leaves stay large enough.
    fn cut_at_random(&mut self, state: &mut State, v: u32) {
        let problem = self.prepared.problem;
        let features = Allowance::at(problem, state, v).axis_features();
        self.view.look(problem, &self.prepared.prices, state, v);
        if features.is_empty() || self.view.samples.is_empty() {
            return;
        }
        let feature = features[self.rng.usize(..features.len())];
        let sample = self.view.samples[self.rng.usize(..self.view.samples.len())];
        let rule = Rule::Axis { feature, cut: problem.feature(feature as usize)[sample as usize] };
        self.view.fill(&mut self.tally, |j| rule.goes_left(problem, self.view.samples[j]));
        if self.tally.is_large_enough() {
            self.view.apply(problem, state, rule);
        }
    }

    /// Perturb one node of a hyperplane tree; visit what lies below it, the node itself, then what lies above it.
    fn perturb_planes(&mut self, state: &mut State) {
        let splits: Vec<u32> = state.below(0).into_iter().filter(|&v| !state.is_leaf(v)).collect();
        let v = if splits.is_empty() { 0 } else { splits[self.rng.usize(..splits.len())] };
        let chance = self.rng.f64();
        if state.is_leaf(v) || chance < BUILT_AGAIN {
            let options = BuildOptions {
                share: 0.2 + 0.8 * self.rng.f64(),
                has_planes: self.prepared.has_real_planes() && self.rng.bool(),
            };
            self.build_again(state, v, options);
        } else if chance < BUILT_AGAIN + SOFTENED {
            self.refine_below(state, v);
        } else {
            self.perturb_plane(state, v);
        }
        let mut around = state.below(v);
        around.remove(0);
        self.rng.shuffle(&mut around);
        around.extend(state.path(v).unwrap_or_default().into_iter().rev());
        self.visit_each(state, &around);
        state.compact();
    }

    fn perturb_plane(&mut self, state: &mut State, v: u32) {
        self.view.look(self.prepared.problem, &self.prepared.prices, state, v);
        let is_perturbed = self.plane.load(&self.view, &state.nodes[v as usize].rule)
            && self.plane.perturb(&self.view, &mut self.rng)
            && self.plane.round(&self.view, &mut self.rng);
        if is_perturbed && let Some(rule) = self.plane.rule(&self.view) {
            self.view.apply(self.prepared.problem, state, rule);
        }
    }

    /// Refine the subtree at `v` as a soft tree, more or less soft, half of the time with its own plane's features
    /// chosen again.
    fn refine_below(&mut self, state: &mut State, v: u32) {
        let [low, high] = FIRST_INVERSE_TEMPERATURES;
        let first_inverse_temperature = (low * (high / low).powf(self.rng.f64())) as f32;
        let reselection = if self.rng.bool() { Reselection::One(v) } else { Reselection::None };
        self.refine_soft_tree(state, v, Schedule { n_steps: SOFT_TREE_STEPS, first_inverse_temperature, reselection });
    }

    /// Refine the subtree at `v` as a soft tree where the result keeps the limits of the problem.
    pub(crate) fn refine_soft_tree(&mut self, state: &mut State, v: u32, schedule: Schedule) {
        if !self.prepared.has_real_planes() {
            return;
        }
        let mut trial = state.clone();
        if refine_soft_tree((self.prepared, self.plane.supervisor), &mut trial, v, schedule, &mut self.rng) {
            *state = trial;
        }
    }
}

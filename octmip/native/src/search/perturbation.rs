//! Kicks: disturb a tree, descend where it was disturbed, keep what is not worse.

use crate::search::greedy::Soil;
use crate::search::local_search::Climber;
use crate::search::soft_tree::refinement::melt;
use crate::search::soft_tree::schedule::{Heat, Opening};
use crate::search::tree::allowance::{Room, features_of, shuffled_sensors};
use crate::search::tree::rule::Rule;
use crate::search::tree::state::State;

/// A tree is near the best one when it costs this fraction more at most.
const NEAR: i64 = 50;
/// Share of the features that a subtree grown anew may look at in one node.
const RANDOM_SHARE: f64 = 0.4;
/// Share of the kicks to a hyperplane tree that grow a subtree anew, and that melt one; the others shake one plane.
const GROWN_ANEW: f64 = 0.2;
const MELTED: f64 = 0.05;
/// Share of the kicks to an axis-aligned tree that shift a cut, and of the others that plant a subtree below another cut.
const SHIFTED: f64 = 0.25;
const PLANTED: f64 = 0.6;
/// Gradient steps of a kick, and the range of its first sharpness.
const MELT_STEPS: usize = 150;
const MELT_SHARPNESS: [f64; 2] = [3.0, 30.0];

impl Climber<'_> {
    /// Kick until `n_kicks` kicks in a row have not helped; returns the objective.
    pub(crate) fn kick_until_stale(&mut self, state: &mut State, n_kicks: usize) -> i64 {
        let mut objective = state.objective(&self.ground.prices);
        let mut stale = 0;
        while stale < n_kicks && !self.is_best(state, objective) && self.goes_on() {
            let mut trial = state.clone();
            if self.has_planes {
                self.kick_planes(&mut trial);
            } else {
                self.kick_cuts(&mut trial, objective);
            }
            let reached = trial.objective(&self.ground.prices);
            stale = if reached < objective { 0 } else { stale + 1 };
            self.report(reached);
            if reached <= objective {
                objective = reached;
                *state = trial;
            }
        }
        objective
    }

    /// Disturb an axis-aligned tree and descend; near the best objective, settle.
    fn kick_cuts(&mut self, state: &mut State, objective: i64) {
        if self.ground.problem.sensor_limit.is_finite() && self.rng.bool() {
            self.change_sensors(state);
        } else {
            self.disturb_cuts(state);
        }
        state.compact();
        self.settle(state, 2);
        let reached = state.objective(&self.ground.prices);
        // Deep blocks are dear: they are tried as often as they have helped.
        let [helped, tried] = self.deep_luck;
        let chance = (3.0 + f64::from(helped)) / (3.0 + f64::from(tried));
        if reached <= objective + objective / NEAR + 1 && self.rng.f64() < chance {
            self.settle(state, self.deepest);
            let has_helped = state.objective(&self.ground.prices) < reached;
            self.deep_luck = [helped + u32::from(has_helped), tried + 1];
        }
    }

    /// Give one node another cut, with its children as they are or planted anew, or grow its subtree anew.
    fn disturb_cuts(&mut self, state: &mut State) {
        let nodes = state.below(0);
        let v = nodes[self.rng.usize(..nodes.len())];
        if self.ground.problem.depth > 2 && self.rng.f64() < SHIFTED {
            return self.shift_at(state);
        }
        if self.ground.problem.depth > 2 && self.rng.f64() < PLANTED {
            return self.plant_at(state);
        }
        if state.is_leaf(v) || self.rng.bool() {
            let soil = Soil { share: RANDOM_SHARE, has_planes: false };
            self.grow_anew(state, v, soil);
        } else {
            self.cut_at_random(state, v);
        }
    }

    fn grow_anew(&mut self, state: &mut State, v: u32, soil: Soil) {
        let level = state.path(v).map_or(0, |path| path.len() - 1);
        state.collapse(v);
        self.grow(state, v, self.ground.problem.depth - level, soil);
    }

    /// Grow the tree anew from other sensors within the budget.
    fn change_sensors(&mut self, state: &mut State) {
        let problem = self.ground.problem;
        let sensors = shuffled_sensors(problem, state, &mut self.rng);
        let mask = features_of(problem, &sensors);
        *state = self.look_ahead(2, Some(&mask));
    }

    /// Give `v` a random cut, where leaves stay large enough.
    fn cut_at_random(&mut self, state: &mut State, v: u32) {
        let problem = self.ground.problem;
        let features = Room::at(problem, state, v).axis_features();
        self.view.look(problem, &self.ground.prices, state, v);
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

    /// Disturb one node of a hyperplane tree; visit what lies below it, the node itself, then what lies above it.
    fn kick_planes(&mut self, state: &mut State) {
        let splits: Vec<u32> = state.below(0).into_iter().filter(|&v| !state.is_leaf(v)).collect();
        let v = if splits.is_empty() { 0 } else { splits[self.rng.usize(..splits.len())] };
        let chance = self.rng.f64();
        if state.is_leaf(v) || chance < GROWN_ANEW {
            let soil = Soil {
                share: 0.2 + 0.8 * self.rng.f64(),
                has_planes: self.ground.has_real_planes() && self.rng.bool(),
            };
            self.grow_anew(state, v, soil);
        } else if chance < GROWN_ANEW + MELTED {
            self.melt_below(state, v);
        } else {
            self.jitter(state, v);
        }
        let mut around = state.below(v);
        around.remove(0);
        self.rng.shuffle(&mut around);
        around.extend(state.path(v).unwrap_or_default().into_iter().rev());
        self.visit_each(state, &around);
        state.compact();
    }

    fn jitter(&mut self, state: &mut State, v: u32) {
        self.view.look(self.ground.problem, &self.ground.prices, state, v);
        let is_shaken = self.plane.load(&self.view, &state.nodes[v as usize].rule)
            && self.plane.jitter(&self.view, &mut self.rng)
            && self.plane.round(&self.view, &mut self.rng);
        if is_shaken && let Some(rule) = self.plane.rule(&self.view) {
            self.view.apply(self.ground.problem, state, rule);
        }
    }

    /// Melt the subtree at `v`, more or less, half of the time with its own plane's features chosen anew.
    fn melt_below(&mut self, state: &mut State, v: u32) {
        let [low, high] = MELT_SHARPNESS;
        let first_sharpness = (low * (high / low).powf(self.rng.f64())) as f32;
        let opening = if self.rng.bool() { Opening::One(v) } else { Opening::None };
        self.melt(state, v, Heat { n_steps: MELT_STEPS, first_sharpness, opening });
    }

    /// Melt the subtree at `v` where what comes out keeps the limits of the problem.
    pub(crate) fn melt(&mut self, state: &mut State, v: u32, heat: Heat) {
        if !self.ground.has_real_planes() {
            return;
        }
        let mut trial = state.clone();
        if melt((self.ground, self.plane.supervisor), &mut trial, v, heat, &mut self.rng) {
            *state = trial;
        }
    }
}

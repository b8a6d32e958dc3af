//! One restart: descend by visits to single nodes, then kick, descend where the kick was, keep what is not worse.

use crate::problem::Problem;
use crate::search::axis::{Aim, best_cut};
use crate::search::orders::{NodeOrder, Orders};
use crate::search::sensors::open_features;
use crate::search::state::{Rule, State};
use crate::search::tally::{Prices, Tally, Worth};
use crate::search::view::View;

/// What all restarts share.
#[derive(Debug)]
pub struct Ground<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Its gains.
    pub prices: Prices,
    /// Its samples in every feature's order.
    pub orders: Orders,
}

impl<'a> Ground<'a> {
    /// Prepare a problem.
    pub fn new(problem: &'a Problem) -> Self {
        Self {
            problem,
            prices: Prices::new(problem),
            orders: Orders::new(problem),
        }
    }
}

/// A restart at work.
pub struct Climber<'a> {
    ground: &'a Ground<'a>,
    rng: fastrand::Rng,
    view: View,
    tally: Tally<'a>,
    node_order: NodeOrder,
    keep_going: &'a dyn Fn() -> bool,
    /// Nodes visited.
    pub n_visits: u64,
}

/// Share of the features that a randomised tree may look at in one node.
const RANDOM_SHARE: f64 = 0.4;

impl<'a> Climber<'a> {
    /// A restart with its own random stream.
    pub fn new(ground: &'a Ground<'a>, seed: u64, keep_going: &'a dyn Fn() -> bool) -> Self {
        Self {
            ground,
            rng: fastrand::Rng::with_seed(seed),
            view: View::default(),
            tally: Tally::new(&ground.prices),
            node_order: NodeOrder::default(),
            keep_going,
            n_visits: 0,
        }
    }

    /// Grow leaf `v` into a CART-like tree of at most `levels` levels, each node looking at a share of the features.
    pub fn grow(&mut self, state: &mut State, v: u32, levels: usize, share: f64) {
        let mut stack = vec![(v, levels)];
        while let Some((v, levels)) = stack.pop() {
            if levels == 0 || !(self.keep_going)() {
                continue;
            }
            let features = self.some(open_features(self.ground.problem, state, v), share);
            self.view.look(self.ground.problem, state, v);
            let present = self.view.present(&mut self.tally, 0);
            if let Some((rule, _)) = self.best_cut(&features, Aim::Purity, present) {
                let [left, right] = state.split(self.ground.problem, v, rule);
                stack.extend([(right, levels - 1), (left, levels - 1)]);
            }
        }
    }

    fn some(&mut self, mut features: Vec<u32>, share: f64) -> Vec<u32> {
        if share < 1.0 && !features.is_empty() {
            self.rng.shuffle(&mut features);
            features.truncate(((features.len() as f64 * share).ceil() as usize).max(1));
        }
        features
    }

    fn best_cut(&mut self, features: &[u32], aim: Aim, floor: Worth) -> Option<(Rule, Worth)> {
        let scratch = (&mut self.tally, &mut self.node_order);
        best_cut(
            self.ground.problem,
            &self.ground.orders,
            &self.view,
            features,
            aim,
            floor,
            scratch,
        )
    }

    /// Visit all nodes in random order, again and again, until no visit helps.
    pub fn descend(&mut self, state: &mut State) {
        loop {
            let mut order = state.below(0);
            self.rng.shuffle(&mut order);
            if !self.visit_each(state, &order) {
                return;
            }
            state.compact();
        }
    }

    /// Visit these nodes as far as they are still in the tree; whether any visit helped.
    fn visit_each(&mut self, state: &mut State, nodes: &[u32]) -> bool {
        let mut helped = false;
        for &v in nodes {
            if !(self.keep_going)() {
                return false;
            }
            if let Some(path) = state.path(v) {
                helped |= self.visit(state, v, path.len() - 1);
            }
        }
        helped
    }

    /// Give node `v`, `level` levels below the root, the best rule there is, or remove it; whether that helped.
    fn visit(&mut self, state: &mut State, v: u32, level: usize) -> bool {
        self.n_visits += 1;
        let is_leaf = state.is_leaf(v);
        if is_leaf && level >= self.ground.problem.depth {
            return false;
        }
        self.view.look(self.ground.problem, state, v);
        if self.remove(state, v) {
            return true;
        }
        let price = self.ground.prices.penalty * state.nodes[v as usize].rule.size() as i64;
        let present = self.view.present(&mut self.tally, price);
        let features = open_features(self.ground.problem, state, v);
        match self.best_cut(&features, Aim::Gain, present) {
            Some((rule, _)) => {
                self.view.apply(self.ground.problem, state, rule);
                true
            }
            None => false,
        }
    }

    /// Replace `v` by a leaf or by one of its children where that is better.
    fn remove(&mut self, state: &mut State, v: u32) -> bool {
        if state.is_leaf(v) {
            return false;
        }
        let penalty = self.ground.prices.penalty;
        let present = self
            .view
            .present(&mut self.tally, penalty * state.complexity(v));
        for side in [0, 1] {
            self.view.fill(&mut self.tally, |_| side == 0);
            let child = state.nodes[v as usize].children[side];
            let gain = self.tally.total - penalty * state.complexity(child);
            let worth = Worth {
                gain,
                purity: self.tally.purity(),
            };
            if self.tally.is_large_enough() && worth.beats(&present) {
                self.view.replace_by_child(state, side);
                return true;
            }
        }
        self.tally.clear(1);
        self.view.samples.iter().for_each(|&i| self.tally.add(0, i));
        let leaf = Worth {
            gain: self.tally.total,
            purity: self.tally.purity(),
        };
        if leaf.beats(&present) {
            state.collapse(v);
        }
        leaf.beats(&present)
    }

    /// Kick, descend, keep what is not worse, until `n_kicks` kicks in a row have not helped; returns the objective.
    pub fn kick_until_stale(&mut self, state: &mut State, n_kicks: usize) -> i64 {
        let mut objective = state.objective(&self.ground.prices);
        let mut stale = 0;
        while stale < n_kicks && objective > 0 && (self.keep_going)() {
            let mut trial = state.clone();
            self.kick(&mut trial);
            self.descend(&mut trial);
            let reached = trial.objective(&self.ground.prices);
            stale = if reached < objective { 0 } else { stale + 1 };
            if reached <= objective {
                objective = reached;
                *state = trial;
            }
        }
        objective
    }

    /// Disturb one node: another cut, or its subtree grown anew from a share of the features.
    fn kick(&mut self, state: &mut State) {
        let nodes = state.below(0);
        let v = nodes[self.rng.usize(..nodes.len())];
        let level = state.path(v).map_or(0, |path| path.len() - 1);
        if state.is_leaf(v) || self.rng.bool() {
            state.collapse(v);
            self.grow(state, v, self.ground.problem.depth - level, RANDOM_SHARE);
        } else {
            self.cut_at_random(state, v);
        }
        state.compact();
    }

    /// Give `v` a random cut, where leaves stay large enough.
    fn cut_at_random(&mut self, state: &mut State, v: u32) {
        let problem = self.ground.problem;
        let features = open_features(problem, state, v);
        self.view.look(problem, state, v);
        if features.is_empty() || self.view.samples.is_empty() {
            return;
        }
        let feature = features[self.rng.usize(..features.len())];
        let sample = self.view.samples[self.rng.usize(..self.view.samples.len())];
        let rule = Rule::Axis {
            feature,
            cut: problem.feature(feature as usize)[sample as usize],
        };
        self.view.fill(&mut self.tally, |j| {
            rule.goes_left(problem, self.view.samples[j])
        });
        if self.tally.is_large_enough() {
            self.view.apply(problem, state, rule);
        }
    }
}

/// A restart's start: a greedy tree, the first one over all features and without chance.
pub fn greedy_start(climber: &mut Climber, ground: &Ground, restart: usize) -> State {
    let mut state = State::leaf(ground.problem);
    let share = if restart == 0 { 1.0 } else { RANDOM_SHARE };
    climber.grow(&mut state, 0, ground.problem.depth, share);
    state
}

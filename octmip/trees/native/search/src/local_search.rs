//! Descent to a local optimum: visits to single nodes with the rest of the tree fixed, exact blocks at the bottom.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use crate::axis::blocks::{Blocks, Mask, fingerprint};
use crate::axis::scan::{Aim, best_cut, leading_features};
use crate::gains::tally::{Tally, Worth};
use crate::greedy::{BuildOptions, GreedyBuilder};
use crate::planes::plane_search::PlaneSearch;
use crate::prepared::Prepared;
use crate::prepared::orders::NodeOrder;
use crate::tree::allowance::{Allowance, paid_features};
use crate::tree::state::State;
use crate::tree::view::NodeView;
use crate::watch::{Supervisor, TRIVIAL_BOUND, Watch};
use octmip_exact::Samples;

/// The local search of one restart.
pub(crate) struct LocalSearch<'a> {
    pub(crate) prepared: &'a Prepared<'a>,
    pub(crate) rng: fastrand::Rng,
    builder: GreedyBuilder<'a>,
    pub(crate) view: NodeView,
    pub(crate) tally: Tally<'a>,
    pub(crate) node_order: NodeOrder,
    pub(crate) plane: PlaneSearch<'a>,
    pub(crate) blocks: Blocks<'a>,
    pub(crate) samples: &'a Samples,
    pub(crate) watch: &'a Watch,
    /// Levels of the deepest exact block.
    pub(crate) deepest: usize,
    /// Number of perturbations after which deep blocks have helped, and after which they were tried.
    pub(crate) deep_tries: [u32; 2],
    /// Whether splits may be hyperplanes; otherwise every move is axis-aligned.
    pub(crate) has_planes: bool,
    /// Nodes visited since the last report.
    n_visits: u64,
    /// Visits by axis-aligned moves that have not helped.
    vain: HashSet<u64>,
}

/// One visit in so many offers a hyperplane's place to an axis-aligned cut.
const CUT_ONE_IN: u32 = 8;

impl<'a> LocalSearch<'a> {
    /// The local search of a restart, with a random stream of its own.
    pub(crate) fn new(prepared: &'a Prepared<'a>, samples: &'a Samples, watch: &'a Watch, stream: u64) -> Self {
        Self {
            prepared,
            rng: fastrand::Rng::with_seed(stream),
            builder: GreedyBuilder::new(prepared),
            view: NodeView::default(),
            tally: Tally::new(&prepared.prices),
            node_order: NodeOrder::default(),
            plane: PlaneSearch::new(prepared, Supervisor { watch, place: 0 }),
            blocks: Blocks::new(prepared, samples, &watch.control),
            samples,
            watch,
            deepest: 2,
            deep_tries: [0, 0],
            has_planes: prepared.has_planes(),
            n_visits: 0,
            vain: HashSet::new(),
        }
    }

    /// Whether to go on.
    pub(crate) fn goes_on(&self) -> bool {
        self.plane.supervisor.goes_on()
    }

    /// Take a place in the next round.
    pub(crate) fn take_place(&mut self, place: usize) {
        self.plane.supervisor = Supervisor { watch: self.watch, place };
    }

    /// Whether nothing can cost less.
    pub(crate) fn is_best(&self, state: &State, objective: i64) -> bool {
        objective == TRIVIAL_BOUND || (!self.prepared.has_planes() && self.blocks.has_proven(state, objective))
    }

    /// Report that a tree of this objective is known.
    pub(crate) fn report(&mut self, objective: i64) {
        self.watch.found(objective, std::mem::take(&mut self.n_visits));
    }

    /// Build a greedy subtree in the place of leaf `v`.
    pub(crate) fn build(&mut self, state: &mut State, v: u32, levels: usize, options: BuildOptions) {
        let supervisor = self.plane.supervisor;
        self.builder.build(state, v, levels, options, &mut self.rng, &|| supervisor.goes_on());
    }

    /// Visit all nodes in random order, again and again, until no visit helps.
    pub(crate) fn descend(&mut self, state: &mut State) {
        self.descend_above(state, 0);
    }

    /// The same for the nodes that more than `bottom` levels of splits may hang from.
    fn descend_above(&mut self, state: &mut State, bottom: usize) {
        loop {
            let mut order = state.below(0);
            order.retain(|&v| self.levels_left(state, v) > bottom);
            self.rng.shuffle(&mut order);
            if !self.visit_each(state, &order) {
                return;
            }
            state.compact();
        }
    }

    /// Levels of splits that may hang from `v`, its own included.
    fn levels_left(&self, state: &State, v: u32) -> usize {
        state.path(v).map_or(0, |path| self.prepared.problem.depth + 1 - path.len())
    }

    /// Replace the bottom subtrees of up to `levels` levels by exact ones, and descend, until neither helps.
    ///
    /// No visit gains anything within an exact subtree, so that the nodes of the last two levels are left out, unless
    /// a visit may read sensors that the exact one may not.
    pub(crate) fn settle(&mut self, state: &mut State, levels: usize) {
        let is_exact = self.blocks.deepest(self.prepared.problem.n, 2) == 2;
        let is_free = self.prepared.problem.sensor_limit.is_infinite();
        let bottom = if is_exact && is_free { 2 } else { 0 };
        self.descend_above(state, bottom);
        while self.goes_on() && self.replace_bottom(state, levels) {
            state.compact();
            self.descend_above(state, bottom);
        }
    }

    fn replace_bottom(&mut self, state: &mut State, levels: usize) -> bool {
        let mask = paid_features(self.prepared.problem, state);
        let mut helped = false;
        for v in state.below(0) {
            let left = self.levels_left(state, v);
            if (2..=levels).contains(&left) && self.goes_on() {
                self.n_visits += 1;
                let levels = self.blocks.deepest(state.samples(v).len(), left);
                helped |= self.blocks.replace(state, v, levels, mask.as_deref());
            }
        }
        helped
    }

    /// The tree of exact blocks of up to `deepest` levels, top down.
    pub(crate) fn look_ahead(&mut self, deepest: usize, mask: Mask) -> State {
        let mut state = State::leaf(self.prepared.problem);
        self.blocks.look_ahead(&mut state, 0, self.prepared.problem.depth, deepest, mask);
        state
    }

    /// Visit these nodes as far as they are still in the tree; whether any visit helped.
    pub(crate) fn visit_each(&mut self, state: &mut State, nodes: &[u32]) -> bool {
        let mut helped = false;
        for &v in nodes {
            if !self.goes_on() {
                return false;
            }
            if let Some(path) = state.path(v) {
                helped |= self.visit(state, v, path.len() - 1);
            }
        }
        helped
    }

    /// Improve node `v`, `level` levels below the root; whether that helped.
    fn visit(&mut self, state: &mut State, v: u32, level: usize) -> bool {
        self.n_visits += 1;
        let is_leaf = state.is_leaf(v);
        if is_leaf && level >= self.prepared.problem.depth {
            return false;
        }
        if self.has_planes {
            return self.improve(state, v);
        }
        // Without planes no move at a node draws a random number: the same visit again would help as little.
        let key = self.visit_key(state, v);
        if self.vain.contains(&key) {
            return false;
        }
        let helped = self.improve(state, v);
        if !helped && self.goes_on() {
            self.vain.insert(key);
        }
        helped
    }

    /// A number that distinguishes visits: the samples of the node, the tree below it, the features it may read. Two
    /// visits that share it would cost a move, no more.
    fn visit_key(&self, state: &State, v: u32) -> u64 {
        let mut hasher = DefaultHasher::new();
        for node in state.below(v) {
            state.nodes[node as usize].rule.hash(&mut hasher);
        }
        let samples = state.leaves(v).into_iter().flat_map(|leaf| &state.nodes[leaf as usize].samples);
        fingerprint(samples).hash(&mut hasher);
        if self.prepared.problem.sensor_limit.is_finite() {
            Allowance::at(self.prepared.problem, state, v).axis_features().hash(&mut hasher);
        }
        hasher.finish()
    }

    /// Give node `v` the best rule there is, or remove it; whether that helped.
    fn improve(&mut self, state: &mut State, v: u32) -> bool {
        let is_leaf = state.is_leaf(v);
        self.view.look(self.prepared.problem, &self.prepared.prices, state, v);
        if self.remove(state, v) {
            return true;
        }
        if is_leaf || !self.has_planes || self.rng.u32(..CUT_ONE_IN) == 0 {
            return self.cut(state, v);
        }
        self.improve_plane(state, v)
    }

    /// Give `v` its best axis-aligned cut where that is better.
    fn cut(&mut self, state: &mut State, v: u32) -> bool {
        let price = self.prepared.prices.price(state.nodes[v as usize].rule.size() as i64);
        let present = self.view.present(&mut self.tally, price);
        let features = Allowance::at(self.prepared.problem, state, v).axis_features();
        let (problem, orders) = (self.prepared.problem, &self.prepared.orders);
        let supervisor = self.plane.supervisor;
        let go_on = &|| supervisor.goes_on();
        let scratch = (&mut self.tally, &mut self.node_order);
        let features = leading_features(problem, orders, &self.view, features, scratch, go_on);
        let scratch = (&mut self.tally, &mut self.node_order);
        let found = best_cut(problem, orders, &self.view, &features, (Aim::Gain, present), scratch, go_on);
        let helped = found.is_some();
        if let Some((rule, _)) = found {
            self.view.apply(self.prepared.problem, state, rule);
        }
        helped
    }

    /// Turn and shift the plane of `v`; whether that gained. Equals are taken too, so that plateaus are crossed.
    fn improve_plane(&mut self, state: &mut State, v: u32) -> bool {
        let problem = self.prepared.problem;
        let allowance = Allowance::at(problem, state, v);
        if !self.plane.load(&self.view, &state.nodes[v as usize].rule) {
            return self.cut(state, v);
        }
        let price = self.prepared.prices.price(state.nodes[v as usize].rule.size() as i64);
        let present = self.view.present(&mut self.tally, price);
        loop {
            let before = self.plane.gain();
            self.plane.improve(&self.view, &allowance, &mut self.rng);
            if self.plane.gain() <= before {
                self.plane.try_exact_pairs(&self.view, &allowance, &mut self.rng);
            }
            if self.plane.gain() <= before || !self.goes_on() {
                break;
            }
        }
        if !self.plane.round(&self.view, &mut self.rng) || self.plane.gain() < present.gain {
            return false;
        }
        let Some(rule) = self.plane.rule(&self.view) else {
            return false;
        };
        let gain = self.plane.tally.total - self.prepared.prices.price(rule.size() as i64);
        if gain >= present.gain {
            self.view.apply(problem, state, rule);
        }
        gain > present.gain
    }

    /// Replace `v` by a leaf or by one of its children where that is better.
    fn remove(&mut self, state: &mut State, v: u32) -> bool {
        if state.is_leaf(v) {
            return false;
        }
        let prices = &self.prepared.prices;
        let present = self.view.present(&mut self.tally, prices.price(state.complexity(v)));
        for side in [0, 1] {
            self.view.fill(&mut self.tally, |_| side == 0);
            let child = state.nodes[v as usize].children[side];
            let gain = self.tally.total - prices.price(state.complexity(child));
            let worth = Worth { gain, purity: self.tally.purity() };
            if self.tally.is_large_enough() && worth.beats(&present) {
                self.view.replace_by_child(state, side);
                return true;
            }
        }
        self.tally.clear(1);
        self.view.members.iter().for_each(|member| self.tally.add(0, member.weighed));
        let leaf = Worth { gain: self.tally.total, purity: self.tally.purity() };
        if leaf.beats(&present) {
            state.collapse(v);
        }
        leaf.beats(&present)
    }
}

//! One restart: its beginning, and its turn in each round.

use crate::greedy::BuildOptions;
use crate::local_search::LocalSearch;
use crate::options::Options;
use crate::prepared::Prepared;
use crate::soft_tree::schedule::{Reselection, Schedule};
use crate::tree::state::State;
use crate::turns::{Ask, Turn, TurnTask};
use crate::watch::Watch;
use octmip_check::problem::Problem;
use octmip_exact::Samples;
use octmip_frame::tree::Tree;

/// Share of the features that a randomised start may look at in one node.
const RANDOM_SHARE: f64 = 0.4;
/// The soft-tree refinement of a whole tree at its start.
const WHOLE_TREE: Schedule = Schedule { n_steps: 800, first_inverse_temperature: 2.0, reselection: Reselection::All };
/// Samples x features that an exact block of the first tree may look at.
const FIRST_WORK: f64 = 2e8;
/// Perturbations of the axis-aligned tree that a hyperplane tree must not be worse than, where this share of its
/// objective is below that of the hyperplanes: they would hardly bring it down to them otherwise.
const AXIS_PERTURBATIONS: usize = 10;
const NEAR_AXIS: f64 = 0.75;

/// The effort of one round, the same for all its restarts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Round<'t> {
    /// Perturbations in a row without a better tree that end the turn.
    n_perturbations: usize,
    /// Samples x features that one exact block of three levels and more may look at.
    work: f64,
    /// Levels of the deepest exact block.
    deepest: usize,
    /// The same for the blocks of three and of four levels that the round begins and ends with.
    deep: Option<[f64; 2]>,
    /// A tree that is known.
    known: Option<&'t Tree>,
}

impl<'t> Round<'t> {
    /// The rounds of beginning, of going on, and the last one. Without perturbations the search is to be quick: blocks
    /// of two levels alone.
    ///
    /// An axis-aligned restart is known by its beginning, which exact blocks of three levels bring near its best; one
    /// of hyperplanes has to be perturbed first.
    pub(crate) fn all(options: Options, known: Option<&'t Tree>, problem: &Problem) -> [Self; 3] {
        let n = options.n_perturbations;
        let round = |n_perturbations, work| Self { n_perturbations, work, deepest: 3, deep: None, known };
        // Deeper trees have more blocks.
        let share = 0.5_f64.powi(problem.depth.saturating_sub(4) as i32);
        match (n, problem.planes.is_some()) {
            (0, _) => [Self { deepest: 2, ..round(0, 0.0) }; 3],
            (_, true) => [round(n / 4, 2e7), round(n, 2e7), Self { deepest: 4, ..round(2 * n, 4e7) }],
            (_, false) => {
                [round(0, 5e7), round(n, 5e7), Self { deep: Some([share * 2e9, share * 5e8]), ..round(2 * n, 5e7) }]
            }
        }
    }
}

/// A restart with the best tree that it has found.
pub(crate) struct Restart<'a> {
    /// Its number; its random stream depends on this and the seed alone.
    pub(crate) number: usize,
    /// Its place in the present round.
    pub(crate) place: usize,
    /// The tree.
    pub(crate) state: State,
    /// Its objective.
    pub(crate) objective: i64,
    prepared: &'a Prepared<'a>,
    watch: &'a Watch,
    local_search: LocalSearch<'a>,
    samples: &'a Samples,
    seed: u64,
    has_begun: bool,
    is_best: bool,
    /// What the turn before this round's has left; None where it had not begun.
    before: Option<Turn>,
}

impl<'a> Restart<'a> {
    /// Restart `number`, not begun yet.
    pub(crate) fn new(
        prepared: &'a Prepared<'a>,
        samples: &'a Samples,
        watch: &'a Watch,
        seed: u64,
        number: usize,
    ) -> Self {
        let stream = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number as u64);
        let state = State::leaf(prepared.problem);
        let objective = state.objective(&prepared.prices);
        Self {
            number,
            place: number,
            state,
            objective,
            prepared,
            watch,
            local_search: LocalSearch::new(prepared, samples, watch, stream),
            samples,
            seed,
            has_begun: false,
            is_best: false,
            before: None,
        }
    }

    /// Take up a finished turn: all that the next one begins from.
    pub(crate) fn take_up(&mut self, turn: &Turn) {
        self.local_search = LocalSearch::new(self.prepared, self.samples, self.watch, turn.stream);
        self.local_search.deep_tries = turn.deep_tries;
        self.state = State::from_tree(self.prepared.problem, &turn.tree);
        self.objective = self.state.objective(&self.prepared.prices);
        self.has_begun = true;
        self.is_best = turn.is_best;
        self.local_search.report(self.objective);
        if self.is_best {
            self.watch.is_best(self.place);
        }
    }

    /// What the next turn begins from.
    pub(crate) fn turn(&self) -> Turn {
        Turn {
            number: self.number,
            stream: self.local_search.rng.get_seed(),
            deep_tries: self.local_search.deep_tries,
            is_best: self.is_best,
            tree: self.state.to_tree(&self.prepared.prices),
        }
    }

    /// The key by which restarts are ordered, the best first.
    pub(crate) fn rank(&self) -> (i64, usize) {
        (self.objective, self.number)
    }

    /// Keep what the turn before has left.
    fn keep_turn_before(&mut self) {
        self.before = self.has_begun.then(|| self.turn());
    }

    /// Once a restart before it cannot be beaten, it is as if it had had no turn: it may have been stopped in this one
    /// or not, and with a single thread it never begins.
    pub(crate) fn take_back_if_beaten(&mut self) {
        if !self.watch.is_beaten(self.place) {
            return;
        }
        match self.before.take() {
            Some(turn) => self.take_up(&turn),
            None => {
                let place = self.place;
                *self = Self::new(self.prepared, self.samples, self.watch, self.seed, self.number);
                self.place = place;
            }
        }
    }

    /// Take a turn; nothing once the restarts before it are out of reach, or a limit is. Returns whether it was a whole
    /// one.
    pub(crate) fn run(&mut self, round: &Round) -> bool {
        self.keep_turn_before();
        self.local_search.take_place(self.place);
        if self.is_best || !self.local_search.goes_on() {
            return self.is_best;
        }
        self.local_search.blocks.work = round.work;
        self.local_search.deepest = round.deepest;
        if !self.has_begun {
            self.has_begun = true;
            self.begin(round);
        }
        self.settle_deep(round.deep.iter().map(|works| (3, works[0])));
        self.local_search.perturb_until_no_improvement(&mut self.state, round.n_perturbations);
        if !self.prepared.has_planes() {
            self.local_search.settle(&mut self.state, round.deepest);
        }
        self.settle_deep(round.deep.iter().flat_map(|works| [(3, works[0]), (4, works[1])]));
        self.objective = self.state.objective(&self.prepared.prices);
        self.local_search.report(self.objective);
        let is_whole = self.local_search.goes_on();
        self.is_best = self.local_search.is_best(&self.state, self.objective);
        self.take_up(&self.turn());
        is_whole
    }

    /// Take a turn in another process; where it does not come back, the restart stays as it was.
    pub(crate) fn run_in_other_process(&mut self, round: usize, ask: &Ask) {
        self.keep_turn_before();
        self.local_search.take_place(self.place);
        if self.is_best || !self.local_search.goes_on() {
            return;
        }
        let before = self.before.as_ref();
        let task = TurnTask { round, number: self.number, before, limits: self.watch.left() };
        if let Some(finished) = ask(task, &|| self.watch.waits(self.place)) {
            self.watch.found(i64::MAX, finished.n_visits);
            self.take_up(&finished.turn);
        }
    }

    /// Settle with blocks of so many levels and so much work, one after the other.
    fn settle_deep(&mut self, blocks: impl Iterator<Item = (usize, f64)>) {
        for (levels, work) in blocks {
            let usual = std::mem::replace(&mut self.local_search.blocks.work, work);
            self.local_search.settle(&mut self.state, levels);
            self.local_search.blocks.work = usual;
            self.local_search.report(self.state.objective(&self.prepared.prices));
        }
    }

    fn begin(&mut self, round: &Round) {
        if !self.prepared.has_planes() {
            self.state = self.begin_axis(round.known);
            return;
        }
        let has_floor = self.number == 0 || (self.number == 1 && round.known.is_some());
        self.state = self.begin_planes(has_floor, round.n_perturbations == 0);
        if has_floor {
            self.objective = self.state.objective(&self.prepared.prices);
            // Reported before the axis-aligned trees, which take far longer where samples are many.
            self.local_search.report(self.objective);
            let floor = self.floor(round);
            if floor.objective(&self.prepared.prices) < self.objective {
                self.state = floor;
            }
        }
    }

    /// An axis-aligned tree that a hyperplane tree must not be worse than; perturbed where it is not far above it.
    fn floor(&mut self, round: &Round) -> State {
        self.local_search.has_planes = false;
        let mut floor = self.begin_axis(round.known);
        if NEAR_AXIS * (floor.objective(&self.prepared.prices) as f64) < self.objective as f64 {
            self.local_search.perturb_until_no_improvement(&mut floor, AXIS_PERTURBATIONS.min(round.n_perturbations));
        }
        self.local_search.has_planes = true;
        floor
    }

    /// The known tree, the greedy one, then one for each promising cut of the root, then randomised greedy ones.
    fn begin_axis(&mut self, known: Option<&Tree>) -> State {
        let n_first = 1 + usize::from(known.is_some());
        if let (0, Some(tree)) = (self.number, known) {
            let mut state = State::from_tree(self.prepared.problem, tree);
            self.local_search.settle(&mut state, 2);
            return state;
        }
        let is_greedy = self.number < n_first;
        let is_free = self.prepared.problem.sensor_limit.is_infinite();
        let below_cut = (!is_greedy && is_free)
            .then(|| self.local_search.restart_from_root_cut(self.number - n_first, self.seed))
            .flatten();
        let mut state = below_cut.unwrap_or_else(|| self.greedy_tree(if is_greedy { 1.0 } else { RANDOM_SHARE }));
        self.local_search.settle(&mut state, 2);
        let has_blocks = self.local_search.blocks.deepest(self.prepared.problem.n, 2) == 2;
        if is_greedy && is_free && has_blocks {
            self.look_ahead_from(&mut state);
        }
        self.local_search.report(state.objective(&self.prepared.prices));
        state
    }

    /// Take the tree of exact blocks, of two levels and then of three, where it is better.
    fn look_ahead_from(&mut self, state: &mut State) {
        let deepest = if self.prepared.has_planes() { 2 } else { self.local_search.deepest };
        let work = std::mem::replace(&mut self.local_search.blocks.work, FIRST_WORK);
        for levels in 2..=deepest {
            let mut ahead = self.local_search.look_ahead(levels, None);
            self.local_search.settle(&mut ahead, 2);
            if ahead.objective(&self.prepared.prices) < state.objective(&self.prepared.prices) {
                *state = ahead;
                self.local_search.report(state.objective(&self.prepared.prices));
            }
        }
        self.local_search.blocks.work = work;
    }

    fn greedy_tree(&mut self, share: f64) -> State {
        let problem = self.prepared.problem;
        let mut state = State::leaf(problem);
        let options = BuildOptions { share, has_planes: false };
        self.local_search.build(&mut state, 0, problem.depth, options);
        state
    }

    /// A tree of logistic splits, refined as a soft tree or not. A quick one visits every node once.
    fn begin_planes(&mut self, is_first: bool, is_quick: bool) -> State {
        let (prepared, local_search) = (self.prepared, &mut self.local_search);
        let share = if is_first { 1.0 } else { 0.5 + 0.5 * local_search.rng.f64() };
        let options = BuildOptions { share, has_planes: prepared.has_real_planes() };
        let mut state = State::leaf(prepared.problem);
        local_search.build(&mut state, 0, prepared.problem.depth, options);
        // Planes of two features that are refined together end alike; every other restart is more different without it.
        let is_narrow = prepared.split_size() == 2 && prepared.problem.p > 2;
        if !is_narrow || self.number.is_multiple_of(2) {
            local_search.refine_soft_tree(&mut state, 0, WHOLE_TREE);
        }
        if is_quick {
            let nodes = state.below(0);
            local_search.visit_each(&mut state, &nodes);
            state.compact();
        } else {
            local_search.descend(&mut state);
        }
        state
    }
}

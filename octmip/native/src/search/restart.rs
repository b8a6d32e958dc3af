//! One restart: how it begins, and what it does in each round.

use crate::exact::samples::Samples;
use crate::problem::Problem;
use crate::search::greedy::Soil;
use crate::search::local_search::Climber;
use crate::search::options::Options;
use crate::search::prepared::Ground;
use crate::search::soft_tree::schedule::{Heat, Opening};
use crate::search::tree::state::State;
use crate::search::watch::Watch;
use crate::tree::Tree;

/// Share of the features that a randomised start may look at in one node.
const RANDOM_SHARE: f64 = 0.4;
/// Melting a whole tree from its start.
const WHOLE: Heat = Heat { n_steps: 800, first_sharpness: 2.0, opening: Opening::All };
/// Samples x features that an exact block of the first tree may look at.
const FIRST_WORK: f64 = 2e8;
/// Kicks of the axis-aligned tree that a hyperplane tree must not be worse than, where this share of its objective is
/// below that of the hyperplanes: they would hardly bring it down to them otherwise.
const AXIS_KICKS: usize = 10;
const NEAR: f64 = 0.75;

/// What the restarts of one round do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Round<'t> {
    /// Kicks in a row without a better tree that end the turn.
    n_kicks: usize,
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
    /// Beginning, going on, and the last one. Without kicks the search is to be quick: blocks of two levels alone.
    ///
    /// An axis-aligned restart is known by its beginning, which exact blocks of three levels bring near its best; one
    /// of hyperplanes has to be kicked first.
    pub(crate) fn all(options: Options, known: Option<&'t Tree>, problem: &Problem) -> [Self; 3] {
        let n = options.n_kicks;
        let round = |n_kicks, work| Self { n_kicks, work, deepest: 3, deep: None, known };
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
    /// What it costs.
    pub(crate) objective: i64,
    ground: &'a Ground<'a>,
    watch: &'a Watch,
    climber: Climber<'a>,
    seed: u64,
    has_begun: bool,
}

impl<'a> Restart<'a> {
    /// Restart `number`, not begun yet.
    pub(crate) fn new(
        ground: &'a Ground<'a>,
        samples: &'a Samples,
        watch: &'a Watch,
        seed: u64,
        number: usize,
    ) -> Self {
        let stream = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number as u64);
        let state = State::leaf(ground.problem);
        let objective = state.objective(&ground.prices);
        Self {
            number,
            place: number,
            state,
            objective,
            ground,
            watch,
            climber: Climber::new(ground, samples, watch, stream),
            seed,
            has_begun: false,
        }
    }

    /// What restarts are ordered by, the best first.
    pub(crate) fn rank(&self) -> (i64, usize) {
        (self.objective, self.number)
    }

    /// Take a turn; nothing once the restarts before it are out of reach, or a limit is.
    pub(crate) fn run(&mut self, round: &Round) {
        self.climber.take_place(self.place);
        if !self.climber.goes_on() {
            return;
        }
        self.climber.blocks.work = round.work;
        self.climber.deepest = round.deepest;
        if !self.has_begun {
            self.has_begun = true;
            self.begin(round);
        }
        self.settle_deep(round.deep.iter().map(|works| (3, works[0])));
        self.climber.kick_until_stale(&mut self.state, round.n_kicks);
        if !self.ground.has_planes() {
            self.climber.settle(&mut self.state, round.deepest);
        }
        self.settle_deep(round.deep.iter().flat_map(|works| [(3, works[0]), (4, works[1])]));
        self.objective = self.state.objective(&self.ground.prices);
        self.climber.report(self.objective);
        if self.climber.is_best(&self.state, self.objective) {
            self.watch.is_best(self.place);
        }
    }

    /// Settle with blocks of so many levels and so much work, one after the other.
    fn settle_deep(&mut self, blocks: impl Iterator<Item = (usize, f64)>) {
        for (levels, work) in blocks {
            let usual = std::mem::replace(&mut self.climber.blocks.work, work);
            self.climber.settle(&mut self.state, levels);
            self.climber.blocks.work = usual;
            self.climber.report(self.state.objective(&self.ground.prices));
        }
    }

    fn begin(&mut self, round: &Round) {
        if !self.ground.has_planes() {
            self.state = self.begin_axis(round.known);
            return;
        }
        let has_floor = self.number == 0 || (self.number == 1 && round.known.is_some());
        self.state = self.begin_planes(has_floor, round.n_kicks == 0);
        if has_floor {
            self.objective = self.state.objective(&self.ground.prices);
            // Told before the axis-aligned trees, which take far longer where samples are many.
            self.climber.report(self.objective);
            let floor = self.floor(round);
            if floor.objective(&self.ground.prices) < self.objective {
                self.state = floor;
            }
        }
    }

    /// An axis-aligned tree that a hyperplane tree must not be worse than; kicked where it is not far above it.
    fn floor(&mut self, round: &Round) -> State {
        self.climber.has_planes = false;
        let mut floor = self.begin_axis(round.known);
        if NEAR * (floor.objective(&self.ground.prices) as f64) < self.objective as f64 {
            self.climber.kick_until_stale(&mut floor, AXIS_KICKS.min(round.n_kicks));
        }
        self.climber.has_planes = true;
        floor
    }

    /// The known tree, the greedy one, then one for each promising root, then greedy ones with chance.
    fn begin_axis(&mut self, known: Option<&Tree>) -> State {
        let n_first = 1 + usize::from(known.is_some());
        if let (0, Some(tree)) = (self.number, known) {
            let mut state = State::from_tree(self.ground.problem, tree);
            self.climber.settle(&mut state, 2);
            return state;
        }
        let is_greedy = self.number < n_first;
        let is_free = self.ground.problem.sensor_limit.is_infinite();
        let planted = (!is_greedy && is_free).then(|| self.climber.plant(self.number - n_first, self.seed)).flatten();
        let mut state = planted.unwrap_or_else(|| self.grown(if is_greedy { 1.0 } else { RANDOM_SHARE }));
        self.climber.settle(&mut state, 2);
        let has_blocks = self.climber.blocks.deepest(self.ground.problem.n, 2) == 2;
        if is_greedy && is_free && has_blocks {
            self.look_ahead_from(&mut state);
        }
        self.climber.report(state.objective(&self.ground.prices));
        state
    }

    /// Take the tree of exact blocks, of two levels and then of three, where it is better.
    fn look_ahead_from(&mut self, state: &mut State) {
        let deepest = if self.ground.has_planes() { 2 } else { self.climber.deepest };
        let work = std::mem::replace(&mut self.climber.blocks.work, FIRST_WORK);
        for levels in 2..=deepest {
            let mut ahead = self.climber.look_ahead(levels, None);
            self.climber.settle(&mut ahead, 2);
            if ahead.objective(&self.ground.prices) < state.objective(&self.ground.prices) {
                *state = ahead;
                self.climber.report(state.objective(&self.ground.prices));
            }
        }
        self.climber.blocks.work = work;
    }

    fn grown(&mut self, share: f64) -> State {
        let problem = self.ground.problem;
        let mut state = State::leaf(problem);
        let soil = Soil { share, has_planes: false };
        self.climber.grow(&mut state, 0, problem.depth, soil);
        state
    }

    /// A tree of logistic splits, melted or not. A quick one visits every node once.
    fn begin_planes(&mut self, is_first: bool, is_quick: bool) -> State {
        let (ground, climber) = (self.ground, &mut self.climber);
        let share = if is_first { 1.0 } else { 0.5 + 0.5 * climber.rng.f64() };
        let soil = Soil { share, has_planes: ground.has_real_planes() };
        let mut state = State::leaf(ground.problem);
        climber.grow(&mut state, 0, ground.problem.depth, soil);
        // Planes of two features that melt together end alike; every other restart is more different without it.
        let is_narrow = ground.split_size() == 2 && ground.problem.p > 2;
        if !is_narrow || self.number.is_multiple_of(2) {
            climber.melt(&mut state, 0, WHOLE);
        }
        if is_quick {
            let nodes = state.below(0);
            climber.visit_each(&mut state, &nodes);
            state.compact();
        } else {
            climber.descend(&mut state);
        }
        state
    }
}

//! One restart from its start to its last kick.

use crate::search::climb::Climber;
use crate::search::ground::Ground;
use crate::search::melt::{Heat, Opening};
use crate::search::start::Soil;
use crate::search::state::State;
use crate::tree::Tree;

/// Share of the features that a randomised start may look at in one node.
const RANDOM_SHARE: f64 = 0.4;
/// Melting a whole tree from its start.
const WHOLE: Heat = Heat {
    n_steps: 1600,
    first_sharpness: 2.0,
    opening: Opening::All,
};

/// Where a restart begins.
#[derive(Debug, Clone, Copy)]
pub enum Start<'t> {
    /// A tree that is known.
    Known(&'t Tree),
    /// The greedy tree without chance.
    Greedy,
    /// A greedy tree with chance.
    Random,
}

/// The best tree of an axis-aligned restart.
///
/// Cheap descents come first, so that the dear exact blocks begin with a low budget and prune more.
pub fn axis(climber: &mut Climber, ground: &Ground, start: Start, n_kicks: usize) -> State {
    let problem = ground.problem;
    climber.has_planes = false;
    let mut state = match start {
        Start::Known(tree) => State::from_tree(problem, tree),
        Start::Greedy | Start::Random => {
            let share = if matches!(start, Start::Greedy) {
                1.0
            } else {
                RANDOM_SHARE
            };
            let mut state = State::leaf(problem);
            climber.grow(
                &mut state,
                0,
                problem.depth,
                Soil {
                    share,
                    has_planes: false,
                },
            );
            state
        }
    };
    climber.settle(&mut state, 2);
    let is_first = !matches!(start, Start::Random) && problem.sensor_limit.is_infinite();
    if is_first {
        improve_by_look_ahead(climber, ground, &mut state, 2);
    }
    climber.kick_until_stale(&mut state, n_kicks);
    if is_first && problem.depth > ground.deepest_block() {
        improve_by_look_ahead(climber, ground, &mut state, ground.deepest_block());
    }
    climber.settle(&mut state, ground.deepest_block());
    state
}

fn improve_by_look_ahead(
    climber: &mut Climber,
    ground: &Ground,
    state: &mut State,
    deepest: usize,
) {
    let mut ahead = climber.look_ahead(deepest, None);
    climber.settle(&mut ahead, deepest);
    if ahead.objective(&ground.prices) < state.objective(&ground.prices) {
        *state = ahead;
    }
}

/// The best tree of a restart with hyperplanes: from a tree of logistic splits, melted; never above `floor`.
pub fn planes(
    climber: &mut Climber,
    ground: &Ground,
    start: Start,
    floor: Option<State>,
    n_kicks: usize,
) -> State {
    let problem = ground.problem;
    climber.has_planes = true;
    let share = if matches!(start, Start::Random) {
        0.5 + 0.5 * climber.rng.f64()
    } else {
        1.0
    };
    let mut state = State::leaf(problem);
    climber.grow(
        &mut state,
        0,
        problem.depth,
        Soil {
            share,
            has_planes: ground.has_real_planes(),
        },
    );
    climber.melt(&mut state, 0, WHOLE);
    climber.descend(&mut state);
    let mut best = match floor {
        Some(floor) if floor.objective(&ground.prices) < state.objective(&ground.prices) => floor,
        _ => state,
    };
    climber.kick_until_stale(&mut best, n_kicks);
    best
}

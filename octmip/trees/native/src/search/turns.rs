//! Turns of restarts, taken by other processes: what goes out and what comes back.
//!
//! A turn depends on the restart's number and what it had after the turn before (`Turn`) alone. So it may be taken
//! anywhere, and again where it is lost with its process, and the tree is that of one machine.

use crate::control::{KeepGoing, Limits};
use crate::exact::samples::Samples;
use crate::problem::Problem;
use crate::search::options::Options;
use crate::search::prepared::{Made, Prepared};
use crate::search::restart::{Restart, Round};
use crate::search::watch::Watch;
use crate::tree::Tree;

/// A restart after a turn: all that its next turn begins from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Turn {
    /// The restart's number.
    pub(crate) number: usize,
    /// State of its random stream.
    pub(crate) stream: u64,
    /// Perturbations after which deep blocks have helped, and after which they were tried.
    pub(crate) deep_tries: [u32; 2],
    /// Whether nothing beats its tree.
    pub(crate) is_best: bool,
    /// Its tree.
    pub(crate) tree: Tree,
}

/// A turn that is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnTask<'a> {
    /// Number of the round.
    pub(crate) round: usize,
    /// Number of the restart.
    pub(crate) number: usize,
    /// The turn before; None where the restart has not begun.
    pub(crate) before: Option<&'a Turn>,
    /// What is left of the seconds and nodes.
    pub(crate) limits: Limits,
}

/// A turn that was taken.
#[derive(Debug, Clone)]
pub(crate) struct FinishedTurn {
    /// The turn.
    pub(crate) turn: Turn,
    /// Nodes visited in it.
    pub(crate) n_visits: u64,
    /// Whether no limit has ended it.
    pub(crate) is_whole: bool,
}

/// Asks for a turn and waits for it as long as `waits` says; None when it was given up.
pub(crate) type Ask<'a> = dyn Fn(TurnTask, &dyn Fn() -> bool) -> Option<FinishedTurn> + Sync + 'a;

/// Other processes that take turns.
pub(crate) struct OtherProcesses<'a> {
    /// Asks one of them, and waits.
    pub(crate) ask: &'a Ask<'a>,
    /// Turns that are asked for at once.
    pub(crate) n_at_once: usize,
}

/// The solver in another process: a problem ready for turns of its restarts.
pub(crate) struct TurnSolver {
    problem: Problem,
    made: Made,
    samples: Samples,
    options: Options,
    start: Option<Tree>,
}

impl TurnSolver {
    /// Of a problem, with the options and the incumbent of the search that asks.
    pub(crate) fn new(problem: Problem, options: Options, start: Option<Tree>) -> Self {
        Self { made: Made::new(&problem), samples: Samples::new(&problem), problem, options, start }
    }

    /// Take a turn.
    pub(crate) fn take(&self, task: TurnTask, keep_going: KeepGoing<'_>) -> FinishedTurn {
        let prepared = Prepared { problem: &self.problem, made: &self.made };
        let watch = Watch::new(task.limits);
        let mut restart = Restart::new(&prepared, &self.samples, &watch, self.options.seed, task.number);
        if let Some(turn) = task.before {
            restart.take_up(turn);
        }
        restart.place = 0;
        let round = &Round::all(self.options, self.start.as_ref(), &self.problem)[task.round];
        let is_whole = watch.supervision.run(|| restart.run(round), || watch.look(&mut *keep_going));
        FinishedTurn { turn: restart.turn(), n_visits: watch.n_visits(), is_whole }
    }
}

//! Turns of restarts taken by other processes: what goes out, what comes back, and the solver at the other end.
//!
//! A turn depends on the restart's number and what it had after the turn before (`Turn`) alone, as in a search that
//! goes on from a checkpoint. So it may be taken anywhere, and again where it is lost with its process, and the tree is
//! that of one machine.

use crate::control::{KeepGoing, Limits};
use crate::exact::samples::Samples;
use crate::problem::Problem;
use crate::search::known::Turn;
use crate::search::options::Options;
use crate::search::prepared::{Made, Prepared};
use crate::search::restart::{Restart, Round};
use crate::search::watch::Watch;
use crate::tree::Tree;

/// A turn that is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted<'a> {
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
pub(crate) struct Taken {
    /// The turn.
    pub(crate) turn: Turn,
    /// Nodes visited in it.
    pub(crate) n_visits: u64,
    /// Whether no limit has ended it.
    pub(crate) is_whole: bool,
}

/// Asks for a turn and waits for it as long as `waits` says; None when it was given up.
pub(crate) type Ask<'a> = dyn Fn(Wanted, &dyn Fn() -> bool) -> Option<Taken> + Sync + 'a;

/// Takers of turns in other processes.
pub(crate) struct Elsewhere<'a> {
    /// Asks one of them, and waits.
    pub(crate) ask: &'a Ask<'a>,
    /// Turns that are asked for at once.
    pub(crate) n_at_once: usize,
}

/// The other end: a problem ready for turns of its restarts.
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
    pub(crate) fn take(&self, wanted: Wanted, keep_going: KeepGoing<'_>) -> Taken {
        let prepared = Prepared { problem: &self.problem, made: &self.made };
        let watch = Watch::new(wanted.limits);
        let mut restart = Restart::new(&prepared, &self.samples, &watch, self.options.seed, wanted.number);
        if let Some(turn) = wanted.before {
            restart.take_up(turn);
        }
        restart.place = 0;
        let round = &Round::all(self.options, self.start.as_ref(), &self.problem)[wanted.round];
        let is_whole = watch.supervision.run(|| restart.run(round), || watch.look(&mut *keep_going));
        Taken { turn: restart.turn(), n_visits: watch.n_visits(), is_whole }
    }
}

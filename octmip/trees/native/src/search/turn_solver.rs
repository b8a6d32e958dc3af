//! The solver of turns in another process.

use crate::control::KeepGoing;
use crate::exact::samples::Samples;
use crate::problem::Problem;
use crate::search::options::Options;
use crate::search::prepared::{Made, Prepared};
use crate::search::restart::{Restart, Round};
use crate::search::turns::{FinishedTurn, TurnTask};
use crate::search::watch::Watch;
use crate::tree::Tree;

/// A problem ready for turns of its restarts.
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

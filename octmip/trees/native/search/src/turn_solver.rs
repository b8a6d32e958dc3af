//! The solver of turns in another process.

use crate::options::Options;
use crate::prepared::{Made, Prepared};
use crate::restart::{Restart, Round};
use crate::turns::{FinishedTurn, TurnTask};
use crate::watch::Watch;
use octmip_check::problem::Problem;
use octmip_exact::Samples;
use octmip_frame::control::KeepGoing;
use octmip_frame::tree::Tree;

/// A problem ready for turns of its restarts.
pub struct TurnSolver {
    problem: Problem,
    made: Made,
    samples: Samples,
    options: Options,
    start: Option<Tree>,
}

impl TurnSolver {
    /// Of a problem, with the options and the incumbent of the search that asks.
    pub fn new(problem: Problem, options: Options, start: Option<Tree>) -> Self {
        Self { made: Made::new(&problem), samples: Samples::new(&problem), problem, options, start }
    }

    /// Take a turn.
    pub fn take(&self, task: TurnTask, keep_going: KeepGoing<'_>) -> FinishedTurn {
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

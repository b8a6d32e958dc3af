//! `octmip.trees._native.search`: the local search.

use pyo3::prelude::*;

use crate::control::Limits;
use crate::python::problem::PyProblem;
use crate::python::rows::{NodeRow, rows_from_tree, tree_from_rows};
use crate::python::run::{Found, LimitValues, found, limits, supervised};
use crate::python::workers::Workers;
use crate::search::turns::elsewhere::{Elsewhere, Taken, Wanted};
use crate::search::turns::known::{Known, Saver, Turn};
use crate::search::turns::solver::TurnSolver;
use crate::search::{Options, go_on};

/// A restart after a turn: number, state of its random stream, counts of deep blocks, whether nothing beats its tree,
/// rows of the tree.
type TurnRow = (usize, u64, (u32, u32), bool, Vec<NodeRow>);
/// What a search has finished: first restart of the group, turns of its rounds, best restart before, visits.
type KnownRow = (usize, [Vec<TurnRow>; 3], Option<TurnRow>, u64);
/// A turn to be taken: round, number of the restart, the turn before.
type WantedRow = (usize, usize, Option<TurnRow>);
/// A turn that was taken: the turn, nodes visited in it, whether no limit has ended it.
type TakenRow = (TurnRow, u64, bool);
/// Seconds between two times that what is finished is handed out, who takes it, what an earlier search has finished.
type Checkpoint = (f64, Py<PyAny>, Option<KnownRow>);

/// A tree of low objective. `incumbent` is the table of a tree to begin with.
#[pyfunction(name = "search")]
#[pyo3(signature = (problem, incumbent, limit_values, n_threads, seed, progress=None, *, n_restarts, n_perturbations,
    checkpoint=None, submit=None))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn py_search(
    py: Python<'_>,
    problem: &PyProblem,
    incumbent: Option<Vec<NodeRow>>,
    limit_values: LimitValues,
    n_threads: usize,
    seed: u64,
    progress: Option<Py<PyAny>>,
    n_restarts: usize,
    n_perturbations: usize,
    checkpoint: Option<Checkpoint>,
    submit: Option<(Py<PyAny>, usize)>,
) -> PyResult<Found> {
    let start = incumbent.map(tree_from_rows).transpose()?;
    let options = Options { n_restarts, n_perturbations, seed, n_threads };
    let (every, taker, row) = checkpoint.map_or((0.0, None, None), |(every, taker, row)| (every, Some(taker), row));
    let known = row.map(known_from_row).transpose()?;
    let mut unsaved = None;
    let (workers, n_at_once) = submit.map_or((None, 0), |(submit, n)| (Some(Workers::new(submit)), n));
    let ask = |wanted: Wanted, waits: &dyn Fn() -> bool| ask_for(workers.as_ref()?, wanted, waits);
    let elsewhere = workers.as_ref().map(|_| Elsewhere { ask: &ask, n_at_once });
    let outcome = supervised(py, progress.as_ref(), |keep_going| {
        let mut save = |known: &Known| hand_out(taker.as_ref(), known, &mut unsaved);
        let saver = taker.is_some().then_some(Saver { every, save: &mut save });
        let has_failed = || workers.as_ref().is_some_and(Workers::has_failed);
        let mut keep_going = |state| keep_going(state) && !has_failed();
        let (limits, kept) = (limits(limit_values), (known, saver));
        go_on(&problem.inner, options, start.as_ref(), limits, kept, elsewhere.as_ref(), &mut keep_going)
    })?;
    workers.map_or(Ok(()), Workers::finish)?;
    unsaved.map_or_else(|| Ok(found(&outcome)), Err)
}

/// Give Python what is finished; what it raises stops the search and is kept.
fn hand_out(taker: Option<&Py<PyAny>>, known: &Known, unsaved: &mut Option<PyErr>) -> bool {
    let Some(taker) = taker else { return true };
    let rows = |turns: &Vec<Turn>| turns.iter().map(row_of).collect::<Vec<_>>();
    let row: KnownRow =
        (known.first, known.rounds.each_ref().map(rows), known.best.as_ref().map(row_of), known.n_visits);
    let taken = Python::attach(|py| taker.call1(py, (row,)).map(|_| ()));
    taken.map_err(|raised| *unsaved = Some(raised)).is_ok()
}

fn row_of(turn: &Turn) -> TurnRow {
    let [helped, tried] = turn.deep_tries;
    (turn.number, turn.stream, (helped, tried), turn.is_best, rows_from_tree(&turn.tree))
}

fn turn_from_row((number, stream, (helped, tried), is_best, rows): TurnRow) -> PyResult<Turn> {
    Ok(Turn { number, stream, deep_tries: [helped, tried], is_best, tree: tree_from_rows(rows)? })
}

fn known_from_row((first, rounds, best, n_visits): KnownRow) -> PyResult<Known> {
    let [begun, gone_on, last] = rounds.map(|turns| turns.into_iter().map(turn_from_row).collect::<PyResult<Vec<_>>>());
    let best = best.map(turn_from_row).transpose()?;
    Ok(Known { first, rounds: [begun?, gone_on?, last?], best, n_visits })
}

/// A turn that one of the workers took; None when it was given up or has failed.
fn ask_for(workers: &Workers, wanted: Wanted, waits: &dyn Fn() -> bool) -> Option<Taken> {
    let row: WantedRow = (wanted.round, wanted.number, wanted.before.map(row_of));
    let Limits { seconds, gap, nodes, memory } = wanted.limits;
    let (turn, n_visits, is_whole): TakenRow = workers.ask((row, (seconds, gap, nodes, memory)), waits)?;
    Some(Taken { turn: workers.checked(turn_from_row(turn))?, n_visits, is_whole })
}

/// A problem ready for turns of its restarts, in a process that helps another one's search.
#[pyclass(name = "TurnSolver", frozen)]
pub(crate) struct PyTurnSolver {
    inner: TurnSolver,
}

#[pymethods]
impl PyTurnSolver {
    #[new]
    fn new(
        problem: &PyProblem,
        incumbent: Option<Vec<NodeRow>>,
        seed: u64,
        n_restarts: usize,
        n_perturbations: usize,
    ) -> PyResult<Self> {
        let options = Options { n_restarts, n_perturbations, seed, n_threads: 1 };
        let start = incumbent.map(tree_from_rows).transpose()?;
        Ok(Self { inner: TurnSolver::new(problem.inner.clone(), options, start) })
    }

    /// Take a turn within limits; what `progress` raises stops it and is raised here.
    #[pyo3(signature = (row, limit_values, progress=None))]
    fn take(
        &self,
        py: Python<'_>,
        row: WantedRow,
        limit_values: LimitValues,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<TakenRow> {
        let (round, number, before) = row;
        let before = before.map(turn_from_row).transpose()?;
        let wanted = Wanted { round, number, before: before.as_ref(), limits: limits(limit_values) };
        let taken = supervised(py, progress.as_ref(), |keep_going| self.inner.take(wanted, keep_going))?;
        Ok((row_of(&taken.turn), taken.n_visits, taken.is_whole))
    }
}

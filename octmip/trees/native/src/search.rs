//! `octmip.trees._native.search`: the local search.

use pyo3::prelude::*;

use crate::problem::PyProblem;
use crate::rows::{NodeRow, rows_from_tree, tree_from_rows};
use crate::run::{Found, LimitValues, found, limits, supervised};
use crate::workers::Workers;
use octmip_frame::control::Limits;
use octmip_search::{FinishedTurn, Options, OtherProcesses, Turn, TurnSolver, TurnTask, search};

/// A restart after a turn, as a dict.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct TurnRow {
    number: usize,
    /// State of its random stream.
    stream: u64,
    /// Deep blocks that helped, and that were tried.
    deep_tries: [u32; 2],
    /// Whether nothing beats its tree.
    is_best: bool,
    rows: Vec<NodeRow>,
}

/// A turn to be taken, as a dict.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct TaskRow {
    round: usize,
    /// Of the restart.
    number: usize,
    /// The turn before.
    before: Option<TurnRow>,
}

/// A turn that was taken, as a dict.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct FinishedRow {
    turn: TurnRow,
    /// Nodes visited in it.
    n_visits: u64,
    /// Whether no limit has ended it.
    is_whole: bool,
}

/// A tree of low objective. `incumbent` is the table of a tree to begin with.
#[pyfunction(name = "search")]
#[pyo3(signature = (problem, incumbent, limit_values, n_threads, seed, progress=None, *, n_restarts, n_perturbations,
    submit=None))]
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
    submit: Option<(Py<PyAny>, usize)>,
) -> PyResult<Found> {
    let start = incumbent.map(tree_from_rows).transpose()?;
    let options = Options { n_restarts, n_perturbations, seed, n_threads };
    let (workers, n_at_once) = submit.map_or((None, 0), |(submit, n)| (Some(Workers::new(submit)), n));
    let ask = |task: TurnTask, waits: &dyn Fn() -> bool| ask_for(workers.as_ref()?, task, waits);
    let others = workers.as_ref().map(|_| OtherProcesses { ask: &ask, n_at_once });
    let outcome = supervised(py, progress.as_ref(), |keep_going| {
        let has_failed = || workers.as_ref().is_some_and(Workers::has_failed);
        let mut keep_going = |state| keep_going(state) && !has_failed();
        let limits = limits(limit_values);
        search(&problem.inner, options, start.as_ref(), limits, others.as_ref(), &mut keep_going)
    })?;
    workers.map_or(Ok(()), Workers::finish)?;
    Ok(found(&outcome))
}

fn row_of(turn: &Turn) -> TurnRow {
    TurnRow {
        number: turn.number,
        stream: turn.stream,
        deep_tries: turn.deep_tries,
        is_best: turn.is_best,
        rows: rows_from_tree(&turn.tree),
    }
}

fn turn_from_row(TurnRow { number, stream, deep_tries, is_best, rows }: TurnRow) -> PyResult<Turn> {
    Ok(Turn { number, stream, deep_tries, is_best, tree: tree_from_rows(rows)? })
}

/// A turn that one of the workers took; None when it was given up or has failed.
fn ask_for(workers: &Workers, task: TurnTask, waits: &dyn Fn() -> bool) -> Option<FinishedTurn> {
    let row = TaskRow { round: task.round, number: task.number, before: task.before.map(row_of) };
    let Limits { seconds, gap, nodes, memory } = task.limits;
    let left = LimitValues { seconds, gap, nodes, memory };
    let FinishedRow { turn, n_visits, is_whole } = workers.ask((row, left), waits)?;
    Some(FinishedTurn { turn: workers.checked(turn_from_row(turn))?, n_visits, is_whole })
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
        row: TaskRow,
        limit_values: LimitValues,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<FinishedRow> {
        let TaskRow { round, number, before } = row;
        let before = before.map(turn_from_row).transpose()?;
        let task = TurnTask { round, number, before: before.as_ref(), limits: limits(limit_values) };
        let taken = supervised(py, progress.as_ref(), |keep_going| self.inner.take(task, keep_going))?;
        Ok(FinishedRow { turn: row_of(&taken.turn), n_visits: taken.n_visits, is_whole: taken.is_whole })
    }
}

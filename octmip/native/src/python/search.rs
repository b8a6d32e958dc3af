//! `octmip._native.search`: the local search.

use pyo3::prelude::*;

use crate::python::problem::PyProblem;
use crate::python::rows::{NodeRow, rows_from_tree, tree_from_rows};
use crate::python::run::{Found, LimitValues, found, limits, supervised};
use crate::search::known::{Known, Saver, Turn};
use crate::search::{Options, go_on};

/// A restart after a turn: number, state of its random stream, counts of deep blocks, whether nothing beats its tree,
/// rows of the tree.
type TurnRow = (usize, u64, (u32, u32), bool, Vec<NodeRow>);
/// What a search has finished: first restart of the group, turns of its rounds, best restart before, visits.
type KnownRow = (usize, [Vec<TurnRow>; 3], Option<TurnRow>, u64);
/// Seconds between two times that what is finished is handed out, who takes it, what an earlier search has finished.
type Checkpoint = (f64, Py<PyAny>, Option<KnownRow>);

/// A tree of low objective. `incumbent` is the table of a tree to begin with.
#[pyfunction(name = "search")]
#[pyo3(signature = (problem, incumbent, limit_values, n_threads, seed, progress=None, *, n_restarts, n_perturbations,
    checkpoint=None))]
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
) -> PyResult<Found> {
    let start = incumbent.map(tree_from_rows).transpose()?;
    let options = Options { n_restarts, n_perturbations, seed, n_threads };
    let (every, taker, row) = checkpoint.map_or((0.0, None, None), |(every, taker, row)| (every, Some(taker), row));
    let known = row.map(known_from_row).transpose()?;
    let mut unsaved = None;
    let outcome = supervised(py, progress.as_ref(), |keep_going| {
        let mut save = |known: &Known| hand_out(taker.as_ref(), known, &mut unsaved);
        let saver = taker.is_some().then_some(Saver { every, save: &mut save });
        go_on(&problem.inner, options, start.as_ref(), limits(limit_values), (known, saver), keep_going)
    })?;
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

fn known_from_row((first, rounds, best, n_visits): KnownRow) -> PyResult<Known> {
    let turn = |(number, stream, (helped, tried), is_best, rows): TurnRow| {
        Ok::<_, PyErr>(Turn { number, stream, deep_tries: [helped, tried], is_best, tree: tree_from_rows(rows)? })
    };
    let [begun, gone_on, last] = rounds.map(|turns| turns.into_iter().map(turn).collect::<PyResult<Vec<_>>>());
    Ok(Known { first, rounds: [begun?, gone_on?, last?], best: best.map(turn).transpose()?, n_visits })
}

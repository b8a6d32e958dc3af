//! `octmip._native.search`: problem, options and limits in; a node table, objective, bound and counters out.

use pyo3::prelude::*;

use crate::python::{NodeRow, PyProblem, keep_going, limits, rows_from_tree, stop_name, tree_from_rows};
use crate::search::{Options, search};

/// Node table, objective, bound, stop, nodes visited.
type Found = (Vec<NodeRow>, i64, i64, &'static str, u64);

/// Search for a tree of low objective.
#[pyfunction(name = "search")]
#[pyo3(signature = (problem, n_restarts, n_perturbations, seed, n_threads, limit_values, start=None, progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn py_search(
    py: Python<'_>,
    problem: &PyProblem,
    n_restarts: usize,
    n_perturbations: usize,
    seed: u64,
    n_threads: usize,
    limit_values: (f64, f64, f64, f64),
    start: Option<Vec<NodeRow>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found> {
    let start = start.map(tree_from_rows).transpose()?;
    let options = Options { n_restarts, n_perturbations, seed, n_threads };
    let mut error = None;
    let outcome = py.detach(|| {
        let mut go_on = keep_going(progress.as_ref(), &mut error);
        search(&problem.inner, options, start.as_ref(), limits(limit_values), &mut go_on)
    });
    match error {
        Some(raised) => Err(raised),
        None => Ok((
            rows_from_tree(&outcome.tree),
            outcome.objective,
            outcome.bound,
            stop_name(outcome.stop),
            outcome.n_nodes,
        )),
    }
}

//! `octmip._native.search`: the local search.

use pyo3::prelude::*;

use crate::python::problem::PyProblem;
use crate::python::rows::{NodeRow, tree_from_rows};
use crate::python::run::{Found, LimitValues, found, limits, supervised};
use crate::search::{Options, search};

/// A tree of low objective. `incumbent` is the table of a tree to begin with.
#[pyfunction(name = "search")]
#[pyo3(signature = (problem, incumbent, limit_values, n_threads, seed, progress=None, *, n_restarts, n_perturbations))]
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
) -> PyResult<Found> {
    let start = incumbent.map(tree_from_rows).transpose()?;
    let options = Options { n_restarts, n_perturbations, seed, n_threads };
    let outcome = supervised(py, progress.as_ref(), |keep_going| {
        search(&problem.inner, options, start.as_ref(), limits(limit_values), keep_going)
    })?;
    Ok(found(&outcome))
}

//! `octmip.trees._native.sequential`: trees whose sensors are read one after the other.

use pyo3::prelude::*;

use crate::python::problem::PySequentialProblem;
use crate::python::rows::rows_from_tree;
use crate::python::run::{FoundBelow, LimitValues, limits, stop_name, supervised};
use crate::sequential::solve;

/// The best tree that weighs less than the incumbent's `room`, which holds the error alone where there is a cap.
#[pyfunction]
#[pyo3(signature = (problem, room, limit_values))]
pub(crate) fn sequential(
    py: Python<'_>,
    problem: &PySequentialProblem,
    room: f64,
    limit_values: LimitValues,
) -> PyResult<FoundBelow> {
    let result = supervised(py, None, |keep_going| solve(&problem.inner, room, limits(limit_values), keep_going))?;
    let rows = result.tree.as_ref().map(rows_from_tree);
    Ok(FoundBelow { rows, bound: result.bound, stop: stop_name(result.stop), n_nodes: result.n_cuts })
}

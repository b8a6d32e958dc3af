//! `octmip.trees._native.sequential`: trees whose sensors are read one after the other.

use pyo3::prelude::*;

use crate::python::problem::PySequentialProblem;
use crate::python::rows::{NodeRow, rows_from_tree};
use crate::python::run::{LimitValues, limits, stop_name, supervised};
use crate::sequential::solve;

/// Node rows (None without a tree below the room), bound, stop, evaluated cuts.
type Found = (Option<Vec<NodeRow>>, f64, &'static str, u64);

/// The best tree that weighs less than the incumbent's `room`, which holds the error alone where there is a cap.
#[pyfunction]
#[pyo3(signature = (problem, room, limit_values))]
pub(crate) fn sequential(
    py: Python<'_>,
    problem: &PySequentialProblem,
    room: f64,
    limit_values: LimitValues,
) -> PyResult<Found> {
    let result = supervised(py, None, |keep_going| solve(&problem.inner, room, limits(limit_values), keep_going))?;
    Ok((result.tree.as_ref().map(rows_from_tree), result.bound, stop_name(result.stop), result.n_cuts))
}

//! `octmip.trees._native.worst_case`: trees of least worst case while gauges are off.

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::python::problem::PyProblem;
use crate::python::rows::{Incumbent, NodeRow, known_tree, rows_from_tree, tree_from_rows};
use crate::python::run::{Found, LimitValues, found, limits, stop_name, supervised};
use crate::worst_case::{Bands, search, solve};

/// The bands by the attributes of a Python object.
#[derive(FromPyObject)]
pub(crate) struct BandRow<'py> {
    /// Ranks of the lowest readings (p, n).
    low: PyReadonlyArray2<'py, u32>,
    /// Ranks of the highest readings (p, n).
    high: PyReadonlyArray2<'py, u32>,
    /// Most sensors that are off.
    n_off: usize,
    /// Number of labels.
    n_labels: usize,
}

/// The bands, checked against their problem.
pub(crate) fn bands(problem: &PyProblem, row: BandRow<'_>) -> PyResult<Bands> {
    let BandRow { low, high, n_off, n_labels } = row;
    let shape = [problem.inner.p, problem.inner.n];
    if low.shape() != shape || high.shape() != shape {
        return Err(PyValueError::new_err(format!("bands have shape {:?}, expected {shape:?}", low.shape())));
    }
    let bands = Bands { low: low.as_slice()?.to_vec(), high: high.as_slice()?.to_vec(), n_off, n_labels };
    bands.complaint(&problem.inner).map_or(Ok(bands), |complaint| Err(PyValueError::new_err(complaint)))
}

/// The tree of least worst case to depth 2, and a bound. `floor` is a bound known beforehand.
#[pyfunction]
#[pyo3(signature = (problem, band_row, incumbent, floor, limit_values, n_threads, progress=None))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn worst_case(
    py: Python<'_>,
    problem: &PyProblem,
    band_row: BandRow<'_>,
    incumbent: Incumbent,
    floor: i64,
    limit_values: LimitValues,
    n_threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found> {
    if problem.inner.depth > 2 {
        return Err(PyValueError::new_err(format!("depth is {}, expected at most 2", problem.inner.depth)));
    }
    let bands = bands(problem, band_row)?;
    let first = known_tree(incumbent)?;
    let outcome = supervised(py, progress.as_ref(), |keep_going| {
        solve(&problem.inner, &bands, first, floor, limits(limit_values), n_threads, keep_going)
    })?;
    Ok(found(&outcome))
}

/// The best tree that changes of single nodes lead to from some starts, its cost, and stop.
#[pyfunction]
#[pyo3(signature = (problem, band_row, starts, n_rounds, seed, limit_values))]
pub(crate) fn worst_case_search(
    py: Python<'_>,
    problem: &PyProblem,
    band_row: BandRow<'_>,
    starts: Vec<Vec<NodeRow>>,
    n_rounds: usize,
    seed: u64,
    limit_values: LimitValues,
) -> PyResult<(Vec<NodeRow>, i64, &'static str)> {
    let bands = bands(problem, band_row)?;
    let starts = starts.into_iter().map(tree_from_rows).collect::<PyResult<Vec<_>>>()?;
    let (tree, cost, stop) = supervised(py, None, |keep_going| {
        search(&problem.inner, &bands, &starts, n_rounds, seed, limits(limit_values), keep_going)
    })?;
    Ok((rows_from_tree(&tree), cost, stop_name(stop)))
}

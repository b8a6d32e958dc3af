//! `octmip._native.regression`: trees of least squared or absolute error.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::python::rows::{NodeRow, rows_from_tree};
use crate::python::run::{LimitValues, limits, stop_name, supervised};
use crate::regression::{Question, solve};

/// Targets, weights, rounded squares of each sample, the grid of the squares.
type Targets<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>, f64);
/// Whether the error is absolute, price of a split, depth, leaf size, which features may be used.
type Shape = (bool, f64, usize, usize, Vec<bool>);
/// Node rows (None without a tree below the room), bound, stop, evaluated cuts.
type Found = (Option<Vec<NodeRow>>, f64, &'static str, u64);

/// The best tree that costs less than `room` (None: any), and a bound of all trees.
#[pyfunction]
#[pyo3(signature = (ranks, n_ranks, targets, shape, room, limit_values, progress=None))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn regression(
    py: Python<'_>,
    ranks: PyReadonlyArray2<'_, u32>,
    n_ranks: Vec<u32>,
    targets: Targets<'_>,
    shape: Shape,
    room: Option<f64>,
    limit_values: LimitValues,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found> {
    let (is_absolute, penalty, depth, leaf_size, allowed) = shape;
    let question = Question {
        n: ranks.shape()[1],
        p: ranks.shape()[0],
        ranks: ranks.as_slice()?.to_vec(),
        n_ranks,
        targets: targets.0.as_slice()?.to_vec(),
        weights: targets.1.as_slice()?.to_vec(),
        squares: targets.2.as_slice()?.to_vec(),
        grain: targets.3,
        is_absolute,
        penalty,
        depth,
        leaf_size,
        allowed,
    };
    if let Some(complaint) = question.complaint() {
        return Err(PyValueError::new_err(complaint));
    }
    let found =
        supervised(py, progress.as_ref(), |keep_going| solve(&question, room, limits(limit_values), keep_going))?;
    Ok((found.tree.as_ref().map(rows_from_tree), found.bound, stop_name(found.stop), found.n_cuts))
}

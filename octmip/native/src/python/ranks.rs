//! Dense ranks at the Python border.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::ranks::Ranker;

/// Ranks (p, n) of features (n, p), and the number of distinct values of each.
type Ranked<'py> = (Bound<'py, PyArray2<u32>>, Vec<usize>);

/// Rank every feature.
#[pyfunction]
pub fn dense_ranks<'py>(py: Python<'py>, features: PyReadonlyArray2<'py, f64>) -> Ranked<'py> {
    let features = features.as_array();
    let mut ranks = Array2::zeros((features.ncols(), features.nrows()));
    let mut ranker = Ranker::default();
    let mut n_values = Vec::new();
    for (column, row) in features.columns().into_iter().zip(ranks.outer_iter_mut()) {
        if let Some(row) = row.into_slice() {
            n_values.push(ranker.rank(column.iter().copied(), row).len());
        }
    }
    (ranks.into_pyarray(py), n_values)
}

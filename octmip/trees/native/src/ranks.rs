//! Dense ranks at the Python border.

use std::sync::Arc;

use numpy::ndarray::ArrayView2;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::reached::Rows;
use octmip_frame::ranks::Ranker;

/// Dense ranks of every feature, held once: problems share them, and Python reads them column by column.
#[pyclass(name = "RankTable", module = "octmip.trees._native", frozen)]
pub(crate) struct PyRankTable {
    /// Number of features.
    pub(crate) p: usize,
    /// Number of samples.
    pub(crate) n: usize,
    /// Feature-major (`p * n`).
    pub(crate) ranks: Arc<Vec<u32>>,
}

#[pymethods]
impl PyRankTable {
    #[new]
    fn new(ranks: PyReadonlyArray2<'_, u32>) -> PyResult<Self> {
        let (p, n) = (ranks.shape()[0], ranks.shape()[1]);
        Ok(Self { p, n, ranks: Arc::new(ranks.as_slice()?.to_vec()) })
    }

    fn column<'py>(&self, py: Python<'py>, feature: usize) -> PyResult<Bound<'py, PyArray1<u32>>> {
        if feature >= self.p {
            return Err(PyIndexError::new_err(format!("feature {feature} of {}", self.p)));
        }
        Ok(PyArray1::from_slice(py, &self.ranks[feature * self.n..(feature + 1) * self.n]))
    }

    fn array<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        PyArray1::from_slice(py, &self.ranks).reshape([self.p, self.n])
    }

    fn of_rows(&self, rows: PyReadonlyArray1<'_, i64>) -> PyResult<Self> {
        let rows = rows.as_slice()?;
        if let Some(row) = rows.iter().find(|&&row| !(0..self.n as i64).contains(&row)) {
            return Err(PyIndexError::new_err(format!("row {row} of {}", self.n)));
        }
        let features = (0..self.p).map(|feature| &self.ranks[feature * self.n..(feature + 1) * self.n]);
        let ranks = features.flat_map(|column| rows.iter().map(|&row| column[row as usize])).collect();
        Ok(Self { p: self.p, n: rows.len(), ranks: Arc::new(ranks) })
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<u32>>,)> {
        Ok((self.array(py)?,))
    }
}

/// Rank every feature of a table (n, p) of either precision; how many distinct values each has.
#[pyfunction]
pub(crate) fn dense_ranks(features: Rows<'_>) -> PyResult<(PyRankTable, Vec<usize>)> {
    match features {
        Rows::Double(features) => ranks_of(features.as_array()),
        Rows::Single(features) => ranks_of(features.as_array()),
    }
}

fn ranks_of<T: Copy + Into<f64>>(features: ArrayView2<'_, T>) -> PyResult<(PyRankTable, Vec<usize>)> {
    let (n, p) = (features.nrows(), features.ncols());
    if n == 0 {
        return Err(PyValueError::new_err("there are no samples to rank"));
    }
    let mut ranks = vec![0; n * p];
    let mut ranker = Ranker::default();
    let columns = features.columns().into_iter().zip(ranks.chunks_exact_mut(n));
    let n_values =
        columns.map(|(column, row)| ranker.rank(column.iter().map(|&value| value.into()), row).len()).collect();
    Ok((PyRankTable { p, n, ranks: Arc::new(ranks) }, n_values))
}

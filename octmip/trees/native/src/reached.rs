//! Predictions of many rows at the Python border.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use octmip_frame::tree::reached::ThresholdTree;

/// A table of rows in either precision.
#[derive(FromPyObject)]
pub(crate) enum Rows<'py> {
    /// Of 64 bits.
    Double(PyReadonlyArray2<'py, f64>),
    /// Of 32 bits.
    Single(PyReadonlyArray2<'py, f32>),
}

/// The node that each row ends at, None where a reading is missing and its split has no side for it.
#[pyfunction]
#[pyo3(signature = (rows, *, feature, threshold, children, missing, depth))]
pub(crate) fn reached_nodes<'py>(
    py: Python<'py>,
    rows: Rows<'py>,
    feature: Vec<u32>,
    threshold: Vec<f64>,
    children: Vec<[u32; 2]>,
    missing: Vec<Option<bool>>,
    depth: usize,
) -> PyResult<Option<Bound<'py, PyArray1<u32>>>> {
    let tree = ThresholdTree { feature, threshold, children, missing, depth };
    let p = match &rows {
        Rows::Double(rows) => rows.shape()[1],
        Rows::Single(rows) => rows.shape()[1],
    };
    if !tree.is_sound(p) {
        return Err(PyValueError::new_err(format!("no tree over {p} features")));
    }
    let found = match &rows {
        Rows::Double(rows) => detached(py, &tree, rows.as_slice()?, p),
        Rows::Single(rows) => detached(py, &tree, rows.as_slice()?, p),
    };
    Ok(found.map(|nodes| nodes.into_pyarray(py)))
}

fn detached<T: Copy + Into<f64> + Sync>(
    py: Python<'_>,
    tree: &ThresholdTree,
    rows: &[T],
    p: usize,
) -> Option<Vec<u32>> {
    py.detach(|| tree.reached(rows, p))
}

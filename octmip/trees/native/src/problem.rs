//! Problems of the solvers as Python objects: arrays in, checked once.
//!
//! Every solver is called with the same arguments in the same order:
//!
//! ```text
//! problem, incumbent, limits, n_threads, seed, off, progress, then its own by name
//! ```
//!
//! each left out where a solver has no use for it. `limits` is a `Limits` of `octmip.trees.answer.solution`, `off` has
//! the names of prunes that are switched off, `progress` takes `(seconds, objective, bound, n_nodes)`. A problem is
//! made by names. Python objects are read by their attributes and answers are classes; what goes both ways is a dict.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::ranks::PyRankTable;
use octmip_check::problem::{Planes, Problem};

/// Data of hyperplane splits: a dict with these names, see `Planes`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct PlaneArguments<'py> {
    values: PyReadonlyArray2<'py, f64>,
    split_size: usize,
    groups: Option<Vec<Vec<u32>>>,
    integer_normals: Option<i64>,
}

/// `octmip_check::problem::Problem` as a Python object.
#[pyclass(name = "Problem", frozen)]
pub(crate) struct PyProblem {
    /// The problem.
    pub(crate) inner: Problem,
}

#[pymethods]
impl PyProblem {
    #[new]
    #[pyo3(signature = (*, ranks, n_ranks, labels, weights, costs, penalty, depth, leaf_size, sensor_of_feature,
        sensor_cost, sensor_limit, allowed, planes=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        ranks: PyRef<'_, PyRankTable>,
        n_ranks: Vec<u32>,
        labels: PyReadonlyArray1<'_, u32>,
        weights: PyReadonlyArray1<'_, i64>,
        costs: PyReadonlyArray2<'_, i64>,
        penalty: i64,
        depth: usize,
        leaf_size: usize,
        sensor_of_feature: Vec<u32>,
        sensor_cost: Vec<f64>,
        sensor_limit: f64,
        allowed: Vec<bool>,
        planes: Option<PlaneArguments<'_>>,
    ) -> PyResult<Self> {
        let planes = planes
            .map(|PlaneArguments { values, split_size, groups, integer_normals }| {
                let values = values.as_slice()?.to_vec();
                PyResult::Ok(Planes { values, split_size, groups, integer_normals })
            })
            .transpose()?;
        let inner = Problem {
            n: ranks.n,
            p: ranks.p,
            n_classes: costs.shape()[0],
            ranks: ranks.ranks.clone(),
            n_ranks,
            labels: labels.as_slice()?.to_vec(),
            weights: weights.as_slice()?.to_vec(),
            costs: costs.as_slice()?.to_vec(),
            penalty,
            depth,
            leaf_size,
            sensor_of_feature,
            sensor_cost,
            sensor_limit,
            allowed,
            planes,
        };
        inner.validate().map_err(|error| PyValueError::new_err(error.0))?;
        Ok(Self { inner })
    }
}

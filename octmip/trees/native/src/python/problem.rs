//! Problems of the solvers as Python objects: arrays in, checked once.
//!
//! Every solver is called with the same arguments in the same order:
//!
//! ```text
//! problem, incumbent, limits, n_threads, seed, off, progress, then its own by name
//! ```
//!
//! each left out where a solver has no use for it. `limits` is `octmip.trees.solution.Limits`, `off` names the prunes
//! that are switched off, `progress` takes `(seconds, objective, bound, n_nodes)`. A problem is made by
//! names. Python objects are read by their attributes and answers are classes; what goes both ways is a dict.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::problem::{Planes, Problem};
use crate::python::ranks::PyRankTable;
use crate::sequential::SequentialProblem;

/// Data of hyperplane splits: a dict with these names, see `Planes`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct PlaneArguments<'py> {
    values: PyReadonlyArray2<'py, f64>,
    split_size: usize,
    groups: Option<Vec<Vec<u32>>>,
    integer_normals: Option<i64>,
}

/// `crate::problem::Problem` as a Python object.
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

/// `crate::sequential::SequentialProblem` as a Python object.
#[pyclass(name = "SequentialProblem", frozen)]
pub(crate) struct PySequentialProblem {
    /// The problem.
    pub(crate) inner: SequentialProblem,
}

#[pymethods]
impl PySequentialProblem {
    #[new]
    #[pyo3(signature = (*, ranks, paid, frequency, delay_costs, penalty, depth, leaf_size, sensor_of_feature, allowed,
        most_readings, sensor_cost, group_of_sensor, setup_costs, read, multiplier, cap))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        ranks: PyReadonlyArray2<'_, u32>,
        paid: PyReadonlyArray2<'_, f64>,
        frequency: PyReadonlyArray1<'_, f64>,
        delay_costs: PyReadonlyArray1<'_, f64>,
        penalty: f64,
        depth: usize,
        leaf_size: usize,
        sensor_of_feature: Vec<usize>,
        allowed: Vec<bool>,
        most_readings: Vec<usize>,
        sensor_cost: Vec<f64>,
        group_of_sensor: Vec<usize>,
        setup_costs: Vec<f64>,
        read: Vec<usize>,
        multiplier: f64,
        cap: Option<f64>,
    ) -> PyResult<Self> {
        let inner = SequentialProblem {
            n: ranks.shape()[1],
            p: ranks.shape()[0],
            n_classes: paid.shape()[1],
            ranks: ranks.as_slice()?.to_vec(),
            paid: paid.as_slice()?.to_vec(),
            frequency: frequency.as_slice()?.to_vec(),
            delay_costs: delay_costs.as_slice()?.to_vec(),
            penalty,
            depth,
            leaf_size,
            sensor_of_feature,
            sensor_cost,
            group_of_sensor,
            setup_costs,
            most_readings,
            allowed,
            read,
            multiplier,
            cap,
        };
        inner.validate().map_err(PyValueError::new_err)?;
        Ok(Self { inner })
    }
}

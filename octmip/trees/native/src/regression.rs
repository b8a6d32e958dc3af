//! `octmip.trees._native.regression`: trees of least squared or sloped error.

use std::sync::atomic::Ordering;

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use octmip_check::regression::check;
use octmip_check::regression::grid::{Samples, Scale};
use octmip_check::regression::question::RegressionQuestion;
use octmip_check::regression::slopes::Slopes;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::check::Verdict;
use crate::rows::rows_from_tree;
use crate::run::{FoundBelow, LimitValues, limits, stop_name, supervised, written};
use octmip_regression::{Question, prove, solve};

/// `octmip.trees.question.losses.exact_sums.Slopes` by its attributes.
#[derive(FromPyObject)]
pub(crate) struct SlopeValues {
    /// Price of a unit above the prediction.
    up: i64,
    /// Price of a unit below it.
    down: i64,
    /// What both are divided by.
    over: i64,
}

/// The best tree that costs less than `room` (None: any), and a bound of all. Without slopes the error is squared.
#[pyfunction]
#[pyo3(signature = (room, limit_values, n_threads, progress=None, *, ranks, n_ranks, targets, weights, squares, grain,
    slopes, penalty, depth, leaf_size, allowed))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn regression(
    py: Python<'_>,
    room: Option<f64>,
    limit_values: LimitValues,
    n_threads: usize,
    progress: Option<Py<PyAny>>,
    ranks: PyReadonlyArray2<'_, u32>,
    n_ranks: Vec<u32>,
    targets: PyReadonlyArray1<'_, f64>,
    weights: PyReadonlyArray1<'_, f64>,
    squares: PyReadonlyArray1<'_, f64>,
    grain: f64,
    slopes: Option<SlopeValues>,
    penalty: f64,
    depth: usize,
    leaf_size: usize,
    allowed: Vec<bool>,
) -> PyResult<FoundBelow> {
    let question = Question {
        n: ranks.shape()[1],
        p: ranks.shape()[0],
        ranks: ranks.as_slice()?.to_vec(),
        n_ranks,
        targets: targets.as_slice()?.to_vec(),
        weights: weights.as_slice()?.to_vec(),
        squares: squares.as_slice()?.to_vec(),
        grain,
        slopes: slopes.map(|each| octmip_regression::Slopes { up: each.up as f64, down: each.down as f64 }),
        penalty,
        depth,
        leaf_size,
        allowed,
    };
    if let Some(complaint) = question.complaint() {
        return Err(PyValueError::new_err(complaint));
    }
    let found = supervised(py, progress.as_ref(), |keep_going| {
        solve(&question, room, n_threads, limits(limit_values), keep_going)
    })?;
    let rows = found.tree.as_ref().map(rows_from_tree);
    Ok(FoundBelow { rows, bound: found.bound, stop: stop_name(found.stop), n_nodes: found.n_cuts })
}

/// `octmip.trees.evidence.regression_log.LogScale` by its attributes: exponents of the grid of a log.
#[derive(FromPyObject)]
struct ScaleValues {
    weight: i64,
    target: i64,
    cost: u32,
    reach: i64,
}

/// What a log proves of numbers.
#[pyclass(frozen, get_all, module = "octmip.trees._native")]
pub(crate) struct ProvenBelow {
    /// The whole number that it claims.
    claim: i64,
    /// Its lines.
    body: String,
    /// The bound that it proves.
    bound: f64,
}

/// `octmip_check::regression::question::RegressionQuestion` as a Python object.
#[pyclass(name = "RegressionQuestion", frozen)]
pub struct PyRegressionQuestion {
    inner: RegressionQuestion,
}

#[pymethods]
impl PyRegressionQuestion {
    #[new]
    #[pyo3(signature = (*, features, targets, weights, slopes, depth, leaf_size, leaf_penalty, sensor_of_feature,
        sensor_cost, sensor_limit))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        features: PyReadonlyArray2<'_, f64>,
        targets: PyReadonlyArray1<'_, f64>,
        weights: PyReadonlyArray1<'_, f64>,
        slopes: Option<SlopeValues>,
        depth: usize,
        leaf_size: usize,
        leaf_penalty: f64,
        sensor_of_feature: Vec<u32>,
        sensor_cost: Vec<f64>,
        sensor_limit: f64,
    ) -> PyResult<Self> {
        let question = RegressionQuestion {
            n: features.shape()[0],
            p: features.shape()[1],
            features: features.as_slice()?.to_vec(),
            targets: targets.as_slice()?.to_vec(),
            weights: weights.as_slice()?.to_vec(),
            slopes: slopes.map(|SlopeValues { up, down, over }| Slopes { up, down, over }),
            depth,
            leaf_size,
            leaf_penalty,
            sensor_of_feature,
            sensor_cost,
            sensor_limit,
        };
        Ok(Self { inner: question.validated().map_err(PyValueError::new_err)? })
    }

    /// The error by its name, the SHA-256 of samples, targets and weights, and that of all the rest.
    fn identity(&self) -> (String, String, String) {
        (Slopes::named(self.inner.slopes), self.inner.data_digest(), self.inner.question_digest())
    }

    /// Check a log.
    fn check(&self, py: Python<'_>, log: &str) -> Verdict {
        py.detach(|| check(&self.inner, log)).into()
    }

    /// Claim, body and bound of a log on the grid of these exponents; the claim is `wanted` or, where a tree costs
    /// less, the cost of the best one. None if it was stopped.
    fn prove(&self, py: Python<'_>, scale: ScaleValues, wanted: i64) -> PyResult<Option<ProvenBelow>> {
        let ScaleValues { weight, target, cost, reach } = scale;
        let scale = Scale { weight, target, cost, reach };
        let samples = Samples::on_grid(&self.inner, scale).map_err(PyValueError::new_err)?;
        let found = written(py, wanted, |supervision| {
            let flag = supervision.flag();
            prove(&samples, wanted, &|| flag.load(Ordering::Relaxed))
        })?;
        Ok(found.map(|(claim, body)| ProvenBelow { claim, body, bound: samples.value(claim) }))
    }
}

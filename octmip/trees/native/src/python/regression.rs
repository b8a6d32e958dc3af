//! `octmip.trees._native.regression`: trees of least squared or sloped error.

use std::sync::atomic::Ordering;

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use octmip_check::regression::check;
use octmip_check::regression::grid::{Samples, Scale};
use octmip_check::regression::question::RegressionQuestion;
use octmip_check::regression::slopes::Slopes;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::python::rows::{NodeRow, rows_from_tree};
use crate::python::run::{LimitValues, limits, stop_name, supervised, written};
use crate::regression::{Question, prove, solve};

/// Targets, weights, rounded squares of each sample, the grid of the squares.
type Targets<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>, f64);
/// Slopes above and below a prediction (None: squared), price of a split, depth, leaf size, features that may be used.
type Shape = (Option<(f64, f64)>, f64, usize, usize, Vec<bool>);
/// Node rows (None without a tree below the room), bound, stop, evaluated cuts.
type Found = (Option<Vec<NodeRow>>, f64, &'static str, u64);

/// The best tree that costs less than `room` (None: any), and a bound of all trees.
#[pyfunction]
#[pyo3(signature = (ranks, n_ranks, targets, shape, room, n_threads, limit_values, progress=None))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn regression(
    py: Python<'_>,
    ranks: PyReadonlyArray2<'_, u32>,
    n_ranks: Vec<u32>,
    targets: Targets<'_>,
    shape: Shape,
    room: Option<f64>,
    n_threads: usize,
    limit_values: LimitValues,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found> {
    let (slopes, penalty, depth, leaf_size, allowed) = shape;
    let question = Question {
        n: ranks.shape()[1],
        p: ranks.shape()[0],
        ranks: ranks.as_slice()?.to_vec(),
        n_ranks,
        targets: targets.0.as_slice()?.to_vec(),
        weights: targets.1.as_slice()?.to_vec(),
        squares: targets.2.as_slice()?.to_vec(),
        grain: targets.3,
        slopes: slopes.map(|(up, down)| crate::regression::Slopes { up, down }),
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
    Ok((found.tree.as_ref().map(rows_from_tree), found.bound, stop_name(found.stop), found.n_cuts))
}

/// Slopes and what they are divided by (None: squared), depth, least samples of a leaf, price of a split.
type Asked = (Option<(i64, i64, i64)>, usize, usize, f64);
/// Sensor of each feature, cost of each sensor, budget.
type Sensors = (Vec<u32>, Vec<f64>, f64);
/// The bound, the lines of the log and the line of its claim; or the line that is refused, and the reason.
type Verdict = (Option<(f64, usize, usize)>, Option<(usize, String)>);

/// `octmip_check::regression::question::RegressionQuestion` as a Python object.
#[pyclass(name = "RegressionQuestion", frozen)]
pub struct PyRegressionQuestion {
    inner: RegressionQuestion,
}

#[pymethods]
impl PyRegressionQuestion {
    #[new]
    fn new(
        features: PyReadonlyArray2<'_, f64>,
        targets: PyReadonlyArray1<'_, f64>,
        weights: PyReadonlyArray1<'_, f64>,
        asked: Asked,
        sensors: Sensors,
    ) -> PyResult<Self> {
        let (slopes, depth, leaf_size, leaf_penalty) = asked;
        let (sensor_of_feature, sensor_cost, sensor_limit) = sensors;
        let question = RegressionQuestion {
            n: features.shape()[0],
            p: features.shape()[1],
            features: features.as_slice()?.to_vec(),
            targets: targets.as_slice()?.to_vec(),
            weights: weights.as_slice()?.to_vec(),
            slopes: slopes.map(|(up, down, over)| Slopes { up, down, over }),
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
        match py.detach(|| check(&self.inner, log)) {
            Ok(report) => (Some((report.bound, report.n_lines, report.claim_line)), None),
            Err(refusal) => (None, Some((refusal.line, refusal.reason))),
        }
    }

    /// Claim, body and bound of a log on the grid of these exponents; the claim is `wanted` or, where a tree costs
    /// less, the cost of the best one. None if it was stopped.
    fn prove(&self, py: Python<'_>, scale: (i64, i64, u32, i64), wanted: i64) -> PyResult<Option<(i64, String, f64)>> {
        let scale = Scale { weight: scale.0, target: scale.1, cost: scale.2, reach: scale.3 };
        let samples = Samples::on_grid(&self.inner, scale).map_err(PyValueError::new_err)?;
        let found = written(py, wanted, |supervision| {
            let flag = supervision.flag();
            prove(&samples, wanted, &|| flag.load(Ordering::Relaxed))
        })?;
        Ok(found.map(|(claim, body)| (claim, body, samples.value(claim))))
    }
}

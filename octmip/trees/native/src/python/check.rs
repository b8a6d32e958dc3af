//! `octmip.trees._native.Question`: what is asked, in float64 as given, for the checker of proof logs.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use octmip_check::check;
use octmip_check::question::Question;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Depth, whether splits are hyperplanes, most features in one split, least samples of a leaf, its penalty.
type Limits = (usize, bool, usize, usize, f64);
/// Sensor of each feature, cost of each sensor, budget.
type Sensors = (Vec<u32>, Vec<f64>, f64);
/// The bound, the lines of the log and the line of its claim; or the line that is refused, and the reason.
type Verdict = (Option<(f64, usize, usize)>, Option<(usize, String)>);

/// `octmip_check::question::Question` as a Python object.
#[pyclass(name = "Question", frozen)]
pub struct PyQuestion {
    inner: Question,
}

#[pymethods]
impl PyQuestion {
    #[new]
    fn new(
        features: PyReadonlyArray2<'_, f64>,
        labels: PyReadonlyArray1<'_, u32>,
        weights: PyReadonlyArray1<'_, f64>,
        costs: PyReadonlyArray2<'_, f64>,
        limits: Limits,
        sensors: Sensors,
        allowed_splits: Option<Vec<Vec<u32>>>,
    ) -> PyResult<Self> {
        let (depth, is_hyperplane, split_size, leaf_size, leaf_penalty) = limits;
        let (sensor_of_feature, sensor_cost, sensor_limit) = sensors;
        let question = Question {
            n: features.shape()[0],
            p: features.shape()[1],
            n_classes: costs.shape()[0],
            features: features.as_slice()?.to_vec(),
            labels: labels.as_slice()?.to_vec(),
            weights: weights.as_slice()?.to_vec(),
            costs: costs.as_slice()?.to_vec(),
            depth,
            is_hyperplane,
            split_size,
            leaf_size,
            leaf_penalty,
            sensor_of_feature,
            sensor_cost,
            sensor_limit,
            allowed_splits,
        };
        Ok(Self { inner: question.validated().map_err(PyValueError::new_err)? })
    }

    /// The SHA-256 of samples, labels and weights, and that of all the rest.
    fn digests(&self) -> (String, String) {
        (self.inner.data_digest(), self.inner.question_digest())
    }

    /// Check a log.
    fn check(&self, py: Python<'_>, log: &str, n_threads: usize) -> Verdict {
        match py.detach(|| check(&self.inner, log, n_threads)) {
            Ok(report) => (Some((report.bound, report.n_lines, report.claim_line)), None),
            Err(refusal) => (None, Some((refusal.line, refusal.reason))),
        }
    }
}

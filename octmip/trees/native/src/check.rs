//! `octmip.trees._native.Question`: what is asked, in float64 as given, for the checker of proof logs.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use octmip_check::question::Question;
use octmip_check::{Refusal, Report, check};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// What an accepted log proves.
#[pyclass(frozen, get_all, module = "octmip.trees._native")]
pub struct Accepted {
    bound: f64,
    /// Lines of the log.
    n_lines: usize,
    /// The line of its claim.
    claim_line: usize,
}

/// Where and why a log is refused.
#[pyclass(frozen, get_all, module = "octmip.trees._native")]
pub struct Refused {
    line: usize,
    reason: String,
}

/// One of the two.
#[derive(IntoPyObject)]
pub enum Verdict {
    /// The log holds.
    Accepted(Accepted),
    /// It does not.
    Refused(Refused),
}

impl From<Result<Report, Refusal>> for Verdict {
    fn from(found: Result<Report, Refusal>) -> Self {
        match found {
            Ok(Report { bound, n_lines, claim_line, .. }) => Self::Accepted(Accepted { bound, n_lines, claim_line }),
            Err(Refusal { line, reason }) => Self::Refused(Refused { line, reason }),
        }
    }
}

/// `octmip_check::question::Question` as a Python object.
#[pyclass(name = "Question", frozen)]
pub struct PyQuestion {
    inner: Question,
}

#[pymethods]
impl PyQuestion {
    #[new]
    #[pyo3(signature = (*, features, labels, weights, costs, depth, is_hyperplane, split_size, leaf_size, leaf_penalty,
        sensor_of_feature, sensor_cost, sensor_limit, allowed_splits))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        features: PyReadonlyArray2<'_, f64>,
        labels: PyReadonlyArray1<'_, u32>,
        weights: PyReadonlyArray1<'_, f64>,
        costs: PyReadonlyArray2<'_, f64>,
        depth: usize,
        is_hyperplane: bool,
        split_size: usize,
        leaf_size: usize,
        leaf_penalty: f64,
        sensor_of_feature: Vec<u32>,
        sensor_cost: Vec<f64>,
        sensor_limit: f64,
        allowed_splits: Option<Vec<Vec<u32>>>,
    ) -> PyResult<Self> {
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
        py.detach(|| check(&self.inner, log, n_threads)).into()
    }
}

//! The two-feature core's functions.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::python::problem::PyProblem;
use crate::python::run::{Found, LimitValues, found, limits, supervised, switches, written};
use crate::two_feature::options::Options;
use crate::two_feature::switches::Switches;
use crate::two_feature::{proof, solve};

/// The best tree whose splits have up to two features, and a bound. `incumbent` is the cost of a feasible tree: trees of
/// this cost and more are of no interest.
#[allow(clippy::too_many_arguments)]
#[pyfunction]
#[pyo3(signature = (problem, incumbent, limit_values, n_threads, seed=0, off=Vec::new(), progress=None, *,
    whole_coefficients=None))]
fn two_feature_branch_and_bound(
    py: Python<'_>,
    problem: &PyProblem,
    incumbent: Option<i64>,
    limit_values: LimitValues,
    n_threads: usize,
    seed: u64,
    off: Vec<String>,
    progress: Option<Py<PyAny>>,
    whole_coefficients: Option<i64>,
) -> PyResult<Found> {
    let switches = switches(Switches::without(&off))?;
    let limits = limits(limit_values);
    let options = Options { limits, n_threads, known: incumbent, seed, switches, whole_coefficients };
    let outcome = supervised(py, progress.as_ref(), |keep_going| solve(&problem.inner, &options, keep_going))?;
    let outcome =
        outcome.ok_or_else(|| PyValueError::new_err(format!("depth is {}; expected 1 or 2", problem.inner.depth)))?;
    Ok(found(&outcome))
}

/// Names of all prunes and bounds of the two-feature core.
#[pyfunction]
fn two_feature_prunes() -> Vec<&'static str> {
    Switches::NAMES.to_vec()
}

/// The body of a log that proves `claim` of all two-feature trees; None when it was stopped, or the claim is not
/// shown.
#[pyfunction]
fn prove_two_feature(py: Python<'_>, problem: &PyProblem, claim: i64, n_threads: usize) -> PyResult<Option<String>> {
    written(py, claim, |supervision| proof::write(&problem.inner, claim, n_threads, supervision.flag()))
}

/// Add the functions to the native module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(two_feature_branch_and_bound, module)?)?;
    module.add_function(wrap_pyfunction!(two_feature_prunes, module)?)?;
    module.add_function(wrap_pyfunction!(prove_two_feature, module)?)
}

//! `octmip._native.two_feature_branch_and_bound`: problem and limits in; a node table, objective, bound, counters out.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::control::Limits;
use crate::python::{NodeRow, PyProblem, keep_going, limits, rows_from_tree, stop_name};
use crate::two_feature::options::Options;
use crate::two_feature::switches::Switches;
use crate::two_feature::watch::Watch;
use crate::two_feature::{proof, solve};

/// Node table, objective, bound, stop, nodes searched.
type Found = (Vec<NodeRow>, i64, i64, &'static str, u64);

/// Find an optimal tree with splits over up to two features.
#[allow(clippy::too_many_arguments)]
#[pyfunction(name = "two_feature_branch_and_bound")]
#[pyo3(signature = (problem, n_threads, limit_values, known=None, seed=0, off=Vec::new(), preferred=None,
    progress=None))]
pub fn py_two_feature_branch_and_bound(
    py: Python<'_>,
    problem: &PyProblem,
    n_threads: usize,
    limit_values: (f64, f64, f64, f64),
    known: Option<i64>,
    seed: u64,
    off: Vec<String>,
    preferred: Option<i64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found> {
    let mut switches = Switches::default();
    for name in &off {
        *switches.by_name(name).ok_or_else(|| PyValueError::new_err(format!("no prune is called {name}")))? = false;
    }
    let options =
        Options { limits: limits(limit_values), n_threads, known, seed, switches, whole_coefficients: preferred };
    let mut error = None;
    let outcome = py.detach(|| {
        let mut go_on = keep_going(progress.as_ref(), &mut error);
        solve(&problem.inner, &options, &mut go_on)
    });
    if let Some(raised) = error {
        return Err(raised);
    }
    let outcome =
        outcome.ok_or_else(|| PyValueError::new_err(format!("depth is {}; expected 1 or 2", problem.inner.depth)))?;
    Ok((rows_from_tree(&outcome.tree), outcome.objective, outcome.bound, stop_name(outcome.stop), outcome.n_nodes))
}

/// Names of all prunes and bounds of the two-feature core.
#[pyfunction]
pub fn two_feature_prunes() -> Vec<&'static str> {
    Switches::NAMES.to_vec()
}

/// The body of a log that proves `claim` of all two-feature trees; None when it was stopped, or the claim is not shown.
#[pyfunction]
pub fn prove_two_feature(
    py: Python<'_>,
    problem: &PyProblem,
    claim: i64,
    n_threads: usize,
) -> PyResult<Option<String>> {
    let mut error = None;
    let watch = Watch::new(Limits::default());
    let body = py.detach(|| {
        let mut go_on = keep_going(None, &mut error);
        watch.over(&mut go_on, claim, || proof::write(&problem.inner, claim, n_threads, watch.stop()))
    });
    error.map_or(Ok(body), Err)
}

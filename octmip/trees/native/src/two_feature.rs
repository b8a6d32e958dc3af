//! The two-feature core's functions.

use std::time::Instant;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::problem::PyProblem;
use crate::rows::{Incumbent, known_tree, rows_from_tree};
use crate::run::{Found, LimitValues, found, limits, supervised, switches, written};
use octmip_two_feature::{Options, Saved, Saver, Switches, solve, write_proof};

/// The state of a search: a dict to Python, `octmip.trees.methods.checkpoint.search_state.TwoFeatureState` back.
#[derive(FromPyObject, IntoPyObject)]
struct StateRow {
    state: Py<PyBytes>,
    /// Most slope intervals of a dual plane.
    n_intervals: usize,
    /// The best tree's cost and rows.
    best: Incumbent,
    bound: i64,
    n_nodes: u64,
}

/// Seconds between two times that the state is handed out, who takes it, the state of an earlier search.
type Checkpoint = (f64, Py<PyAny>, Option<StateRow>);

/// The best tree whose splits have up to two features, and a bound. `incumbent` is the cost of a feasible tree:
/// trees of this cost and more are of no interest.
#[allow(clippy::too_many_arguments)]
#[pyfunction]
#[pyo3(signature = (problem, incumbent, limit_values, n_threads, seed=0, off=Vec::new(), progress=None, *,
    whole_coefficients=None, checkpoint=None))]
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
    checkpoint: Option<Checkpoint>,
) -> PyResult<Found> {
    let switches = switches(Switches::without(&off))?;
    let limits = limits(limit_values);
    let options = Options { limits, n_threads, known: incumbent, seed, switches, whole_coefficients };
    if !(1..=3).contains(&problem.inner.depth) {
        return Err(PyValueError::new_err(format!("depth is {}; expected 1 to 3", problem.inner.depth)));
    }
    let (every, taker, row) = checkpoint.map_or((0.0, None, None), |(every, taker, row)| (every, Some(taker), row));
    let kept = row.map(|row| saved_from_row(py, row)).transpose()?;
    let mut unsaved = None;
    let outcome = supervised(py, progress.as_ref(), |keep_going| {
        let mut save = |saved: &Saved| hand_out(taker.as_ref(), saved, &mut unsaved);
        let saver = taker.is_some().then_some(Saver { every, saved: Instant::now(), pause: 0.0, save: &mut save });
        solve(&problem.inner, &options, (kept.as_ref(), saver), keep_going)
    })?;
    let outcome = outcome.map_err(|reason| PyValueError::new_err(format!("known: {reason}")))?;
    unsaved.map_or_else(|| Ok(found(&outcome)), Err)
}

/// Give Python the state; what it raises stops the search and is kept.
fn hand_out(taker: Option<&Py<PyAny>>, saved: &Saved, unsaved: &mut Option<PyErr>) -> bool {
    let Some(taker) = taker else { return true };
    let best = saved.best.as_ref().map(|(tree, cost)| (*cost, rows_from_tree(tree)));
    let taken = Python::attach(|py| {
        let state = PyBytes::new(py, &saved.state).unbind();
        let Saved { n_intervals, bound, n_nodes, .. } = *saved;
        let row = StateRow { state, n_intervals, best, bound, n_nodes };
        taker.call1(py, (row,)).map(|_| ())
    });
    taken.map_err(|raised| *unsaved = Some(raised)).is_ok()
}

fn saved_from_row(py: Python<'_>, row: StateRow) -> PyResult<Saved> {
    let StateRow { state, n_intervals, best, bound, n_nodes } = row;
    let best = known_tree(best)?.map(|(cost, tree)| (tree, cost));
    Ok(Saved { state: state.as_bytes(py).to_vec(), n_intervals, best, bound, n_nodes })
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
    written(py, claim, |supervision| write_proof(&problem.inner, claim, n_threads, supervision.flag()))
}

/// Add the functions to the native module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(two_feature_branch_and_bound, module)?)?;
    module.add_function(wrap_pyfunction!(two_feature_prunes, module)?)?;
    module.add_function(wrap_pyfunction!(prove_two_feature, module)?)
}

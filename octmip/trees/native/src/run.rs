//! A solver's run at the Python border: limits, progress, Ctrl-C, switches and what is returned.

use std::time::{Duration, Instant};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::rows::{NodeRow, rows_from_tree};
use octmip_frame::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use octmip_frame::supervise::Supervision;

/// `octmip.trees.answer.solution.Limits` by its attributes; to Python it goes as a dict of them.
#[derive(Clone, Copy, FromPyObject, IntoPyObject)]
pub(crate) struct LimitValues {
    /// Wall time [s].
    pub(crate) seconds: f64,
    /// Relative gap that is good enough.
    pub(crate) gap: f64,
    /// Search nodes.
    pub(crate) nodes: f64,
    /// Bytes of the solver's tables.
    pub(crate) memory: f64,
}

/// The best tree of a search, and a bound of all.
#[pyclass(frozen, get_all, module = "octmip.trees._native")]
pub(crate) struct Found {
    /// Its node table.
    rows: Vec<NodeRow>,
    /// Its cost.
    objective: i64,
    /// What no tree costs less than.
    bound: i64,
    /// Why the search ended.
    stop: &'static str,
    /// Nodes, or evaluated cuts.
    n_nodes: u64,
}

/// The best tree below a cost in float64, if there is one, and a bound of all.
#[pyclass(frozen, get_all, module = "octmip.trees._native")]
pub(crate) struct FoundBelow {
    /// Its node table.
    pub(crate) rows: Option<Vec<NodeRow>>,
    /// What no tree costs less than.
    pub(crate) bound: f64,
    /// Why the search ended.
    pub(crate) stop: &'static str,
    /// Evaluated cuts.
    pub(crate) n_nodes: u64,
}

/// Limits as the solvers take them.
pub(crate) fn limits(LimitValues { seconds, gap, nodes, memory }: LimitValues) -> Limits {
    Limits { seconds, gap, nodes, memory }
}

/// The name that `octmip.trees.answer.solution.Stop` gives a stop.
pub(crate) fn stop_name(stop: Stop) -> &'static str {
    match stop {
        Stop::Optimal => "optimal",
        Stop::Finished => "finished",
        Stop::Gap => "gap",
        Stop::Time => "time",
        Stop::Nodes => "nodes",
        Stop::Memory => "memory",
        Stop::Interrupted => "interrupted",
    }
}

/// Switches from a solver's `without`, its error the name that it does not know.
pub(crate) fn switches<T>(found: Result<T, String>) -> PyResult<T> {
    found.map_err(|name| PyValueError::new_err(format!("no prune is called {name}")))
}

/// The result of a solver as Python gets it.
pub(crate) fn found(outcome: &Outcome) -> Found {
    Found {
        rows: rows_from_tree(&outcome.tree),
        objective: outcome.objective,
        bound: outcome.bound,
        stop: stop_name(outcome.stop),
        n_nodes: outcome.n_nodes,
    }
}

/// Run a solver without the interpreter lock; what `progress` raises stops it and is raised here.
pub(crate) fn supervised<T: Send>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    solve: impl FnOnce(KeepGoing<'_>) -> T + Send,
) -> PyResult<T> {
    let mut error = None;
    let result = py.detach(|| solve(&mut keep_going(progress, &mut error)));
    error.map_or(Ok(result), Err)
}

/// The body of a log that proves `claim`; Ctrl-C stops whoever writes it.
pub(crate) fn written<T: Send>(
    py: Python<'_>,
    claim: i64,
    write: impl FnOnce(&Supervision) -> Option<T> + Send,
) -> PyResult<Option<T>> {
    let supervision = Supervision::new(Limits::default());
    let state = Progress { seconds: 0.0, objective: claim, bound: claim, n_nodes: 0 };
    supervised(py, None, |keep_going| {
        supervision.run(|| write(&supervision), || supervision.poll(&mut *keep_going, state))
    })
}

/// Report progress to Python and look for Ctrl-C, at most every 50 ms: a solver may ask as often as it likes.
///
/// `progress` is None or a callable of `(seconds, objective, bound, n_nodes)`. What it raises, KeyboardInterrupt from
/// Ctrl-C apart, stops the solver and is kept in `error` for the caller to raise.
fn keep_going<'a>(progress: Option<&'a Py<PyAny>>, error: &'a mut Option<PyErr>) -> impl FnMut(Progress) -> bool + 'a {
    let mut last = Instant::now();
    move |state| {
        if last.elapsed() < Duration::from_millis(50) {
            return true;
        }
        last = Instant::now();
        Python::attach(|py| {
            let result = py.check_signals().and_then(|()| match progress {
                Some(call) => call.call1(py, (state.seconds, state.objective, state.bound, state.n_nodes)).map(|_| ()),
                None => Ok(()),
            });
            match result {
                Ok(()) => true,
                Err(raised) => {
                    if !raised.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py) {
                        *error = Some(raised);
                    }
                    false
                }
            }
        })
    }
}

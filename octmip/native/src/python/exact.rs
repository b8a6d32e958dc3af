//! The exact core's functions.

use std::time::Duration;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::control::Progress;
use crate::exact::Switches;
use crate::exact::effort::Control;
use crate::exact::memory;
use crate::exact::proof::write;
use crate::exact::root::{Options, solve};
use crate::python::{NodeRow, PyProblem, keep_going, limits, rows_from_tree, stop_name, tree_from_rows};

/// Node rows, objective, bound, stop, evaluated cuts.
type Found = (Vec<NodeRow>, i64, i64, &'static str, u64);

/// The best tree and a bound. `incumbent` is `(objective, rows)` of a feasible tree; `off` names prunes to do without.
#[pyfunction]
#[pyo3(signature = (problem, limits_, n_threads, incumbent=None, off=Vec::new(), progress=None))]
fn branch_and_bound(
    py: Python<'_>,
    problem: &PyProblem,
    limits_: (f64, f64, f64, f64),
    n_threads: usize,
    incumbent: Option<(i64, Vec<NodeRow>)>,
    off: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found> {
    let incumbent =
        incumbent.map(|(objective, rows)| Ok::<_, PyErr>((objective, tree_from_rows(rows)?))).transpose()?;
    let options = Options { limits: limits(limits_), n_threads, incumbent, switches: switches(&off)? };
    let mut error = None;
    let outcome = py.detach(|| {
        let mut going = keep_going(progress.as_ref(), &mut error);
        solve(&problem.inner, &options, &mut going)
    });
    match error {
        Some(error) => Err(error),
        None => Ok((
            rows_from_tree(&outcome.tree),
            outcome.objective,
            outcome.bound,
            stop_name(outcome.stop),
            outcome.n_nodes,
        )),
    }
}

/// The body of a log that proves `claim`; None when it was stopped, or the claim does not hold.
#[pyfunction]
#[pyo3(signature = (problem, claim))]
fn prove(py: Python<'_>, problem: &PyProblem, claim: i64) -> PyResult<Option<String>> {
    let mut error = None;
    let control = Control::new();
    let body = py.detach(|| {
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| write(&problem.inner, claim, Switches::default(), &control));
            let mut going = keep_going(None, &mut error);
            while !worker.is_finished() {
                std::thread::sleep(Duration::from_millis(1));
                if !going(Progress { seconds: 0.0, objective: claim, bound: claim, n_nodes: 0 }) {
                    control.stop();
                }
            }
            worker.join().ok().flatten()
        })
    });
    match error {
        Some(error) => Err(error),
        None => Ok(body),
    }
}

fn switches(off: &[String]) -> PyResult<Switches> {
    let mut switches = Switches::default();
    for name in off {
        let switch =
            switches.by_name(name).ok_or_else(|| PyValueError::new_err(format!("no prune is called {name}")))?;
        *switch = false;
    }
    Ok(switches)
}

/// Bytes that the tables of a search may take, its queues left out.
#[pyfunction]
fn exact_bytes(problem: &PyProblem, n_threads: usize) -> f64 {
    memory::bytes(&problem.inner, n_threads, &Switches::default())
}

/// Names of all prunes.
#[pyfunction]
fn prunes() -> Vec<&'static str> {
    Switches::NAMES.to_vec()
}

/// Add the functions to the native module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(branch_and_bound, module)?)?;
    module.add_function(wrap_pyfunction!(prove, module)?)?;
    module.add_function(wrap_pyfunction!(exact_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(prunes, module)?)
}

//! The exact core's functions.

use std::time::Duration;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::control::Progress;
use crate::exact::Switches;
use crate::exact::answer::Reached;
use crate::exact::effort::Control;
use crate::exact::known::{Held, Known, Saver, Solved};
use crate::exact::memory;
use crate::exact::proof::write;
use crate::exact::root::{Options, base, go_on};
use crate::python::{NodeRow, PyProblem, keep_going, limits, rows_from_tree, stop_name, tree_from_rows};

/// Node rows, objective, bound, stop, evaluated cuts.
type Found = (Vec<NodeRow>, i64, i64, &'static str, u64);

/// What is known: level, bound of one level fewer, best cost and cut of each feature one level lower and at this level,
/// solved cuts (feature, samples left of it, bounds of both sides), bound, objective and rows of the best tree, open sets
/// of sensors (held, banned), evaluated cuts. Costs are above the base, the objective of the tree is not.
type KnownRow = (
    usize,
    i64,
    Vec<(i64, usize)>,
    Vec<(i64, usize)>,
    Vec<(usize, usize, i64, i64)>,
    i64,
    (i64, Vec<NodeRow>),
    Option<Vec<Held>>,
    u64,
);

/// The best tree and a bound. `incumbent` is `(objective, rows)` of a feasible tree; `off` names prunes to do without;
/// `checkpoint` says how often to hand out what is known, to whom, and what an earlier search handed out last.
#[pyfunction]
#[pyo3(signature = (problem, limits_, n_threads, incumbent=None, off=Vec::new(), progress=None, checkpoint=None))]
#[allow(clippy::too_many_arguments)]
fn branch_and_bound(
    py: Python<'_>,
    problem: &PyProblem,
    limits_: (f64, f64, f64, f64),
    n_threads: usize,
    incumbent: Option<(i64, Vec<NodeRow>)>,
    off: Vec<String>,
    progress: Option<Py<PyAny>>,
    checkpoint: Option<(f64, Py<PyAny>, Option<KnownRow>)>,
) -> PyResult<Found> {
    let incumbent =
        incumbent.map(|(objective, rows)| Ok::<_, PyErr>((objective, tree_from_rows(rows)?))).transpose()?;
    let options = Options { limits: limits(limits_), n_threads, incumbent, switches: switches(&off)? };
    let base = base(&problem.inner);
    let (mut error, mut unsaved) = (None, None);
    let (every, taker, row) = checkpoint.map_or((0.0, None, None), |(every, taker, row)| (every, Some(taker), row));
    let known = row.map(|row| known_from_row(row, base)).transpose()?;
    let outcome = py.detach(|| {
        let mut going = keep_going(progress.as_ref(), &mut error);
        let mut save = |known: &Known| hand_out(taker.as_ref(), known, base, &mut unsaved);
        let saver = taker.is_some().then_some(Saver { every, save: &mut save });
        go_on(&problem.inner, &options, known, saver, &mut going)
    });
    if let Some(error) = error.or(unsaved) {
        return Err(error);
    }
    let outcome = outcome.map_err(|reason| PyValueError::new_err(format!("known: {reason}")))?;
    let rows = rows_from_tree(&outcome.tree);
    Ok((rows, outcome.objective, outcome.bound, stop_name(outcome.stop), outcome.n_nodes))
}

/// Give Python what is known; what it raises stops the search and is kept.
fn hand_out(taker: Option<&Py<PyAny>>, known: &Known, base: i64, unsaved: &mut Option<PyErr>) -> bool {
    let Some(taker) = taker else { return true };
    let pairs = |reached: &[Reached]| -> Vec<_> { reached.iter().map(|r| (r.cost, r.position)).collect() };
    let cut = |cut: &Solved| (cut.feature, cut.position, cut.bounds[0], cut.bounds[1]);
    let row: KnownRow = (
        known.level,
        known.whole,
        pairs(&known.order),
        pairs(&known.attained),
        known.cuts.iter().map(cut).collect(),
        known.bound,
        (known.best.0 + base, rows_from_tree(&known.best.1)),
        known.sets.clone(),
        known.n_nodes,
    );
    let taken = Python::attach(|py| taker.call1(py, (row,)).map(|_| ()));
    taken.map_err(|raised| *unsaved = Some(raised)).is_ok()
}

fn known_from_row(row: KnownRow, base: i64) -> PyResult<Known> {
    let (level, whole, order, attained, cuts, bound, (objective, rows), sets, n_nodes) = row;
    let reached = |pairs: Vec<(i64, usize)>| -> Vec<_> {
        pairs.into_iter().map(|(cost, position)| Reached { cost, position }).collect()
    };
    let cut = |(feature, position, left, right)| Solved { feature, position, bounds: [left, right] };
    Ok(Known {
        level,
        whole,
        order: reached(order),
        attained: reached(attained),
        cuts: cuts.into_iter().map(cut).collect(),
        bound,
        best: (objective - base, tree_from_rows(rows)?),
        n_nodes,
        sets,
    })
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

//! The exact core's functions.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::problem::PyProblem;
use crate::rows::{Incumbent, NodeRow, known_tree, rows_from_tree, tree_from_rows};
use crate::run::{Found, LimitValues, found, limits, supervised, switches, written};
use crate::workers::Workers;
use octmip_exact::memory_bytes;
use octmip_exact::{
    Cut, CutSolver, Elsewhere, FeatureIncumbent, Held, Helpers, Known, Options, Saver, Solved, SolvedCut, Switches,
    shaped, solve, write_proof,
};
use octmip_frame::control::{Limits, Progress};
use octmip_frame::effort::Control;
use octmip_frame::supervise::Supervision;

/// State of a search: a dict to Python, `octmip.trees.methods.checkpoint.search_state.KnownRow` back. Costs are above
/// the base, the objective of the tree is not.
#[derive(FromPyObject, IntoPyObject)]
struct KnownRow {
    level: usize,
    /// Bound of the trees one level shallower.
    whole: i64,
    /// Best cost and cut of each feature one level lower.
    order: Vec<(i64, usize)>,
    /// Best cost and cut of each feature at this level.
    incumbents: Vec<(i64, usize)>,
    /// Solved cuts: feature, samples left of it, bounds of both sides.
    cuts: Vec<(usize, usize, i64, i64)>,
    bound: i64,
    /// Objective and rows of the best tree.
    best: (i64, Vec<NodeRow>),
    /// Open sets of sensors (held, banned).
    sets: Option<Vec<Held>>,
    /// Evaluated cuts.
    n_nodes: u64,
}

/// The best tree and a bound. `incumbent` is `(objective, rows)` of a feasible tree; `checkpoint` says how often to
/// hand out what is known, to whom, and what an earlier search handed out last.
#[pyfunction]
#[pyo3(signature = (problem, incumbent, limit_values, n_threads, off=Vec::new(), progress=None, *, checkpoint=None,
    submit=None))]
#[allow(clippy::too_many_arguments)]
fn branch_and_bound(
    py: Python<'_>,
    problem: &PyProblem,
    incumbent: Incumbent,
    limit_values: LimitValues,
    n_threads: usize,
    off: Vec<String>,
    progress: Option<Py<PyAny>>,
    checkpoint: Option<(f64, Py<PyAny>, Option<KnownRow>)>,
    submit: Option<(Py<PyAny>, usize)>,
) -> PyResult<Found> {
    let incumbent = known_tree(incumbent)?;
    let switches = switches(Switches::without(&off))?;
    let options = Options { limits: limits(limit_values), n_threads, incumbent, switches };
    let mut unsaved = None;
    let (every, taker, row) = checkpoint.map_or((0.0, None, None), |(every, taker, row)| (every, Some(taker), row));
    let known = row.map(known_from_row).transpose()?;
    let (workers, round) = submit.map_or((None, 0), |(submit, round)| (Some(Workers::new(submit)), round));
    let ask = |level: usize, cut: &Cut, control: &Control| ask_for(workers.as_ref()?, level, cut, control);
    let elsewhere = workers.as_ref().map(|_| Elsewhere { ask: &ask, round });
    let outcome = supervised(py, progress.as_ref(), |keep_going| {
        let mut save = |known: &Known| hand_out(taker.as_ref(), known, &mut unsaved);
        let saver = taker.is_some().then_some(Saver { every, save: &mut save });
        let has_failed = || workers.as_ref().is_some_and(Workers::has_failed);
        let mut keep_going = |state| keep_going(state) && !has_failed();
        solve(&problem.inner, &options, known, saver, elsewhere.as_ref(), &mut keep_going)
    })?;
    workers.map_or(Ok(()), Workers::finish)?;
    if let Some(error) = unsaved {
        return Err(error);
    }
    Ok(found(&outcome.map_err(|reason| PyValueError::new_err(format!("known: {reason}")))?))
}

/// A cut of the root to be solved, as a dict.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct CutRow {
    /// Usable feature.
    feature: usize,
    /// Samples left of it.
    position: usize,
    /// Of both sides.
    bounds: [i64; 2],
    /// The same with leaves of any size, and of `sizes`.
    free: [[i64; 2]; 2],
    sizes: [usize; 2],
    target: i64,
    is_free: bool,
    slack: i64,
}

/// A solved cut, as a dict.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct SolvedRow {
    /// Of both sides.
    bounds: [i64; 2],
    /// The same with leaves of any size, and of `sizes`.
    free: [[i64; 2]; 2],
    /// Cost above the base, and rows of the tree.
    tree: Incumbent,
    /// Evaluated cuts.
    n_evaluated: u64,
    /// Lines of a log.
    record: String,
}

/// A cut that one of the workers solved; None when it was stopped or has failed.
fn ask_for(workers: &Workers, level: usize, cut: &Cut, control: &Control) -> Option<SolvedCut> {
    let &Cut { feature, position, bounds, free, sizes, target, is_free, slack } = cut;
    let row = CutRow { feature, position, bounds, free, sizes, target, is_free, slack };
    let SolvedRow { bounds, free, tree, n_evaluated, record } = workers.ask((level, row), &|| !control.is_stopped())?;
    Some(SolvedCut { bounds, free, tree: workers.checked(known_tree(tree))?, n_evaluated, record })
}

/// A problem ready for cuts of its root to be solved, in a process that helps another one's search.
#[pyclass(name = "CutSolver", frozen)]
struct PyCutSolver {
    inner: CutSolver,
}

#[pymethods]
impl PyCutSolver {
    #[new]
    fn new(problem: &PyProblem, off: Vec<String>, is_logged: bool) -> PyResult<Self> {
        Ok(Self { inner: CutSolver::new(&problem.inner, switches(Switches::without(&off))?, is_logged) })
    }

    /// Solve a cut at a level, with what a log says of it if one is written; None when Ctrl-C stopped it.
    fn solve(&self, py: Python<'_>, level: usize, row: CutRow) -> PyResult<Option<SolvedRow>> {
        let CutRow { feature, position, bounds, free, sizes, target, is_free, slack } = row;
        let cut = Cut { feature, position, bounds, free, sizes, target, is_free, slack };
        if !self.inner.has(&cut) {
            return Err(PyValueError::new_err(format!("feature {feature} has no cut at {position}")));
        }
        let supervision = Supervision::new(Limits::default());
        let state = Progress { seconds: 0.0, objective: 0, bound: 0, n_nodes: 0 };
        let solved = supervised(py, None, |keep_going| {
            let control = Control::reading(supervision.flag());
            let work = || self.inner.solve(level, &cut, &control);
            supervision.run(work, || supervision.poll(&mut *keep_going, state))
        })?;
        Ok(solved.map(|SolvedCut { bounds, free, tree, n_evaluated, record }| {
            let tree = tree.map(|(cost, tree)| (cost, rows_from_tree(&tree)));
            SolvedRow { bounds, free, tree, n_evaluated, record }
        }))
    }
}

/// Give Python what is known; what it raises stops the search and is kept.
fn hand_out(taker: Option<&Py<PyAny>>, known: &Known, unsaved: &mut Option<PyErr>) -> bool {
    let Some(taker) = taker else { return true };
    let pairs = |cuts: &[FeatureIncumbent]| -> Vec<_> { cuts.iter().map(|cut| (cut.cost, cut.position)).collect() };
    let cut = |cut: &Solved| (cut.feature, cut.position, cut.bounds[0], cut.bounds[1]);
    let row = KnownRow {
        level: known.level,
        whole: known.whole,
        order: pairs(&known.order),
        incumbents: pairs(&known.incumbents),
        cuts: known.cuts.iter().map(cut).collect(),
        bound: known.bound,
        best: (known.best.0, rows_from_tree(&known.best.1)),
        sets: known.sets.clone(),
        n_nodes: known.n_nodes,
    };
    let taken = Python::attach(|py| taker.call1(py, (row,)).map(|_| ()));
    taken.map_err(|raised| *unsaved = Some(raised)).is_ok()
}

fn known_from_row(row: KnownRow) -> PyResult<Known> {
    let KnownRow { level, whole, order, incumbents, cuts, bound, best: (objective, rows), sets, n_nodes } = row;
    let from_pairs = |pairs: Vec<(i64, usize)>| -> Vec<_> {
        pairs.into_iter().map(|(cost, position)| FeatureIncumbent { cost, position }).collect()
    };
    let cut = |(feature, position, left, right)| Solved { feature, position, bounds: [left, right] };
    Ok(Known {
        level,
        whole,
        order: from_pairs(order),
        incumbents: from_pairs(incumbents),
        cuts: cuts.into_iter().map(cut).collect(),
        bound,
        best: (objective, tree_from_rows(rows)?),
        n_nodes,
        sets,
    })
}

/// The body of a log that proves `claim`; None when it was stopped, or the claim does not hold. `submit` as for
/// `branch_and_bound`, to somebody who logs.
#[pyfunction]
#[pyo3(signature = (problem, claim, n_threads=1, *, submit=None))]
fn prove(
    py: Python<'_>,
    problem: &PyProblem,
    claim: i64,
    n_threads: usize,
    submit: Option<(Py<PyAny>, usize)>,
) -> PyResult<Option<String>> {
    let (workers, round) = submit.map_or((None, 0), |(submit, round)| (Some(Workers::new(submit)), round));
    let body = written(py, claim, |supervision| {
        let control = Control::reading(supervision.flag());
        let ask = |level: usize, cut: &Cut, control: &Control| {
            let solved = ask_for(workers.as_ref()?, level, cut, control);
            if solved.is_none() {
                supervision.halt();
            }
            solved
        };
        let elsewhere = workers.as_ref().map(|_| Elsewhere { ask: &ask, round });
        let helpers = elsewhere.as_ref().map_or(Helpers::Threads(n_threads), Helpers::Elsewhere);
        write_proof(&problem.inner, claim, Switches::default(), &control, helpers)
    })?;
    workers.map_or(Ok(()), Workers::finish)?;
    Ok(body)
}

/// A place in a tree: columns with a largest rank on the left (or any), whether a leaf, rows of both sides.
type NamedRow = (Vec<(u32, Option<u32>)>, bool, [Option<usize>; 2]);

/// Parts of a tree that are asked for, a dict.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct RulesRow {
    given: Vec<NamedRow>,
    old: Vec<NamedRow>,
    max_changes: Option<usize>,
    bans: Vec<Vec<u32>>,
}

fn rules_from(row: RulesRow) -> PyResult<shaped::Rules> {
    let named = |(splits, is_leaf, sides): NamedRow| shaped::Named { splits, is_leaf, sides, n_splits: 0 };
    let table = |rows: Vec<NamedRow>| {
        shaped::Rules::table(rows.into_iter().map(named).collect()).map_err(PyValueError::new_err)
    };
    let max_changes = row.max_changes.unwrap_or(shaped::NO_LIMIT).min(shaped::NO_LIMIT);
    Ok(shaped::Rules { given: table(row.given)?, old: table(row.old)?, max_changes, bans: row.bans })
}

/// The best tree of a shape and a bound: at most so many splits, and for each feature 1 where predictions never fall as
/// it rises, -1 where they never rise, 0 elsewhere; or with parts that are asked for.
#[pyfunction]
#[pyo3(signature = (problem, incumbent, limit_values, progress=None, *, free=None, max_splits, directions, rules=None))]
#[allow(clippy::too_many_arguments)]
fn shaped_search(
    py: Python<'_>,
    problem: &PyProblem,
    incumbent: Incumbent,
    limit_values: LimitValues,
    progress: Option<Py<PyAny>>,
    free: Incumbent,
    max_splits: usize,
    directions: Vec<i8>,
    rules: Option<RulesRow>,
) -> PyResult<Found> {
    if directions.len() != problem.inner.p {
        return Err(PyValueError::new_err(format!(
            "directions has {} entries, expected {}",
            directions.len(),
            problem.inner.p
        )));
    }
    let (incumbent, free) = (known_tree(incumbent)?, known_tree(free)?);
    let rules = rules.map(rules_from).transpose()?;
    let options = shaped::Options { limits: limits(limit_values), incumbent, free, max_splits, directions, rules };
    let outcome = supervised(py, progress.as_ref(), |keep_going| shaped::solve(&problem.inner, &options, keep_going))?;
    Ok(found(&outcome))
}

/// Bytes that the tables of a search may take, its queues left out.
#[pyfunction]
fn exact_bytes(problem: &PyProblem, n_threads: usize) -> f64 {
    memory_bytes(&problem.inner, n_threads, &Switches::default())
}

/// Names of all prunes.
#[pyfunction]
fn prunes() -> Vec<&'static str> {
    Switches::NAMES.to_vec()
}

/// Add the functions to the native module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(branch_and_bound, module)?)?;
    module.add_function(wrap_pyfunction!(prove, module)?)?;
    module.add_function(wrap_pyfunction!(shaped_search, module)?)?;
    module.add_function(wrap_pyfunction!(exact_bytes, module)?)?;
    module.add_class::<PyCutSolver>()?;
    module.add_function(wrap_pyfunction!(prunes, module)?)
}

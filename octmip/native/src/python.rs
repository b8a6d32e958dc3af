//! The Python border: arrays in, a flat node table and counters out. No logic of trees lives here.

mod check;
mod exact;
mod ranks;
mod search;
mod sequential;
mod two_feature;

use std::time::{Duration, Instant};

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::control::{Limits, Progress, Stop};
use crate::problem::{Planes, Problem};
use crate::tree::{Node, Tree};

/// One row of the node table: kind, feature, cut, left, right, label, hyperplane terms, hyperplane offset.
pub type NodeRow = (u8, u32, u32, u32, u32, u32, Vec<(u32, f64)>, f64);

/// What hyperplane splits need: values (n, p), split_size, groups, integer_normals.
type PlaneArguments<'py> = (PyReadonlyArray2<'py, f64>, usize, Option<Vec<Vec<u32>>>, Option<i64>);

/// `crate::problem::Problem` as a Python object.
#[pyclass(name = "Problem", frozen)]
pub struct PyProblem {
    /// The problem.
    pub inner: Problem,
}

#[pymethods]
impl PyProblem {
    #[new]
    #[pyo3(signature = (ranks, n_ranks, labels, weights, costs, penalty, depth, leaf_size, sensor_of_feature,
        sensor_cost, sensor_limit, allowed, planes=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        ranks: PyReadonlyArray2<'_, u32>,
        n_ranks: Vec<u32>,
        labels: PyReadonlyArray1<'_, u32>,
        weights: PyReadonlyArray1<'_, i64>,
        costs: PyReadonlyArray2<'_, i64>,
        penalty: i64,
        depth: usize,
        leaf_size: usize,
        sensor_of_feature: Vec<u32>,
        sensor_cost: Vec<f64>,
        sensor_limit: f64,
        allowed: Vec<bool>,
        planes: Option<PlaneArguments<'_>>,
    ) -> PyResult<Self> {
        let (p, n) = (ranks.shape()[0], ranks.shape()[1]);
        let planes = planes
            .map(|(values, split_size, groups, integer_normals)| {
                let values = values.as_slice()?.to_vec();
                PyResult::Ok(Planes { values, split_size, groups, integer_normals })
            })
            .transpose()?;
        let inner = Problem {
            n,
            p,
            n_classes: costs.shape()[0],
            ranks: ranks.as_slice()?.to_vec(),
            n_ranks,
            labels: labels.as_slice()?.to_vec(),
            weights: weights.as_slice()?.to_vec(),
            costs: costs.as_slice()?.to_vec(),
            penalty,
            depth,
            leaf_size,
            sensor_of_feature,
            sensor_cost,
            sensor_limit,
            allowed,
            planes,
        };
        inner.validate().map_err(|error| PyValueError::new_err(error.0))?;
        Ok(Self { inner })
    }
}

/// The node table of a tree.
pub fn rows_from_tree(tree: &Tree) -> Vec<NodeRow> {
    tree.nodes
        .iter()
        .map(|node| match node {
            Node::Leaf { label } => (0, 0, 0, 0, 0, *label, Vec::new(), 0.0),
            Node::Split { feature, cut, left, right } => (1, *feature, *cut, *left, *right, 0, Vec::new(), 0.0),
            Node::Hyperplane { terms, offset, left, right } => (2, 0, 0, *left, *right, 0, terms.clone(), *offset),
        })
        .collect()
}

/// The tree of a node table.
pub fn tree_from_rows(rows: Vec<NodeRow>) -> PyResult<Tree> {
    let n = rows.len() as u32;
    let nodes = rows
        .into_iter()
        .enumerate()
        .map(|(i, (kind, feature, cut, left, right, label, terms, offset))| {
            if kind != 0 && !(left > i as u32 && left < n && right > i as u32 && right < n) {
                return Err(PyValueError::new_err(format!("node {i} of {n} has children {left} and {right}")));
            }
            Ok(match kind {
                0 => Node::Leaf { label },
                1 => Node::Split { feature, cut, left, right },
                _ => Node::Hyperplane { terms, offset, left, right },
            })
        })
        .collect::<PyResult<Vec<_>>>()?;
    if nodes.is_empty() {
        return Err(PyValueError::new_err("the node table is empty"));
    }
    Ok(Tree { nodes })
}

/// Limits from `(seconds, gap, nodes, memory)`.
pub fn limits(values: (f64, f64, f64, f64)) -> Limits {
    Limits { seconds: values.0, gap: values.1, nodes: values.2, memory: values.3 }
}

/// The name that `octmip.solution.Stop` gives a stop.
pub fn stop_name(stop: Stop) -> &'static str {
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

/// Report progress to Python and look for Ctrl-C, at most every 50 ms: a solver may ask as often as it likes.
///
/// `progress` is None or a callable of `(seconds, objective, bound, n_nodes)`. What it raises, KeyboardInterrupt from
/// Ctrl-C apart, stops the solver and is kept in `error` for the caller to raise.
pub fn keep_going<'a>(
    progress: Option<&'a Py<PyAny>>,
    error: &'a mut Option<PyErr>,
) -> impl FnMut(Progress) -> bool + 'a {
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

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(two_feature::py_two_feature_branch_and_bound, module)?)?;
    module.add_function(wrap_pyfunction!(two_feature::two_feature_prunes, module)?)?;
    module.add_function(wrap_pyfunction!(two_feature::prove_two_feature, module)?)?;
    module.add_function(wrap_pyfunction!(sequential::sequential, module)?)?;
    module.add_function(wrap_pyfunction!(ranks::dense_ranks, module)?)?;
    module.add_function(wrap_pyfunction!(search::py_search, module)?)?;
    module.add_class::<PyProblem>()?;
    module.add_class::<check::PyQuestion>()?;
    exact::register(module)
}

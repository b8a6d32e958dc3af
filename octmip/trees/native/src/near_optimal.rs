//! Near-optimal sets at the Python border.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::problem::PyProblem;
use crate::rows::{NodeRow, rows_from_tree};
use crate::run::{LimitValues, limits, stop_name, supervised};
use octmip_exact::{Solved, View};
use octmip_frame::control::{KeepGoing, Limits, Progress};
use octmip_frame::effort::Control;
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;
use octmip_near_optimal::{
    Cost, Counted, Counter, Entry, ExactCosts, Instance, MOST_SENSORS, Wanted, least_by_sensor, run,
};

/// Cost, sensors (bits), number of trees.
type EntryRow = (i128, u128, u128);

/// A cut of the root: a dict to Python, `octmip.trees.near_sets.near_set.Cut` back.
#[derive(Clone, FromPyObject, IntoPyObject)]
struct CutRow {
    feature: u32,
    /// The largest rank that goes left.
    rank: u32,
    /// Samples left of it.
    position: usize,
    /// Of both sides.
    bounds: (i64, i64),
    /// None: not counted.
    trees: Option<Vec<EntryRow>>,
}

/// `octmip.trees.near_sets.near_set.Wanted` by its attributes.
#[derive(FromPyObject)]
struct WantedRow {
    /// Of the root; None: a leaf.
    cut: Option<CutRow>,
    cost: i128,
    /// Bits of the sensors that they read.
    sensors: u128,
    number: u128,
}

/// All trees up to a cost.
#[pyclass(name = "Counted", frozen, get_all, module = "octmip.trees._native")]
pub(crate) struct CountRow {
    leaves: Vec<EntryRow>,
    /// Of the root.
    cuts: Vec<CutRow>,
    /// Features whose cuts are not all known.
    open: Vec<u32>,
    stop: &'static str,
    /// Evaluated cuts.
    n_nodes: u64,
}

/// Least costs by sensor, why the search stopped early, evaluated cuts.
type ReadersRow = (Vec<Option<i128>>, Option<&'static str>, u64);

/// Costs as a dict, see `ExactCosts`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct CostsRow {
    classes: Vec<u32>,
    weights: Vec<i128>,
    costs: Vec<i128>,
    n_labels: usize,
    penalty: i128,
    shift: u32,
}

enum Inner {
    Narrow(Instance<i64>),
    Wide(Instance<i128>),
}

/// A problem whose trees are counted.
#[pyclass(frozen)]
pub(crate) struct NearProblem {
    inner: Inner,
}

/// Do the same with either width of costs.
macro_rules! either {
    ($inner:expr, $instance:ident => $work:expr) => {
        match $inner {
            Inner::Narrow($instance) => $work,
            Inner::Wide($instance) => $work,
        }
    };
}

#[pymethods]
impl NearProblem {
    /// `costs` as `ExactCosts`, `above` as `Instance::new`; `is_narrow`: 64 bits hold every sum.
    #[new]
    fn new(problem: &PyProblem, costs: CostsRow, above: Vec<u32>, is_narrow: bool, by_sets: bool) -> PyResult<Self> {
        let n_sensors = problem.inner.sensor_cost.len();
        let is_limited = problem.inner.sensor_cost.iter().sum::<f64>() > problem.inner.sensor_limit;
        if (by_sets || is_limited) && n_sensors > MOST_SENSORS {
            return Err(PyValueError::new_err(format!("{n_sensors} sensors; expected at most {MOST_SENSORS}")));
        }
        let inner = if is_narrow {
            Inner::Narrow(Instance::new(&problem.inner, &exact_costs(costs)?, &above, by_sets))
        } else {
            Inner::Wide(Instance::new(&problem.inner, &exact_costs(costs)?, &above, by_sets))
        };
        Ok(Self { inner })
    }

    /// Count all trees up to a cost.
    fn count(
        &self,
        py: Python<'_>,
        limit: i128,
        limit_values: LimitValues,
        n_threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<CountRow> {
        let limits = limits(limit_values);
        let progress = progress.as_ref();
        either!(&self.inner, instance => {
            let limit = narrow(limit)?;
            let counted = supervised(py, progress, |keep_going| run(instance, limit, n_threads, limits, keep_going))?;
            Ok(count_row(instance, counted))
        })
    }

    /// Trees by their number among those of one cut, cost and set of sensors.
    fn trees(&self, py: Python<'_>, wanted: Vec<WantedRow>) -> PyResult<Option<Vec<Vec<NodeRow>>>> {
        either!(&self.inner, instance => {
            let wanted = wanted
                .into_iter()
                .map(|WantedRow { cut, cost, sensors, number }| {
                    Ok((solved(instance, cut), Wanted { cost: narrow(cost)?, mask: sensors, number }))
                })
                .collect::<PyResult<Vec<_>>>()?;
            let trees = alone(py, |control| trees(instance, control, &wanted))?;
            Ok(trees.map(|trees| trees.iter().map(rows_from_tree).collect()))
        })
    }

    /// The least cost of a tree that reads each sensor, where it is below `known` (one for each sensor), else None; why
    /// the search stopped early, if it did; evaluated cuts.
    fn readers(
        &self,
        py: Python<'_>,
        known: Vec<i128>,
        limit_values: LimitValues,
        n_threads: usize,
    ) -> PyResult<ReadersRow> {
        let limits = limits(limit_values);
        either!(&self.inner, instance => {
            let known = known.into_iter().map(narrow).collect::<PyResult<Vec<_>>>()?;
            if known.len() != instance.n_sensors {
                return Err(PyValueError::new_err(format!("{} costs for {} sensors", known.len(), instance.n_sensors)));
            }
            let search = |keep_going: KeepGoing<'_>| least_by_sensor(instance, &known, n_threads, limits, keep_going);
            let (found, stop, n_nodes) = supervised(py, None, search)?;
            Ok((found.into_iter().map(|cost| cost.map(wide)).collect(), stop.map(stop_name), n_nodes))
        })
    }

    /// Number of distinct predictions of the trees up to a cost; None when more than `most` at one node, or stopped.
    fn predictions(&self, py: Python<'_>, limit: i128, most: usize, seconds: f64) -> PyResult<Option<usize>> {
        either!(&self.inner, instance => {
            let limit = narrow(limit)?;
            let limits = Limits { seconds, ..Limits::default() };
            let supervision = Supervision::new(limits);
            supervised(py, None, |keep_going| {
                watched(&supervision, keep_going, |control| {
                    let root = View::root(&instance.samples);
                    Counter::new(instance, control, &root).n_predictions(&root, instance.depth, limit, most)
                })
            })
        })
    }
}

fn exact_costs<T: Cost>(row: CostsRow) -> PyResult<ExactCosts<T>> {
    let CostsRow { classes, weights, costs, n_labels, penalty, shift } = row;
    let all = |numbers: Vec<i128>| numbers.into_iter().map(narrow).collect::<PyResult<Vec<T>>>();
    Ok(ExactCosts { classes, weights: all(weights)?, costs: all(costs)?, n_labels, penalty: narrow(penalty)?, shift })
}

fn wide<T: Cost>(cost: T) -> i128 {
    cost.into()
}

fn narrow<T: Cost>(number: i128) -> PyResult<T> {
    T::try_from(number).map_err(|_| PyValueError::new_err(format!("{number} does not fit")))
}

/// Work of one thread that Ctrl-C stops.
fn alone<R: Send>(py: Python<'_>, work: impl FnOnce(&Control) -> R + Send) -> PyResult<R> {
    let supervision = Supervision::new(Limits::default());
    supervised(py, None, |keep_going| watched(&supervision, keep_going, work))
}

fn watched<R: Send>(
    supervision: &Supervision,
    keep_going: KeepGoing<'_>,
    work: impl FnOnce(&Control) -> R + Send,
) -> R {
    let control = Control::reading(supervision.flag());
    let state = Progress { seconds: 0.0, objective: i64::MAX, bound: 0, n_nodes: 0 };
    supervision.run(|| work(&control), || supervision.poll(&mut *keep_going, state))
}

fn trees<T: Cost>(
    instance: &Instance<T>,
    control: &Control,
    wanted: &[(Option<Solved>, Wanted<T>)],
) -> Option<Vec<Tree>> {
    let root = View::root(&instance.samples);
    let mut counter = Counter::new(instance, control, &root);
    let one = |(cut, wanted): &(Option<Solved>, Wanted<T>)| match cut {
        None => counter.tree(&root, 0, *wanted),
        Some(cut) => counter.tree_of_cut(&root, instance.depth, cut, *wanted),
    };
    wanted.iter().map(one).collect()
}

/// The usable feature and position of a cut that Python holds.
fn solved<T>(instance: &Instance<T>, cut: Option<CutRow>) -> Option<Solved> {
    let CutRow { feature, position, bounds, .. } = cut?;
    let feature = instance.samples.features.iter().position(|&f| f == feature)?;
    Some(Solved { feature, position, bounds: bounds.into() })
}

fn entry_rows<T: Cost>(entries: &[Entry<T>]) -> Vec<EntryRow> {
    entries.iter().map(|entry| (entry.cost.into(), entry.mask, entry.count)).collect()
}

fn count_row<T: Cost>(instance: &Instance<T>, counted: Counted<T>) -> CountRow {
    let features = &instance.samples.features;
    let root = View::root(&instance.samples);
    let cuts = counted.cuts.iter().map(|known| {
        let cut = &known.cut;
        let rank = instance.samples.ranks_of(cut.feature)[root.list(cut.feature)[cut.position - 1] as usize];
        let trees = known.trees.as_deref().map(entry_rows);
        CutRow { feature: features[cut.feature], rank, position: cut.position, bounds: cut.bounds.into(), trees }
    });
    CountRow {
        leaves: entry_rows(&counted.leaves),
        cuts: cuts.collect(),
        open: counted.open.iter().map(|&f| features[f]).collect(),
        stop: stop_name(counted.stop),
        n_nodes: counted.n_nodes,
    }
}

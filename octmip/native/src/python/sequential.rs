//! `octmip._native.sequential`: samples, costs and prices in; a node table, a bound and counters out.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::python::{NodeRow, keep_going, limits, rows_from_tree, stop_name};
use crate::sequential::{Question, solve};

/// Node rows (None without a tree below the room), bound, stop, evaluated cuts.
type Found = (Option<Vec<NodeRow>>, f64, &'static str, u64);
/// Cost of each sensor, group of each sensor, opening cost of each group, sensors read before the root.
type Prices = (Vec<f64>, Vec<usize>, Vec<f64>, Vec<usize>);
/// Penalty of a split, depth, leaf size, sensor of each feature, whether it may be used, most readings of each label.
type Shape = (f64, usize, usize, Vec<usize>, Vec<bool>, Vec<usize>);

/// The best tree that weighs less than `room`, which holds the error alone where there is a cap.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
#[pyo3(signature = (ranks, paid, frequency, haste, shape, prices, multiplier, cap, room, limit_values))]
pub fn sequential(
    py: Python<'_>,
    ranks: PyReadonlyArray2<'_, u32>,
    paid: PyReadonlyArray2<'_, f64>,
    frequency: PyReadonlyArray1<'_, f64>,
    haste: PyReadonlyArray1<'_, f64>,
    shape: Shape,
    prices: Prices,
    multiplier: f64,
    cap: Option<f64>,
    room: f64,
    limit_values: (f64, f64, f64, f64),
) -> PyResult<Found> {
    let (penalty, depth, leaf_size, sensor_of_feature, allowed, most_readings) = shape;
    let (sensor_cost, group_of_sensor, opening, read) = prices;
    let question = Question {
        n: ranks.shape()[1],
        p: ranks.shape()[0],
        n_classes: paid.shape()[1],
        ranks: ranks.as_slice()?.to_vec(),
        paid: paid.as_slice()?.to_vec(),
        frequency: frequency.as_slice()?.to_vec(),
        haste: haste.as_slice()?.to_vec(),
        penalty,
        depth,
        leaf_size,
        sensor_of_feature,
        sensor_cost,
        group_of_sensor,
        opening,
        most_readings,
        allowed,
        read,
        multiplier,
        cap,
    };
    question.validate().map_err(PyValueError::new_err)?;
    let mut error = None;
    let answer = py.detach(|| {
        let mut going = keep_going(None, &mut error);
        solve(&question, room, limits(limit_values), &mut going)
    });
    match error {
        Some(raised) => Err(raised),
        None => Ok((answer.tree.as_ref().map(rows_from_tree), answer.bound, stop_name(answer.stop), answer.n_cuts)),
    }
}

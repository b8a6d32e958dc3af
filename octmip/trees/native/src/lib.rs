//! The Python border: arrays in, a flat node table and counters out. No logic of trees lives here.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod check;
mod exact;
mod near_optimal;
mod problem;
mod ranks;
mod reached;
mod regression;
mod rows;
mod run;
mod search;
mod two_feature;
mod workers;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<run::Found>()?;
    module.add_class::<run::FoundBelow>()?;
    module.add_class::<problem::PyProblem>()?;
    module.add_class::<check::PyQuestion>()?;
    module.add_class::<check::Accepted>()?;
    module.add_class::<check::Refused>()?;
    module.add_class::<regression::PyRegressionQuestion>()?;
    module.add_class::<regression::ProvenBelow>()?;
    module.add_class::<near_optimal::NearProblem>()?;
    module.add_class::<near_optimal::CountRow>()?;
    module.add_class::<ranks::PyRankTable>()?;
    module.add_class::<search::PyTurnSolver>()?;
    module.add_function(wrap_pyfunction!(ranks::dense_ranks, module)?)?;
    module.add_function(wrap_pyfunction!(reached::reached_nodes, module)?)?;
    module.add_function(wrap_pyfunction!(search::py_search, module)?)?;
    module.add_function(wrap_pyfunction!(regression::regression, module)?)?;
    two_feature::register(module)?;
    exact::register(module)
}

//! Branch and bound over thresholds for regression: trees of least squared or sloped (absolute, quantile) error.
//!
//! ```text
//! samples, view      the problem as it is counted, and the samples of one node
//! clusters           the least error of few constants for many targets: what no tree of so many leaves avoids
//! slopes, quantiles  sloped errors, and those of one constant on both sides of every cut of a feature
//! scan               the best cut of one feature left and right of a cut of another, by samples
//! few_cuts           a bound of that for sloped errors
//! buckets            the same of all features at once by buckets: vector passes in `sweep`, walks in `inside`
//! sides, depth_two   the two sides of a moving cut, and the best tree of at most two levels
//! axis, node         the cuts of a feature with their bounds, and the search of a node of any depth
//! proof              the proof log, by a search in the whole numbers of its checker
//! root               the whole search: the cuts of all features by their bounds, limits, progress
//! ```
//!
//! Costs are sums of float64. Targets come scaled such that the sums of weights and of weighted targets are whole
//! numbers below 2^53 wherever the data allow; how far a cost may be from the true one is said in
//! `octmip/trees/regression/grid.py`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod axis;
mod buckets;
mod clusters;
mod depth_two;
mod few_cuts;
mod inside;
mod node;
mod proof;
mod quantiles;
mod result;
mod root;
mod samples;
mod scan;
mod sides;
mod slopes;
mod sweep;
mod view;

pub use proof::prove;
pub use root::{Found, solve};
pub use samples::Question;
pub use slopes::Slopes;

//! Trees whose sensors are read one after the other, each paid when a path first reaches it.
//!
//! A tree costs `error + multiplier * cost`: `error` is what its leaves and splits cost and the delay cost of each
//! reading, `cost` what the sensors cost that each sample has read. Both are sums over the samples of the price of the
//! *set* of sensors on a sample's path, so they never rise when samples or splits are taken away; that is all that the
//! bounds in `cuts.rs` need. docs/theory/sensing.md has the mathematics.

mod cuts;
mod pool;
mod problem;
mod run;
mod samples;
mod solve;
mod stumps;
mod supervision;
#[cfg(test)]
mod tests;

pub use problem::SequentialProblem;
pub use solve::{SequentialResult, solve};

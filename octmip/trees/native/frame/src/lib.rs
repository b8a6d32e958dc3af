//! What all searches share: trees, limits and their supervision, costs, ranks, open cuts between solved ones, logs.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

pub mod control;
pub mod costs;
pub mod effort;
pub mod interval;
pub mod log;
pub mod ranks;
pub mod supervise;
mod switches;
pub mod tree;

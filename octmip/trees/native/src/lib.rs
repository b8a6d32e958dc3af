//! The native core of octmip: classification trees over ranked features.
//!
//! Pure logic; the Python border is in `python.rs` alone, behind the feature `python`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

pub mod control;
mod costs;
pub mod effort;
pub mod exact;
mod interval;
mod log;
pub mod near_optimal;
pub mod ranks;
pub mod regression;
pub mod search;
pub mod supervise;
mod switches;
pub mod tree;
pub mod two_feature;

pub use octmip_check::problem;

#[cfg(feature = "python")]
mod python;

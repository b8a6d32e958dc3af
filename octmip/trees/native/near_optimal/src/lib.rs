//! All trees whose cost is at most a limit: counted, looked up by number, and told apart by what they predict.
//!
//! ```text
//! cost         costs as whole numbers of 64 or 128 bits
//! instance     samples, costs of every label, sensors
//! spectrum     how many trees cost how much and read which sensors; two children joined
//! stumps       the spectrum of trees of one split, both sides of a cut in one walk
//! reach        features passed over: bounds carried from cut to cut
//! counter      the spectrum of a node: cuts that may belong (exact core), their children, joined
//! run          the root's cuts in several threads, limits
//! lookup       the tree of a number
//! predictions  distinct vectors of predicted labels
//! readers      the least cost of a tree that reads each sensor
//! ```
//!
//! The proof of the count is in docs/theory/near-optimal.md.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod cost;
mod counter;
mod instance;
mod lookup;
mod predictions;
mod reach;
mod readers;
mod run;
mod spectrum;
mod stumps;

pub use cost::Cost;
pub use counter::Counter;
pub use instance::{ExactCosts, Instance, MOST_SENSORS};
pub use lookup::Wanted;
pub use readers::least_by_sensor;
pub use run::{Counted, run};
pub use spectrum::Entry;

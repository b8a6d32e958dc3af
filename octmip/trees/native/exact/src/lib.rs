//! Branch and bound over thresholds: provably optimal axis-aligned trees.
//!
//! ```text
//! samples, view    the problem as it is counted, and the samples of one node
//! stumps           the best trees of one split left and right of a moving cut
//! node             the search of one node: its cuts, their bounds, its plan and its proof
//! root_search      the whole search: limits, threads, sensor budget, checkpoints
//! shaped           the search for at most so many splits, and for predictions that keep the order of a feature
//! subtree, proof   the same search for local search, and for a log
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod node;
mod proof;
mod root_search;
mod samples;
pub mod shaped;
mod stumps;
mod subtree;
mod switches;
mod view;

pub use node::result::{FeatureIncumbent, Solved};
pub use node::search::{Cut, Search};
pub use proof::{Helpers, write as write_proof};
pub use root_search::elsewhere::{CutSolver, Elsewhere, SolvedCut};
pub use root_search::known::{Held, Known, Saver};
pub use root_search::memory::bytes as memory_bytes;
pub use root_search::{Options, one_level_deeper, solve};
pub use samples::Samples;
pub use stumps::place::Place;
pub use subtree::best_subtree;
pub use switches::Switches;
pub use view::View;

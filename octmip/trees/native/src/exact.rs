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

pub(crate) mod node;
pub(crate) mod proof;
pub(crate) mod root_search;
pub(crate) mod samples;
pub mod shaped;
pub(crate) mod stumps;
pub(crate) mod subtree;
pub(crate) mod switches;
pub(crate) mod view;

pub use proof::write as write_proof;
pub use root_search::{Options, one_level_deeper, solve};
pub use switches::Switches;

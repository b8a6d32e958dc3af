//! Branch and bound over thresholds: provably optimal axis-aligned trees.
//!
//! ```text
//! samples, view    the problem as it is counted, and the samples of one node
//! stumps           the best trees of one split left and right of a moving cut
//! node             the search of one node: its cuts, their bounds, its plan and its proof
//! root             the whole search: limits, threads, sensor budget, checkpoints
//! subtree, proof   the same search for local search, and for a log
//! ```

pub mod effort;
pub mod node;
pub mod proof;
pub mod root;
pub mod samples;
pub mod stumps;
pub mod subtree;
pub mod switches;
pub mod view;

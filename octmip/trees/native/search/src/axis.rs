//! Axis-aligned splits: the scan of one node's cuts, exact subtrees, and the cuts of the root.

pub(crate) mod blocks;
pub(crate) mod root_cuts;
pub(crate) mod scan;

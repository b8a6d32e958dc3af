//! The tree of a search: rules, nodes with their samples, the view of one node, and what one split may read.

pub(crate) mod allowance;
pub(crate) mod rule;
pub(crate) mod state;
pub(crate) mod view;

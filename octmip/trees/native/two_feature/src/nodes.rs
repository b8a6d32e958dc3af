//! Trees of depth 2: nodes of the search, their bounds, the order in which they are taken.

pub(crate) mod bounds;
pub(crate) mod branching;
pub(crate) mod first_trees;
pub(crate) mod gains;
pub(crate) mod known;
pub(crate) mod node;
pub(crate) mod numbers;
pub(crate) mod queue;
pub(crate) mod state;

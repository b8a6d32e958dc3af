//! SoftPlane-tree refinement: all planes of a subtree moved together.

pub(crate) mod plane;
pub(crate) mod refinement;
pub(crate) mod schedule;

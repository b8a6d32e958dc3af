//! The search of one node: the best tree of some samples, or the proof that none is cheap enough.

pub mod axis;
mod depth_two;
pub mod log;
pub mod plan;
pub mod result;
pub mod search;

//! The search of one node: the best tree of some samples, or the proof that none is cheap enough.

pub(crate) mod axis;
pub(crate) mod beside;
mod by_values;
pub(crate) mod children;
mod depth_two;
pub(crate) mod kept;
pub(crate) mod log;
pub(crate) mod plan;
pub(crate) mod price;
pub(crate) mod result;
pub(crate) mod search;
mod within;
mod without_search;

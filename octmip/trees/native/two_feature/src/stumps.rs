//! The best single split of any subset of the samples.

pub(crate) mod depth_one;
pub(crate) mod histograms;
pub(crate) mod refine;
pub(crate) mod scan;
pub(crate) mod search;
pub(crate) mod solver;
pub(crate) mod sweep;

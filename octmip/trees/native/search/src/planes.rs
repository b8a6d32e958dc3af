//! The hyperplane of one node, the rest of the tree fixed.

pub(crate) mod exact_pairs;
pub(crate) mod feature_swap;
pub(crate) mod improve;
pub(crate) mod line;
pub(crate) mod logistic_fit;
pub(crate) mod pairs;
pub(crate) mod perturb;
pub(crate) mod plane_search;
pub(crate) mod random;
pub(crate) mod rounding;

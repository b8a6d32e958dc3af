//! Exact geometry of samples in the plane of two features.

pub(crate) mod hull;
pub(crate) mod line;
pub(crate) mod margin;
pub(crate) mod plane;
pub(crate) mod wide_products;

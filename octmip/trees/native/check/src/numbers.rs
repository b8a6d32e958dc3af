//! Exact arithmetic: numbers of any length, and signs of sums of products.

pub(crate) mod exact;
pub(crate) mod signs;

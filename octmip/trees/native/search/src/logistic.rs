//! Logistic regression: a fit of few features, and the ranking of many.

pub(crate) mod ranking;
pub(crate) mod regression;

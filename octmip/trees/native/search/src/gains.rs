//! The gains of leaves: the gain of every class on a sample, and their sums while samples change sides.

pub(crate) mod prices;
pub(crate) mod tally;

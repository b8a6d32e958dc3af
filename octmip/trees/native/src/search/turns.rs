//! Turns of restarts: what is kept of them, and how other processes take them.

pub(crate) mod elsewhere;
pub(crate) mod known;
pub(crate) mod solver;

//! The parts of a log that both kinds of trees share: its lines, its header, the decisions about sensors.

pub(crate) mod cursor;
pub(crate) mod decisions;
pub(crate) mod header;
pub(crate) mod whole_costs;

//! Sets of lines: regions of dual planes, and the dichotomies where their splitting ends.

pub(crate) mod dichotomies;
pub(crate) mod dual_plane;
pub(crate) mod realisation;
pub(crate) mod region;
pub(crate) mod slope_interval;

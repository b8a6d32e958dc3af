//! The vector pass over the buckets: gains of stumps at the edges, bounds of those inside.
//!
//! Plain loops over arrays of a fixed width inside `pulp`'s dispatch: the compiler turns them into the widest vectors
//! of the machine at hand. Integer arithmetic, so every width gives the same numbers.

mod difference;
mod distinct;
mod edge;
mod group;
mod lanes;
mod profiles;

pub(crate) use difference::Difference;
pub(crate) use distinct::Distinct;
pub(crate) use edge::STRIDE;
pub(crate) use group::Group;
pub(crate) use lanes::Lane;

//! The checker of logs of two-feature trees.
//!
//! Format and proofs: docs/theory/two-feature.md. A line `x + t y = r` over two features is a point (t, r) of their
//! dual plane; a sample is the straight line r = x + t y and goes left where that runs below the point. Coordinates are
//! wrong by 2^-53 at most and within -1 and 1, t within -1 and 1 (the features exchanged give the steeper lines), so a
//! value x + t y is wrong by less than 2^-50: what is 2^-46 clear of an edge at both ends of a range of t is clear of
//! it. Where that does not settle a sample, signs of sums of products of the values as given do, exactly.
//!
//! Public is what gives a log its meaning, so that a writer can mean the same: regions and coordinates (`Region`,
//! `Points`), the dichotomies of points by a line (`Plane::dichotomies`), exact signs.

mod bands;
mod checker;
mod costs;
mod dichotomies;
mod feature;
mod nodes;
mod plane;
mod points;
mod region;
mod scan;
mod sections;
mod separation;
mod stumps;

use crate::log::cursor::Cursor;
use crate::problem::Problem;
use crate::refusal::{Checked, ensure};
use crate::threads::check_parts;
use checker::Checker;
pub use checker::MOST;
pub use plane::Plane;
pub use points::Points;
pub use region::Region;

pub use crate::numbers::signs::exact_sign;

/// Check that the rest of a log proves that every tree costs `claim` or more.
pub(crate) fn check(q: &Problem, mut cursor: Cursor<'_>, claim: i64, n_threads: usize) -> Checked<()> {
    let checker = Checker::new(q, claim);
    let leaf = checker.leaf(&checker.tally(&checker.all()));
    ensure!(leaf >= claim, cursor.line(), "one leaf costs {leaf}, less than the claim");
    let sections = checker.sections(&mut cursor)?;
    cursor.expect_end()?;
    check_parts(sections.len(), n_threads, cursor.line(), |part| checker.section(&sections[part]))
}

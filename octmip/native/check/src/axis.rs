//! The checker of logs of axis-aligned trees.
//!
//! Format and proofs: docs/theory/proof.md.

mod checker;
mod inequalities;
mod nodes;
mod stumps;

use crate::log::cursor::Cursor;
use crate::problem::Problem;
use crate::refusal::Checked;
use checker::Checker;

/// Check that the rest of a log proves that every tree costs `claim` or more.
pub(crate) fn check(q: &Problem, cursor: Cursor<'_>, claim: i64) -> Checked<()> {
    let mut checker = Checker::new(q, cursor);
    checker.cases(claim)?;
    checker.cursor.expect_end()
}

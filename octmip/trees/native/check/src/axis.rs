//! The checker of logs of axis-aligned trees.
//!
//! Format and proofs: docs/theory/proof.md. One walk through the log reads its records and checks the nodes of three
//! levels and more, each from what its children claim; the nodes of two levels, which are most of the log and know
//! nothing of each other, are set aside and then counted on several threads.

mod checker;
mod inequalities;
mod label_sets;
mod merging;
mod nodes;
mod stumps;
mod walk;

use crate::log::cursor::Cursor;
use crate::problem::Problem;
use crate::refusal::Checked;
use crate::threads::check_parts;
use checker::Checker;
use merging::merged;
use walk::Walk;

/// Check that the rest of a log proves that every tree costs `claim` or more.
pub(crate) fn check(q: &Problem, cursor: Cursor<'_>, claim: i64, n_threads: usize) -> Checked<()> {
    let merged = merged(q);
    let (q, rows) = merged.as_ref().map_or((q, &[][..]), |(q, rows)| (q, &rows[..]));
    let checker = Checker::new(q, rows);
    let (counted, last_line) = Walk::new(&checker, cursor).cases(claim)?;
    check_parts(counted.len(), n_threads, last_line, |part| checker.counted_node(&counted[part]))
}

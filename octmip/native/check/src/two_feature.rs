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

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::log::cursor::Cursor;
use crate::problem::Problem;
use crate::refusal::{Checked, Refusal, ensure};
use checker::Checker;
pub use checker::MOST;
pub use plane::Plane;
pub use points::Points;
pub use region::Region;
use sections::Section;

pub use crate::numbers::signs::exact_sign;

/// Stack of each thread, for nodes within nodes and bands within bands.
const STACK_BYTES: usize = 1 << 26;

/// Check that the rest of a log proves that every tree costs `claim` or more.
pub(crate) fn check(q: &Problem, mut cursor: Cursor<'_>, claim: i64, n_threads: usize) -> Checked<()> {
    let checker = Checker::new(q, claim);
    let leaf = checker.leaf(&checker.tally(&checker.all()));
    ensure!(leaf >= claim, cursor.line(), "one leaf costs {leaf}, less than the claim");
    let sections = checker.sections(&mut cursor)?;
    cursor.expect_end()?;
    check_sections(&checker, &sections, n_threads, cursor.line())
}

/// Check all sections; of those that are refused, the first one found in the log is returned.
fn check_sections(checker: &Checker<'_>, sections: &[Section<'_>], n_threads: usize, last_line: usize) -> Checked<()> {
    let (next, refusals) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let refuse = |refusal: Refusal| {
        refusals.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(refusal);
        next.store(sections.len(), Ordering::Relaxed);
    };
    let work = || {
        while let Some(section) = sections.get(next.fetch_add(1, Ordering::Relaxed)) {
            checker.section(section).unwrap_or_else(refuse);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..n_threads.clamp(1, sections.len().max(1)) {
            let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work);
            if let Err(error) = thread {
                refuse(Refusal { line: last_line, reason: format!("no thread to check on ({error})") });
            }
        }
    });
    let found = refusals.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    found.into_iter().min_by_key(|refusal| refusal.line).map_or(Ok(()), Err)
}

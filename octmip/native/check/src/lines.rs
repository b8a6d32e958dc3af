//! The checker of logs of two-feature trees.
//!
//! Format and proofs: docs/theory/two-feature.md. A line `x + t y = r` over two features is a point (t, r); a sample is the
//! straight line r = x + t y and goes left where that runs below the point. Coordinates are wrong by 2^-53 at most and
//! within -1 and 1, t within -1 and 1 (the features exchanged give the steeper lines), so a value x + t y is wrong by
//! less than 2^-50: what is 2^-46 clear of an edge at both ends of a range of t is clear of it. Where that does not
//! settle a sample, signs of sums of products of the values as given do, exactly.
//!
//! Public is what gives a log its meaning, so that a writer can mean the same: cells and coordinates (`Cell`,
//! `Points`), the ways in which a line parts points (`Plane::ways`), exact signs.

mod boxes;
mod counts;
mod parting;
mod points;
mod sections;
mod signs;
mod stumps;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::cursor::Cursor;
use crate::problem::Problem;
use crate::refusal::{Checked, Refusal, ensure};
pub use points::{Plane, Points};
use sections::Section;
pub use signs::exact_sign;

/// Room for rounding.
const EPS: f64 = 1.0 / (1u64 << 46) as f64;
/// Bands narrower than this are not split.
const TINY: f64 = 1.0 / (1u64 << 39) as f64;
/// So many different points are tried in every way before a cell is split, and at the end of splitting (any number
/// there if they are all on one line).
const FEW: usize = 6;
/// So many different points are parted in every way where splitting ends.
pub const MOST: usize = 48;
/// Bins of r in which lines are counted at once, at most.
const BINS: usize = 64;
/// Of each thread, for boxes within boxes and bands within bands.
const STACK_BYTES: usize = 1 << 26;
/// More than any tree costs.
const NO_TREE: i64 = i64::MAX / 4;

/// Class weights of some samples, and last their number.
type Tally = Vec<i64>;
/// Two features, the second one past the last for axis-aligned splits.
type Chart = (usize, usize);
/// Features and a range of t: where a child's line may lie.
type Strip = (Chart, f64, f64);

/// Lines between two straight edges over a range of t, each edge given by its ends.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Ends of the range of t.
    pub t: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
}

/// What all sections of a log are checked with.
struct Checker<'a> {
    q: &'a Problem,
    points: Points,
    /// For two answers and a class, what the cheaper answer costs.
    cheaper: Vec<i64>,
    claim: i64,
}

/// Check that the rest of a log proves that every tree costs `claim` or more.
pub(crate) fn check(q: &Problem, mut cursor: Cursor<'_>, claim: i64, n_threads: usize) -> Checked<()> {
    let checker = Checker { q, points: Points::new(q), cheaper: cheaper(q), claim };
    let leaf = checker.leaf(&checker.tally(&checker.all()));
    ensure!(leaf >= claim, cursor.line(), "one leaf costs {leaf}, less than the claim");
    let sections = checker.sections(&mut cursor)?;
    cursor.expect_end()?;
    checker.on_threads(&sections, n_threads, cursor.line())
}

/// For two answers and a class, what the cheaper answer costs.
fn cheaper(q: &Problem) -> Vec<i64> {
    let k = q.n_classes;
    let pairs = (0..k).flat_map(|a| (0..k).map(move |b| (a, b)));
    pairs.flat_map(|(a, b)| (0..k).map(move |c| q.cost(c, a).min(q.cost(c, b)))).collect()
}

impl Checker<'_> {
    fn all(&self) -> Vec<u32> {
        (0..self.q.n as u32).collect()
    }

    /// Check all sections; of those that are refused, the first one found in the log is returned.
    fn on_threads(&self, sections: &[Section<'_>], n_threads: usize, last_line: usize) -> Checked<()> {
        let (next, refusals) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let refuse = |refusal: Refusal| {
            refusals.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(refusal);
            next.store(sections.len(), Ordering::Relaxed);
        };
        let work = || {
            while let Some(section) = sections.get(next.fetch_add(1, Ordering::Relaxed)) {
                self.section(section).unwrap_or_else(refuse);
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
}

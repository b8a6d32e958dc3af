//! The best stump (at most one split) left and right of a moving cut: the inner loop of a depth-two search.

pub(crate) mod aligned;
pub(crate) mod buckets;
pub(crate) mod cells;
pub(crate) mod fitting;
pub(crate) mod groups;
mod inside;
pub(crate) mod place;
pub(crate) mod scan;
pub(crate) mod sweep;
pub(crate) mod table;
pub(crate) mod uncertainty;

use crate::samples::Samples;
use crate::switches::Switches;

use buckets::Buckets;
use place::StumpSolver;
use scan::Scan;

/// Index of the width of histogram numbers (16, 32, 64 bits) that holds three times a total range: a bucket's bound
/// adds two gains and a range.
pub(crate) fn width(total_range: i64) -> usize {
    let largest = 3 * total_range as i128 + 2;
    usize::from(largest > i16::MAX as i128) + usize::from(largest > i32::MAX as i128)
}

/// Whether groups of half as many slots hold `p` features in three quarters of the slots, or fewer.
///
/// Empty slots take room in the caches, which is what moving samples waits for; more groups take more passes.
fn is_better_in_halves(p: usize, slots: usize) -> bool {
    4 * p.next_multiple_of(slots / 2) <= 3 * p.next_multiple_of(slots)
}

/// The stump solver that fits a set of this total range.
pub(crate) fn solver(samples: &Samples, total_range: i64, switches: &Switches) -> Box<dyn StumpSolver> {
    if !switches.buckets || samples.leaf_size > 1 {
        return Box::new(Scan::default());
    }
    let p = samples.p;
    match width(total_range) {
        0 if p <= 4 => Box::new(Buckets::<i16, 8, 4>::new(samples, switches)),
        0 if is_better_in_halves(p, 16) => Box::new(Buckets::<i16, 16, 8>::new(samples, switches)),
        0 => Box::new(Buckets::<i16, 32, 16>::new(samples, switches)),
        1 if is_better_in_halves(p, 8) => Box::new(Buckets::<i32, 8, 4>::new(samples, switches)),
        1 => Box::new(Buckets::<i32, 16, 8>::new(samples, switches)),
        _ => Box::new(Buckets::<i64, 8, 4>::new(samples, switches)),
    }
}

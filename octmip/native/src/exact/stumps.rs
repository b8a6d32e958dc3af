//! The best stump (at most one split) left and right of a moving cut: what a depth-two search asks most often.

pub mod aligned;
pub mod buckets;
pub mod groups;
mod inside;
pub mod place;
pub mod scan;
pub mod sweep;
pub mod table;
pub mod uncertainty;

use crate::exact::samples::Samples;
use crate::exact::switches::Switches;

use buckets::Buckets;
use place::Stumps;
use scan::Scan;

/// Widths of histogram numbers: which one holds three times a swing (a bucket's bound adds two gains and a swing).
pub fn width(mass: i64) -> usize {
    let largest = 3 * mass as i128 + 2;
    usize::from(largest > i16::MAX as i128) + usize::from(largest > i32::MAX as i128)
}

/// The stump finder that fits a set of this swing.
pub fn finder(samples: &Samples, mass: i64, switches: &Switches) -> Box<dyn Stumps> {
    if !switches.buckets || samples.leaf_size > 1 {
        return Box::new(Scan::default());
    }
    match width(mass) {
        0 => Box::new(Buckets::<i16, 32, 16>::new(samples, switches)),
        1 => Box::new(Buckets::<i32, 16, 8>::new(samples, switches)),
        _ => Box::new(Buckets::<i64, 8, 4>::new(samples, switches)),
    }
}

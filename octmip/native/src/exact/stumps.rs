//! The best stump (at most one split) left and right of a moving cut: what a depth-two search asks most often.

pub mod buckets;
pub mod scan;
pub mod sweep;
pub mod table;

use crate::exact::Switches;
use crate::exact::samples::Samples;
use crate::exact::view::View;
use buckets::Buckets;
use scan::Scan;

/// What is known of the best stump of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stump {
    /// No stump (or leaf) costs less.
    pub lower: i64,
    /// One that costs this much is known.
    pub value: i64,
}

/// The place of the cut: the first `k` samples of list `f` of `view` are left.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// All samples of the node.
    pub view: &'a View,
    /// Feature of the cut.
    pub f: usize,
    /// Samples left of the cut.
    pub k: usize,
    /// Position of every sample in list `f`.
    pub positions: &'a [u32],
}

impl Place<'_> {
    /// Whether a sample is on a side (0 left, 1 right).
    #[inline(always)]
    pub fn is_on(&self, side: usize, sample: u32) -> bool {
        ((self.positions[sample as usize] as usize) < self.k) == (side == 0)
    }

    /// Number of samples on a side.
    pub fn size(&self, side: usize) -> usize {
        if side == 0 {
            self.k
        } else {
            self.view.len - self.k
        }
    }
}

/// A way to find best stumps.
pub trait Stumps: Send {
    /// Prepare for views that are subsets of this one and not much smaller.
    fn prepare(&mut self, samples: &Samples, view: &View);

    /// Take up a view; the cut stands at 0.
    fn load(&mut self, samples: &Samples, view: &View);

    /// Put the cut back to 0.
    fn rewind(&mut self);

    /// Best stumps of both sides, exact unless their bounds reach `close` together.
    fn both(&mut self, samples: &Samples, place: &Place<'_>, close: i64) -> [Stump; 2];

    /// Largest gain of a stump on each feature that was seen by the last call of `both`, right side (`p`).
    fn attained(&self, scores: &mut Vec<i64>);

    /// Bytes of its tables.
    fn bytes(&self) -> usize;
}

/// The stump finder that fits a set of this swing.
pub fn finder(samples: &Samples, mass: i64, switches: &Switches) -> Box<dyn Stumps> {
    if !switches.buckets || samples.leaf_size > 1 {
        return Box::new(Scan::default());
    }
    // A bucket's bound adds two scores and a swing, each at most the set's swing: three times must fit the lane.
    let largest = 3 * mass as i128 + 2;
    if largest <= i16::MAX as i128 {
        Box::new(Buckets::<i16, 32>::new(samples, switches))
    } else if largest <= i32::MAX as i128 {
        Box::new(Buckets::<i32, 16>::new(samples, switches))
    } else {
        Box::new(Buckets::<i64, 8>::new(samples, switches))
    }
}

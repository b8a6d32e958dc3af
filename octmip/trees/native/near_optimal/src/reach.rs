//! Lower bounds of the stumps of each feature beside a moving cut: features beyond the limit are passed over.
//!
//! Adding samples to a side never lowers the cost of its best stump (or leaf) above the base, and removing some lowers
//! it by their total range at most. The first is false where leaves have a least size: there nothing is carried on.

use crate::cost::Cost;
use crate::instance::Instance;
use crate::stumps::Side;
use octmip_exact::{Solved, View};

/// How far above the limit stumps are told apart, in mean ranges: cuts as near to the next bounds are of use to it.
const MEAN_RANGES: i64 = 32;

/// Bounds beside the cut of a node that was last placed.
#[derive(Debug, Clone)]
pub(crate) struct Reach<T> {
    /// How far above a limit the least cost is worth knowing.
    pub(crate) more: T,
    /// For each feature, of both sides, above the base.
    least: Vec<[T; 2]>,
    at: Option<(usize, usize)>,
    is_monotone: bool,
}

impl<T: Cost> Reach<T> {
    /// Nothing known.
    pub(crate) fn new(instance: &Instance<T>) -> Self {
        let total: i128 = instance.ranges.iter().map(|range| (*range).into()).sum();
        let more = i128::from(MEAN_RANGES) * total / instance.samples.n as i128;
        Self {
            more: T::try_from(more).unwrap_or_default(),
            least: vec![[T::default(); 2]; instance.samples.p],
            at: None,
            is_monotone: instance.samples.leaf_size == 1,
        }
    }

    /// Another node follows.
    pub(crate) fn forget(&mut self) {
        self.at = None;
    }

    /// Carry the bounds on to another cut of the node.
    pub(crate) fn move_to(&mut self, instance: &Instance<T>, view: &View, cut: &Solved) {
        let before = self.at.replace((cut.feature, cut.position)).filter(|(f, _)| *f == cut.feature);
        let Some((_, from)) = before.filter(|_| self.is_monotone) else {
            self.least.fill([T::default(); 2]);
            return;
        };
        let (low, high) = (from.min(cut.position), from.max(cut.position));
        let mut moved = T::default();
        for &i in &view.list(cut.feature)[low..high] {
            moved += instance.ranges[i as usize];
        }
        let shrinks = usize::from(cut.position > from);
        for least in &mut self.least {
            least[shrinks] -= moved;
        }
    }

    /// Whether a stump of a feature may be within the limit of a side.
    pub(crate) fn may_be_within(&self, f: usize, sides: &[Side<T>; 2]) -> bool {
        (0..2).any(|side| self.least[f][side] + sides[side].totals.base <= sides[side].limit)
    }

    /// Note the least costs of a feature's stumps.
    pub(crate) fn set(&mut self, f: usize, sides: &[Side<T>; 2], least: [T; 2]) {
        self.least[f] = [0, 1].map(|side| least[side] - sides[side].totals.base);
    }
}

//! How many trees of a node cost how much and read which sensors.

use std::collections::BTreeMap;

use crate::cost::Cost;
use crate::instance::{Instance, Totals};

/// Trees of one cost that read one set of sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry<T> {
    /// Their cost.
    pub cost: T,
    /// The sensors that they read; empty where sets are not told apart.
    pub mask: u128,
    /// How many there are; sums beyond 2^128 stay at the largest number.
    pub count: u128,
}

/// Counts by cost and sensors.
pub(crate) type Counts<T> = BTreeMap<(T, u128), u128>;

/// The trees of some samples up to a cost, leaves among them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Spectrum<T> {
    /// Counts, by cost, then sensors.
    pub(crate) entries: Vec<Entry<T>>,
    /// Cost of a leaf of each label.
    pub(crate) leaves: Vec<T>,
}

impl<T: Cost> Spectrum<T> {
    /// Trees with a split beside the leaves that cost `limit` at most.
    pub(crate) fn new(mut splits: Counts<T>, totals: &Totals<T>, limit: T) -> Self {
        let leaves: Vec<T> = (0..totals.gains.len()).map(|label| totals.leaf(label)).collect();
        for &cost in leaves.iter().filter(|cost| **cost <= limit) {
            add(&mut splits, cost, 0, 1);
        }
        Self { entries: entries(splits), leaves }
    }

    /// The least cost of all, if there is one.
    pub(crate) fn least(&self) -> Option<T> {
        self.entries.first().map(|entry| entry.cost)
    }
}

/// The counts in order.
pub(crate) fn entries<T: Cost>(counts: Counts<T>) -> Vec<Entry<T>> {
    let kept = counts.into_iter().filter(|(_, count)| *count > 0);
    kept.map(|((cost, mask), count)| Entry { cost, mask, count }).collect()
}

/// Count some trees more.
pub(crate) fn add<T: Cost>(counts: &mut Counts<T>, cost: T, mask: u128, count: u128) {
    let sum = counts.entry((cost, mask)).or_default();
    *sum = sum.saturating_add(count);
}

/// Count the trees of a cut that reads `mask`, with these children, that cost `limit` at most.
///
/// Two leaves of one label are no children: their tree is the leaf of that label, which has no split.
pub(crate) fn join<T: Cost>(
    instance: &Instance<T>,
    mask: u128,
    sides: [&Spectrum<T>; 2],
    limit: T,
    counts: &mut Counts<T>,
) {
    let [left, right] = sides;
    if !instance.fits(mask) {
        return;
    }
    for l in &left.entries {
        let above = instance.penalty + l.cost;
        for r in right.entries.iter().take_while(|r| above + r.cost <= limit) {
            let read = mask | l.mask | r.mask;
            if instance.fits(read) {
                add(counts, above + r.cost, read, l.count.saturating_mul(r.count));
            }
        }
    }
    for (l, r) in left.leaves.iter().zip(&right.leaves) {
        if let Some(count) = counts.get_mut(&(instance.penalty + *l + *r, mask)) {
            *count -= u128::from(instance.penalty + *l + *r <= limit);
        }
    }
}

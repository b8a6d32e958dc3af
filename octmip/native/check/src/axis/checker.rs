//! The state of checking: the problem, the place in the log, samples in the order of each feature.

use crate::log::cursor::Cursor;
use crate::problem::Problem;

/// Samples in the order of each feature (empty unless it is in play), and last all of them anyhow.
pub(super) type Orders = Vec<Vec<u32>>;
/// A solved cut: feature, number of samples to the left, bounds of the two sides.
pub(super) type Cut = (usize, usize, [i64; 2]);

/// A problem, what its samples cost, and the log that is read.
pub(super) struct Checker<'a> {
    pub(super) q: &'a Problem,
    /// Cost of each sample when it is answered worst.
    pub(super) worst: Vec<i64>,
    /// Answers to each sample, and what they save of that.
    pub(super) savings: Vec<Vec<(usize, i64)>>,
    /// No sum is larger.
    pub(super) most: i64,
    pub(super) cursor: Cursor<'a>,
}

impl<'a> Checker<'a> {
    /// A checker at the beginning of the body of a log.
    pub(super) fn new(q: &'a Problem, cursor: Cursor<'a>) -> Self {
        let cost = |i: usize, k| q.weights[i] * q.cost(q.labels[i] as usize, k);
        let worst = |i| (0..q.n_classes).map(|k| cost(i, k)).max().unwrap_or(0);
        let saving = |i, k| Some((k, worst(i) - cost(i, k))).filter(|saving| saving.1 > 0);
        let savings = |i| (0..q.n_classes).filter_map(|k| saving(i, k)).collect();
        Self {
            q,
            most: (0..q.n).map(worst).sum::<i64>().max(2 * q.n as i64 + 1),
            worst: (0..q.n).map(worst).collect(),
            savings: (0..q.n).map(savings).collect(),
            cursor,
        }
    }
}

impl Checker<'_> {
    /// All samples, in the order of each feature that may be used and read.
    pub(super) fn orders(&self, may_read: &[bool]) -> Orders {
        let q = self.q;
        let order = |f: usize| {
            let in_play = q.allowed[f] && may_read[q.sensor_of_feature[f] as usize];
            let mut order: Vec<u32> = (0..if in_play { q.n as u32 } else { 0 }).collect();
            order.sort_by_key(|&i| q.feature(f)[i as usize]);
            order
        };
        let mut orders: Orders = (0..q.p).map(order).collect();
        orders.push((0..q.n as u32).collect());
        orders
    }

    /// The samples of one side: the `left` ones, or all the others.
    pub(super) fn part(&self, orders: &Orders, left: &[u32], is_left: bool) -> Orders {
        let mut kept = vec![!is_left; self.q.n];
        left.iter().for_each(|&i| kept[i as usize] = is_left);
        orders.iter().map(|order| order.iter().copied().filter(|&i| kept[i as usize]).collect()).collect()
    }

    /// Whether the first `cut` samples, not none and not all, lie below the others.
    pub(super) fn is_between(&self, feature: usize, order: &[u32], cut: usize) -> bool {
        let rank = |k: usize| self.q.feature(feature)[order[k] as usize];
        0 < cut && cut < order.len() && rank(cut - 1) != rank(cut)
    }

    /// Count one sample.
    pub(super) fn join(&self, classes: &mut [i64], sample: u32) {
        classes[self.q.labels[sample as usize] as usize] += self.q.weights[sample as usize];
    }
}

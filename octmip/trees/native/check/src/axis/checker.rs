//! What all nodes of a log are checked against: the problem, what its samples cost, its samples in order.

use std::sync::Arc;

use super::label_sets::{LabelSets, labels_worth_giving};
use crate::problem::Problem;

/// Samples in the order of each feature (empty unless it is in play), and last all of them anyhow.
pub(super) type Orders = Vec<Vec<u32>>;

/// What is proven of some samples: a bound of the trees of the problem, and of those whose leaves may have any size.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bounds {
    pub(super) own: i64,
    pub(super) free: i64,
}

impl Bounds {
    /// A record of leaves of any size bounds both: the trees of the problem are some of those.
    pub(super) fn raise(&mut self, leaf: usize, bound: i64) {
        self.own = self.own.max(bound);
        if leaf == 1 {
            self.free = self.free.max(bound);
        }
    }
}

/// A solved cut: feature, number of samples to the left, what is proven of the two sides.
pub(super) type Cut = (usize, usize, [Bounds; 2]);

/// What a record claims: the line that it stands in, the least size of leaves, the bound.
#[derive(Debug, Clone, Copy)]
pub(super) struct Claim {
    pub(super) line: usize,
    pub(super) leaf: usize,
    pub(super) bound: i64,
}

/// The samples of a node: all of them, with the features that may be read, or one side of a cut of other samples.
pub(super) enum Place {
    Root(Vec<bool>),
    Side { whole: Arc<Place>, feature: usize, cut: usize, is_left: bool },
}

/// A problem, and what its samples cost.
pub(super) struct Checker<'a> {
    pub(super) q: &'a Problem,
    /// Rows of the log's problem that each sample is; none: one each.
    rows: &'a [u32],
    /// Cost of each sample under its most expensive label.
    pub(super) worst: Vec<i64>,
    /// Labels of each sample that save some of that, and how much.
    pub(super) savings: Vec<Vec<(usize, i64)>>,
    /// The number that all savings are whole multiples of: sums of them are counted in it.
    pub(super) unit: i64,
    /// The labels that trees of 0, 1, 2 and so on levels may give.
    pub(super) label_sets: Vec<LabelSets>,
    /// All samples in the order of each feature that may be used, and last in their own.
    sorted: Orders,
}

impl<'a> Checker<'a> {
    /// The checker of a problem whose samples are so many rows of the log's.
    pub(super) fn new(q: &'a Problem, rows: &'a [u32]) -> Self {
        let cost = |i: usize, k| q.weights[i] * q.cost(q.labels[i] as usize, k);
        let worst = |i| (0..q.n_classes).map(|k| cost(i, k)).max().unwrap_or(0);
        let saving = |i, k| Some((k, worst(i) - cost(i, k))).filter(|saving| saving.1 > 0);
        let savings: Vec<Vec<_>> = (0..q.n).map(|i| (0..q.n_classes).filter_map(|k| saving(i, k)).collect()).collect();
        let unit = savings.iter().flatten().fold(0, |unit, &(_, saving)| common_divisor(unit, saving)).max(1);
        let labels = labels_worth_giving(q);
        Self {
            q,
            rows,
            unit,
            worst: (0..q.n).map(worst).collect(),
            savings,
            label_sets: (0..=q.depth).map(|depth| LabelSets::new(q, &labels, depth)).collect(),
            sorted: sorted(q),
        }
    }
}

/// The greatest common divisor; 0 where both are 0.
fn common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// All samples in the order of each feature that may be used, and last in their own.
fn sorted(q: &Problem) -> Orders {
    let order = |f: usize| {
        let mut order: Vec<u32> = (0..if q.allowed[f] { q.n as u32 } else { 0 }).collect();
        order.sort_by_key(|&i| q.feature(f)[i as usize]);
        order
    };
    (0..q.p).map(order).chain([(0..q.n as u32).collect()]).collect()
}

impl Checker<'_> {
    /// The samples of a place, in the order of each feature in play.
    pub(super) fn orders(&self, place: &Place) -> Orders {
        match place {
            Place::Root(may_read) => {
                let q = self.q;
                let is_in_play = |f: usize| f == q.p || may_read[q.sensor_of_feature[f] as usize];
                let order = |(f, order): (usize, &Vec<u32>)| if is_in_play(f) { order.clone() } else { Vec::new() };
                self.sorted.iter().enumerate().map(order).collect()
            }
            Place::Side { whole, feature, cut, is_left } => {
                let orders = self.orders(whole);
                self.part(&orders, &orders[*feature][..*cut], *is_left)
            }
        }
    }

    /// The samples of one side: the `left` ones, or all the others.
    fn part(&self, orders: &Orders, left: &[u32], is_left: bool) -> Orders {
        let mut kept = vec![!is_left; self.q.n];
        left.iter().for_each(|&i| kept[i as usize] = is_left);
        orders.iter().map(|order| order.iter().copied().filter(|&i| kept[i as usize]).collect()).collect()
    }

    /// Rows of the log's problem that a sample is.
    pub(super) fn rows_of(&self, sample: u32) -> usize {
        self.rows.get(sample as usize).map_or(1, |&rows| rows as usize)
    }

    /// Whether the first `cut` samples, not none and not all, lie below the others.
    pub(super) fn is_between(&self, feature: usize, order: &[u32], cut: usize) -> bool {
        let rank = |k: usize| self.q.feature(feature)[order[k] as usize];
        0 < cut && cut < order.len() && rank(cut - 1) != rank(cut)
    }
}

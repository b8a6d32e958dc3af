//! The samples of a node, sorted by every feature, and their sums.

use super::question::{Lanes, Question};

/// A sample and its rank in the feature of the list.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// Index of the sample.
    pub sample: u32,
    /// Its rank.
    pub rank: u32,
}

/// One list a feature, each in the order of ranks.
pub type Orders = Vec<Vec<Entry>>;

/// What a node's samples add up to.
#[derive(Debug, Clone)]
pub struct Sums {
    /// Number of samples.
    pub count: usize,
    /// Their frequencies.
    pub frequency: f64,
    /// What one reading adds to their error.
    pub haste: f64,
    /// Cost of each label.
    pub labels: Vec<Lanes>,
}

/// Samples in the order of each feature, equal ranks by index.
pub fn sorted(question: &Question) -> Orders {
    question
        .ranks
        .chunks(question.n)
        .map(|ranks| {
            let mut list: Vec<Entry> =
                ranks.iter().enumerate().map(|(i, &rank)| Entry { sample: i as u32, rank }).collect();
            list.sort_by_key(|entry| entry.rank);
            list
        })
        .collect()
}

/// The orders of the samples of one side.
pub fn side_of(orders: &Orders, is_left: &[bool], left: bool) -> Orders {
    orders
        .iter()
        .map(|list| list.iter().filter(|entry| is_left[entry.sample as usize] == left).copied().collect())
        .collect()
}

/// The rows of costs of every sample, padded to whole lanes.
pub fn padded(question: &Question) -> Vec<Lanes> {
    let mut rows = Vec::with_capacity(question.n * question.n_classes.div_ceil(8));
    for row in question.paid.chunks(question.n_classes) {
        for part in row.chunks(8) {
            let mut lanes = [0.0; 8];
            lanes[..part.len()].copy_from_slice(part);
            rows.push(lanes);
        }
    }
    rows
}

/// Add a row of costs.
pub fn add(sum: &mut [Lanes], row: &[Lanes]) {
    for (into, from) in sum.iter_mut().zip(row) {
        for (a, b) in into.iter_mut().zip(from) {
            *a += b;
        }
    }
}

/// The least cost of a label that is not closed.
pub fn cheapest(sum: &[Lanes], closed: &[Lanes]) -> f64 {
    let mut least = [f64::INFINITY; 8];
    for (lanes, shut) in sum.iter().zip(closed) {
        for k in 0..8 {
            least[k] = least[k].min(lanes[k] + shut[k]);
        }
    }
    least.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The least cost of a label that is not closed over what `part` leaves of `whole`.
pub fn cheapest_rest(whole: &[Lanes], part: &[Lanes], closed: &[Lanes]) -> f64 {
    let mut least = [f64::INFINITY; 8];
    for ((all, some), shut) in whole.iter().zip(part).zip(closed) {
        for k in 0..8 {
            least[k] = least[k].min(all[k] - some[k] + shut[k]);
        }
    }
    least.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The first label of least cost.
pub fn cheapest_label(sum: &[Lanes], closed: &[Lanes]) -> u32 {
    let costs = sum.iter().flatten().zip(closed.iter().flatten()).map(|(cost, shut)| cost + shut);
    let best = costs.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(0, |(label, _)| label as u32)
}

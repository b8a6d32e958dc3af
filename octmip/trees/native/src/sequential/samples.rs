//! The samples of a node, sorted by every feature, and their sums.

use super::problem::{Lanes, SequentialProblem};

/// A sample and its rank in the feature of the list.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    /// Index of the sample.
    pub(crate) sample: u32,
    /// Its rank.
    pub(crate) rank: u32,
}

/// One list per feature, each in the order of ranks.
pub(crate) type Orders = Vec<Vec<Entry>>;

/// Sums over a node's samples.
#[derive(Debug, Clone)]
pub(crate) struct Sums {
    /// Number of samples.
    pub(crate) count: usize,
    /// Sum of their multiplicities.
    pub(crate) frequency: f64,
    /// Sum of their delay costs: the error that one reading adds.
    pub(crate) delay_cost: f64,
    /// Cost of each label.
    pub(crate) labels: Vec<Lanes>,
}

/// Samples in the order of each feature, equal ranks by index.
pub(crate) fn sorted(problem: &SequentialProblem) -> Orders {
    problem
        .ranks
        .chunks(problem.n)
        .map(|ranks| {
            let mut list: Vec<Entry> =
                ranks.iter().enumerate().map(|(i, &rank)| Entry { sample: i as u32, rank }).collect();
            list.sort_by_key(|entry| entry.rank);
            list
        })
        .collect()
}

/// The orders of the samples of one side.
pub(crate) fn side_of(orders: &Orders, is_left: &[bool], left: bool) -> Orders {
    orders
        .iter()
        .map(|list| list.iter().filter(|entry| is_left[entry.sample as usize] == left).copied().collect())
        .collect()
}

/// The rows of costs of every sample, padded to whole lanes.
pub(crate) fn padded(problem: &SequentialProblem) -> Vec<Lanes> {
    let mut rows = Vec::with_capacity(problem.n * problem.n_classes.div_ceil(8));
    for row in problem.paid.chunks(problem.n_classes) {
        for part in row.chunks(8) {
            let mut lanes = [0.0; 8];
            lanes[..part.len()].copy_from_slice(part);
            rows.push(lanes);
        }
    }
    rows
}

/// Add a row of costs.
pub(crate) fn add(sum: &mut [Lanes], row: &[Lanes]) {
    for (into, from) in sum.iter_mut().zip(row) {
        for (a, b) in into.iter_mut().zip(from) {
            *a += b;
        }
    }
}

/// The least cost of a label that is not closed.
pub(crate) fn cheapest(sum: &[Lanes], closed: &[Lanes]) -> f64 {
    let mut least = [f64::INFINITY; 8];
    for (lanes, shut) in sum.iter().zip(closed) {
        for k in 0..8 {
            least[k] = least[k].min(lanes[k] + shut[k]);
        }
    }
    least.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The least cost of a label that is not closed over what `part` leaves of `whole`.
pub(crate) fn cheapest_rest(whole: &[Lanes], part: &[Lanes], closed: &[Lanes]) -> f64 {
    let mut least = [f64::INFINITY; 8];
    for ((all, some), shut) in whole.iter().zip(part).zip(closed) {
        for k in 0..8 {
            least[k] = least[k].min(all[k] - some[k] + shut[k]);
        }
    }
    least.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The first label of least cost that is not closed.
pub(crate) fn cheapest_label(sum: &[Lanes], closed: &[Lanes]) -> u32 {
    let costs = sum.iter().flatten().zip(closed.iter().flatten()).map(|(cost, shut)| cost + shut);
    let best = costs.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(0, |(label, _)| label as u32)
}

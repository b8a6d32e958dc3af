//! The problem as all sections of a log are checked against it.

use super::points::Points;
use crate::problem::Problem;

/// Most different points in a dichotomy where splitting ends.
pub const MOST: usize = 48;
/// More than any tree costs.
pub(super) const NO_TREE: i64 = i64::MAX / 4;

/// Class weights of some samples, and last their number.
pub(super) type Tally = Vec<i64>;
/// Two features, the second one past the last for axis-aligned splits.
pub(super) type DualPlane = (usize, usize);
/// A dual plane and a range of t in it: where a child's line may lie.
pub(super) type SlopeInterval = (DualPlane, f64, f64);

/// The problem, its samples as points, and what a log claims.
pub(super) struct Checker<'a> {
    pub(super) q: &'a Problem,
    pub(super) points: Points,
    /// Cost of the cheaper of two labels, for each pair of them and each class.
    pub(super) cheaper: Vec<i64>,
    /// Cost of the most expensive label of each class, and the labels that save some of that, with how much.
    pub(super) worst: Vec<i64>,
    pub(super) savings: Vec<Vec<(usize, i64)>>,
    pub(super) claim: i64,
}

impl<'a> Checker<'a> {
    /// A checker of a claim about a problem.
    pub(super) fn new(q: &'a Problem, claim: i64) -> Self {
        let worst = |c| (0..q.n_classes).map(|k| q.cost(c, k)).max().unwrap_or(0);
        let saving = |c, k| Some((k, worst(c) - q.cost(c, k))).filter(|saving| saving.1 > 0);
        let savings = |c| (0..q.n_classes).filter_map(|k| saving(c, k)).collect();
        Self {
            q,
            points: Points::new(q),
            cheaper: cheaper(q),
            worst: (0..q.n_classes).map(worst).collect(),
            savings: (0..q.n_classes).map(savings).collect(),
            claim,
        }
    }

    /// All samples.
    pub(super) fn all(&self) -> Vec<u32> {
        (0..self.q.n as u32).collect()
    }
}

/// Cost of the cheaper of two labels, for each pair of them and each class.
fn cheaper(q: &Problem) -> Vec<i64> {
    let k = q.n_classes;
    let pairs = (0..k).flat_map(|a| (0..k).map(move |b| (a, b)));
    pairs.flat_map(|(a, b)| (0..k).map(move |c| q.cost(c, a).min(q.cost(c, b)))).collect()
}

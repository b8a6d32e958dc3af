//! A run of cuts of one feature between two that were solved, and the bounds that the two give those between.

use std::cmp::Ordering;

/// A solved cut: lower bounds of its two children, and the stretch of the samples left of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End {
    /// Of the left child.
    pub(crate) left: f64,
    /// Of the right child.
    pub(crate) right: f64,
    /// Sum of the stretches of the samples that go left.
    pub(crate) stretch: f64,
}

/// Cuts `low..=high` of the list of a feature's cuts.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// Feature.
    pub(crate) feature: usize,
    /// First cut.
    pub(crate) low: usize,
    /// Last cut.
    pub(crate) high: usize,
    /// The solved cut before the first.
    pub(crate) before: End,
    /// The solved cut after the last.
    pub(crate) after: End,
    /// No cut of the run costs less, the price of its own split included.
    pub(crate) bound: f64,
}

impl Run {
    /// Lower bounds of the children of a cut with `stretch` to its left.
    ///
    /// Monotone: the best tree of the larger left side, idle splits removed, serves the smaller and costs no more:
    /// every sample keeps its leaf's label and reads a subset of the sensors, which costs no more and closes no label.
    /// Not so where leaves have a least size. Stretch: the best tree of the smaller side is feasible on the larger,
    /// where a sample adds at most its stretch: its most expensive label and path.
    pub(crate) fn children(&self, stretch: f64, is_monotone: bool) -> (f64, f64) {
        let (left, right) = if is_monotone { (self.before.left, self.after.right) } else { (0.0, 0.0) };
        (
            left.max(self.after.left - (self.after.stretch - stretch)),
            right.max(self.before.right - (stretch - self.before.stretch)),
        )
    }
}

impl PartialEq for Run {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Run {}

impl PartialOrd for Run {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Run {
    /// The least bound is the greatest, as heaps give the greatest first; then the first feature and cut.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .bound
            .total_cmp(&self.bound)
            .then_with(|| other.feature.cmp(&self.feature))
            .then_with(|| other.low.cmp(&self.low))
    }
}

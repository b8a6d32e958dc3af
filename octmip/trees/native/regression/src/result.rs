//! What the search of a node returns.

use crate::samples::Samples;
use octmip_frame::tree::Tree;

/// A tree of at most `depth` levels, or what is known instead.
#[derive(Debug, Clone)]
pub(crate) struct NodeResult {
    /// No tree costs less.
    pub(crate) lower: f64,
    /// No tree with leaves of any size costs less.
    pub(crate) relaxed: f64,
    /// The best tree, if it costs less than was asked for.
    pub(crate) best: Option<(f64, Tree)>,
}

impl NodeResult {
    /// No tree below a bound.
    pub(crate) fn none(lower: f64) -> Self {
        Self { lower, relaxed: lower, best: None }
    }

    /// The tree if it costs less than `upper`; its cost is the least there is.
    pub(crate) fn cheapest(cost: f64, tree: Tree, upper: f64) -> Self {
        Self { lower: cost, relaxed: cost, best: (cost < upper).then_some((cost, tree)) }
    }

    /// Cost of the tree found, else `upper`.
    pub(crate) fn cost(&self, upper: f64) -> f64 {
        self.best.as_ref().map_or(upper, |(cost, _)| *cost)
    }

    /// After all cuts: nothing is below the best tree, or below `upper` without one.
    pub(crate) fn closed(mut self, upper: f64, samples: &Samples, clusters: f64) -> Self {
        self.lower = self.cost(upper).max(clusters);
        self.relaxed = if samples.leaf_size == 1 { self.lower } else { clusters };
        self
    }
}

//! The result of the search of one node.

use crate::node::plan::Plan;

/// The incumbent of one feature: the best of its cuts that were solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FeatureIncumbent {
    /// Its cost, `i64::MAX` when none was seen.
    pub cost: i64,
    /// Samples left of it.
    pub position: usize,
}

impl FeatureIncumbent {
    /// No cut solved yet.
    pub(crate) const NOTHING: Self = Self { cost: i64::MAX, position: 0 };

    /// Take up a cut if it costs less.
    pub(crate) fn see(&mut self, cost: i64, position: usize) {
        if cost < self.cost {
            *self = Self { cost, position };
        }
    }
}

/// The best tree of a node if it is below the budget, and in any case a bound.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NodeResult {
    /// No tree costs less (unless the search was stopped).
    pub(crate) lower: i64,
    /// Cost and plan of the best tree.
    pub(crate) best: Option<(i64, Plan)>,
}

impl NodeResult {
    /// No tree below this.
    pub(crate) fn none(lower: i64) -> Self {
        Self { lower, best: None }
    }

    /// A tree.
    pub(crate) fn found(cost: i64, plan: Plan) -> Self {
        Self { lower: cost, best: Some((cost, plan)) }
    }

    /// A tree if it is below `upper`.
    pub(crate) fn cheapest(cost: i64, plan: Plan, upper: i64) -> Self {
        if cost < upper { Self::found(cost, plan) } else { Self::none(upper) }
    }

    /// The cost to beat.
    pub(crate) fn cost(&self, upper: i64) -> i64 {
        self.best.as_ref().map_or(upper, |(cost, _)| *cost)
    }

    /// The result after a whole search with budget `upper`.
    pub(crate) fn closed(mut self, upper: i64) -> Self {
        self.lower = self.cost(upper);
        self
    }
}

/// A solved cut of the root: usable feature, samples left of it, lower bounds of both children.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Solved {
    /// Usable feature.
    pub feature: usize,
    /// Samples left of it.
    pub position: usize,
    /// Lower bounds of the children.
    pub bounds: [i64; 2],
}

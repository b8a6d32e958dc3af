//! What a search of one node has to say.

use crate::exact::node::plan::Plan;

/// The best cut of a feature that was seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Reached {
    /// Its cost, `i64::MAX` when none was seen.
    pub cost: i64,
    /// Samples left of it.
    pub position: usize,
}

impl Reached {
    /// Nothing yet.
    pub const NOTHING: Self = Self { cost: i64::MAX, position: 0 };

    /// Take up a cut if it costs less.
    pub fn see(&mut self, cost: i64, position: usize) {
        if cost < self.cost {
            *self = Self { cost, position };
        }
    }
}

/// What a search found out: the best tree if it is below the budget, and in any case a bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// No tree costs less (unless the search was stopped).
    pub lower: i64,
    /// Cost and plan of the best tree.
    pub best: Option<(i64, Plan)>,
}

impl Answer {
    /// No tree below this.
    pub fn none(lower: i64) -> Self {
        Self { lower, best: None }
    }

    /// A tree.
    pub fn found(cost: i64, plan: Plan) -> Self {
        Self { lower: cost, best: Some((cost, plan)) }
    }

    /// A tree if it is below `upper`.
    pub fn cheapest(cost: i64, plan: Plan, upper: i64) -> Self {
        if cost < upper { Self::found(cost, plan) } else { Self::none(upper) }
    }

    /// The cost to beat.
    pub fn cost(&self, upper: i64) -> i64 {
        self.best.as_ref().map_or(upper, |(cost, _)| *cost)
    }

    /// The answer after a whole search with budget `upper`.
    pub fn closed(mut self, upper: i64) -> Self {
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

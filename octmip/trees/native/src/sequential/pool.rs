//! The trees worth keeping: the best one, or all that no other beats in both error and cost.

use crate::tree::Tree;

/// A tree with its two sums.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    /// Sum over leaves, splits and delay costs.
    pub(crate) error: f64,
    /// Sum over the sensors read.
    pub(crate) cost: f64,
    /// The tree.
    pub(crate) tree: Tree,
}

/// Goal of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Goal {
    /// The least `error + multiplier * cost`.
    Best,
    /// Every tree below the room that no other beats in both.
    Front,
    /// The least error below `below` with a cost of at most `cap`.
    Capped {
        /// Most cost.
        cap: f64,
        /// Least error known.
        below: f64,
    },
}

/// Trees found at a node.
#[derive(Debug)]
pub(crate) struct Pool {
    goal: Goal,
    multiplier: f64,
    /// Only trees whose weighed sum is less are of interest.
    pub(crate) room: f64,
    /// Trees that were kept.
    pub(crate) points: Vec<Point>,
}

/// Trees, and a number below which the weighed sum of no tree of the node lies.
#[derive(Debug)]
pub(crate) struct Found {
    /// Trees below the room.
    pub(crate) points: Vec<Point>,
    /// The bound.
    pub(crate) bound: f64,
}

impl Pool {
    /// An empty pool.
    pub(crate) fn new(goal: Goal, multiplier: f64, room: f64) -> Self {
        Self { goal, multiplier, room, points: Vec::new() }
    }

    /// Keep a tree if it is of interest.
    pub(crate) fn offer(&mut self, error: f64, cost: f64, tree: impl FnOnce() -> Tree) {
        let sum = error + self.multiplier * cost;
        if sum >= self.room {
            return;
        }
        match self.goal {
            Goal::Best => {
                self.room = sum;
                self.points.clear();
            }
            Goal::Front => {
                if self.points.iter().any(|point| point.error <= error && point.cost <= cost) {
                    return;
                }
                self.points.retain(|point| point.error < error || point.cost < cost);
            }
            Goal::Capped { cap, below } => {
                if cost > cap || error >= below {
                    return;
                }
                // A better tree within the cap weighs less than this error and the whole cap.
                self.goal = Goal::Capped { cap, below: error };
                self.room = self.room.min(error + self.multiplier * cap);
                self.points.clear();
            }
        }
        self.points.push(Point { error, cost, tree: tree() });
    }

    /// Keep every point of interest of another pool of the same node.
    pub(crate) fn take(&mut self, points: Vec<Point>) {
        for point in points {
            self.offer(point.error, point.cost, || point.tree);
        }
    }

    /// Close the pool; `open` is the least bound of what was not looked at.
    pub(crate) fn found(self, open: f64) -> Found {
        let sums = self.points.iter().map(|point| point.error + self.multiplier * point.cost);
        let least = sums.fold(self.room, f64::min);
        let bound = if matches!(self.goal, Goal::Capped { .. }) { self.room } else { least }.min(open);
        Found { points: self.points, bound }
    }
}

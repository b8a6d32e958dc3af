//! The search from the root, and the search at one node.

use super::pool::{Found, Goal, Pool};
use super::problem::{Lanes, Path, SequentialProblem};
use super::samples::{Orders, Sums, add, cheapest, cheapest_label, padded, sorted};
use super::supervision::CutSupervision;
use crate::control::{KeepGoing, Limits, Stop};
use crate::costs::least_and_most;
use crate::tree::Tree;

/// Result of a search.
#[derive(Debug)]
pub struct SequentialResult {
    /// The best tree below the room, if there is one.
    pub tree: Option<Tree>,
    /// No tree of the problem weighs less (with a cap: none within the cap has a smaller error).
    pub bound: f64,
    /// Why the search ended.
    pub stop: Stop,
    /// Cuts evaluated.
    pub n_cuts: u64,
}

/// Data and supervision of the search, shared by all nodes.
pub(crate) struct Search<'a> {
    /// The problem.
    pub(crate) problem: &'a SequentialProblem,
    /// Costs of the labels, a row of lanes per sample.
    pub(crate) paid: Vec<Lanes>,
    /// Cost range of each sample: its most expensive label less its cheapest.
    pub(crate) ranges: Vec<f64>,
    /// Cost of each sample's most expensive label.
    pub(crate) most: Vec<f64>,
    /// Limits and Ctrl-C.
    pub(crate) supervision: CutSupervision<'a>,
}

/// Return the best tree that weighs less than `room` (with a cap: whose error is less).
pub fn solve(problem: &SequentialProblem, room: f64, limits: Limits, going: KeepGoing<'_>) -> SequentialResult {
    let rows = problem.paid.chunks(problem.n_classes).map(least_and_most);
    let (most, ranges) = rows.map(|(least, most)| (most, most - least)).unzip();
    let orders = sorted(problem);
    let (goal, added) = match problem.cap {
        Some(cap) => (Goal::Capped { cap, below: room }, problem.multiplier * cap),
        None => (Goal::Best, 0.0),
    };
    let supervision = CutSupervision::new(limits, added, going);
    let mut search = Search { problem, paid: padded(problem), ranges, most, supervision };
    let found = search.best(&orders, problem.depth, problem.start(), room + added, goal);
    let stop = search.supervision.stop().unwrap_or(Stop::Optimal);
    let tree = found.points.first().map(|point| point.tree.clone());
    let found_cost = found.points.first().map_or(room, |point| match goal {
        Goal::Capped { .. } => point.error,
        _ => point.error + problem.multiplier * point.cost,
    });
    let bound = if stop == Stop::Optimal { found_cost } else { found_cost.min(found.bound - added) };
    SequentialResult { tree, bound, stop, n_cuts: search.supervision.n_cuts }
}

impl Search<'_> {
    /// The trees of at most `depth` levels for the samples of `orders` that weigh less than `room`.
    pub(crate) fn best(&mut self, orders: &Orders, depth: usize, path: Path, room: f64, goal: Goal) -> Found {
        let sums = self.sums(orders[0].iter().map(|entry| entry.sample));
        let inner = if goal == Goal::Best { Goal::Best } else { Goal::Front };
        if depth == 1 {
            let nothing = self.sums(std::iter::empty());
            let is_left = vec![true; self.problem.n];
            let [found, _] = self.stumps(orders, &is_left, [&sums, &nothing], path, [room, 0.0], inner);
            if inner == goal {
                return found;
            }
            let mut pool = Pool::new(goal, self.problem.multiplier, room);
            pool.take(found.points);
            return pool.found(f64::INFINITY);
        }
        let mut pool = Pool::new(goal, self.problem.multiplier, room);
        let closed = self.problem.closed_labels(path.n_read);
        pool.offer(cheapest(&sums.labels, &closed), 0.0, || Tree::leaf(cheapest_label(&sums.labels, &closed)));
        if depth == 0 {
            return pool.found(f64::INFINITY);
        }
        if goal == Goal::Best {
            // A tree of one level fewer is soon found and leaves less room.
            let shallow = self.best(orders, depth - 1, path, pool.room, goal);
            pool.take(shallow.points);
        }
        let open = self.cuts(orders, &sums, depth, path, &mut pool, inner);
        pool.found(open)
    }

    /// Sums over samples.
    pub(crate) fn sums(&self, samples: impl Iterator<Item = u32>) -> Sums {
        let chunks = self.problem.n_classes.div_ceil(8);
        let mut sums = Sums { count: 0, frequency: 0.0, delay_cost: 0.0, labels: vec![[0.0; 8]; chunks] };
        for sample in samples.map(|sample| sample as usize) {
            sums.count += 1;
            sums.frequency += self.problem.frequency[sample];
            sums.delay_cost += self.problem.delay_costs[sample];
            add(&mut sums.labels, &self.paid[sample * chunks..(sample + 1) * chunks]);
        }
        sums
    }

    /// Error and cost that one split adds for the samples of `sums`.
    pub(crate) fn charge(&self, sums: &Sums, path: Path, next: Path, price: f64) -> (f64, f64) {
        let delay_cost = if next.n_read > path.n_read { sums.delay_cost } else { 0.0 };
        (self.problem.penalty + delay_cost, sums.frequency * price)
    }
}

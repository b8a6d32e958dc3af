//! Branch and bound over the cuts of one node.

use std::collections::BinaryHeap;

use super::pool::{Found, Goal, Pool};
use super::problem::Path;
use super::run::{End, Run};
use super::samples::{Orders, Sums, side_of};
use super::solve::Search;
use crate::tree::Tree;

/// The cuts of one feature at a node.
struct Feature {
    /// Number of samples left of each cut.
    places: Vec<usize>,
    /// Their stretches, summed.
    stretches: Vec<f64>,
    /// Error and cost that its split adds, and both weighed.
    charge: (f64, f64),
    weighed: f64,
    next: Path,
}

impl Search<'_> {
    /// Put every tree of interest with a split at this node into the pool; return the least bound left open.
    pub(crate) fn cuts(
        &mut self,
        orders: &Orders,
        sums: &Sums,
        depth: usize,
        path: Path,
        pool: &mut Pool,
        inner: Goal,
    ) -> f64 {
        let features: Vec<Option<Feature>> =
            (0..self.problem.p).map(|feature| self.feature(orders, sums, depth, path, feature)).collect();
        let mut queue: BinaryHeap<Run> = features
            .iter()
            .enumerate()
            .filter_map(|(feature, cuts)| Some(first_run(feature, cuts.as_ref()?)))
            .collect();
        let mut is_left = vec![false; self.problem.n];
        while let Some(run) = queue.pop() {
            let Some(cuts) = features[run.feature].as_ref().filter(|_| run.bound < pool.room) else { break };
            let Some(run) = self.trimmed(run, cuts, pool.room) else { continue };
            if depth == self.problem.depth {
                self.supervision.compare(run.bound, pool.room);
            }
            if self.supervision.must_stop() {
                return queue.iter().map(|other| other.bound).fold(run.bound, f64::min);
            }
            let cut = usize::midpoint(run.low, run.high);
            let list = &orders[run.feature];
            for (at, entry) in list.iter().enumerate() {
                is_left[entry.sample as usize] = at < cuts.places[cut];
            }
            let [left, right] = self.children(orders, &is_left, depth, (&run, cuts, cut), pool.room, inner);
            self.join(list[cuts.places[cut] - 1].rank, run.feature, cuts, pool, [&left, &right]);
            if self.supervision.stop().is_some() {
                return queue.iter().map(|other| other.bound).fold(run.bound, f64::min);
            }
            let solved = End { left: left.bound, right: right.bound, stretch: cuts.stretches[cut] };
            queue.extend(self.halves(run, cut, solved, cuts));
        }
        f64::INFINITY
    }

    fn feature(&self, orders: &Orders, sums: &Sums, depth: usize, path: Path, feature: usize) -> Option<Feature> {
        let problem = self.problem;
        if !problem.allowed[feature] {
            return None;
        }
        let (next, price) = problem.step(path, feature);
        let charge = self.charge(sums, path, next, price);
        let most_path = problem.multiplier * problem.most_path_cost(depth - 1);
        let (mut places, mut stretches, mut stretch) = (Vec::new(), Vec::new(), 0.0);
        for (at, pair) in orders[feature].windows(2).enumerate() {
            let sample = pair[0].sample as usize;
            stretch += self.most[sample]
                + problem.frequency[sample] * most_path
                + problem.delay_costs[sample] * (depth - 1) as f64;
            let is_large = at + 1 >= problem.leaf_size && sums.count - at > problem.leaf_size;
            if pair[0].rank < pair[1].rank && is_large {
                places.push(at + 1);
                stretches.push(stretch);
            }
        }
        let weighed = charge.0 + problem.multiplier * charge.1;
        (!places.is_empty()).then_some(Feature { places, stretches, charge, weighed, next })
    }

    /// The run without the cuts at its ends that cannot be of interest; None when nothing is left.
    fn trimmed(&self, mut run: Run, cuts: &Feature, room: f64) -> Option<Run> {
        let is_out = |run: &Run, cut: usize| {
            let (left, right) = run.children(cuts.stretches[cut], self.is_monotone());
            left + right + cuts.weighed >= room
        };
        while run.low <= run.high && is_out(&run, run.low) {
            run.low += 1;
        }
        while run.low < run.high && is_out(&run, run.high) {
            run.high -= 1;
        }
        (run.low <= run.high).then_some(run)
    }

    fn is_monotone(&self) -> bool {
        self.problem.leaf_size == 1
    }

    /// The two children of a cut, each looked for within what the pair may cost and the stretch to the end of the run:
    /// a child known to cost more than its own pair can afford rules out its neighbours too.
    fn children(
        &mut self,
        orders: &Orders,
        is_left: &[bool],
        depth: usize,
        (run, cuts, cut): (&Run, &Feature, usize),
        room: f64,
        inner: Goal,
    ) -> [Found; 2] {
        let (low, high) = run.children(cuts.stretches[cut], self.is_monotone());
        let here = cuts.stretches[cut];
        let slack = (here - cuts.stretches[run.low]).max(cuts.stretches[run.high] - here);
        let rest = room - cuts.weighed + slack;
        if depth == 2 {
            let samples = |left: bool| {
                let list = orders[0].iter().map(|entry| entry.sample);
                list.filter(move |&sample| is_left[sample as usize] == left)
            };
            let sums = [self.sums(samples(true)), self.sums(samples(false))];
            return self.stumps(orders, is_left, [&sums[0], &sums[1]], cuts.next, [rest - high, rest - low], inner);
        }
        let left = self.best(&side_of(orders, is_left, true), depth - 1, cuts.next, rest - high, inner);
        let right_room = rest - left.bound.max(low);
        let right = self.best(&side_of(orders, is_left, false), depth - 1, cuts.next, right_room, inner);
        [left, right]
    }

    fn join(&self, cut: u32, feature: usize, cuts: &Feature, pool: &mut Pool, [left, right]: [&Found; 2]) {
        for a in &left.points {
            for b in &right.points {
                pool.offer(a.error + b.error + cuts.charge.0, a.cost + b.cost + cuts.charge.1, || {
                    Tree::join(feature as u32, cut, &a.tree, &b.tree)
                });
            }
        }
    }

    /// The runs that are left when one of a run's cuts is solved.
    fn halves(&self, run: Run, cut: usize, solved: End, cuts: &Feature) -> Vec<Run> {
        let mut halves = Vec::with_capacity(2);
        if cut > run.low {
            halves.push(Run { high: cut - 1, after: solved, ..run.clone() });
        }
        if cut < run.high {
            halves.push(Run { low: cut + 1, before: solved, ..run });
        }
        for half in &mut halves {
            let nested = if self.is_monotone() { half.before.left + half.after.right } else { 0.0 };
            // The two stretch bounds add up to the same for every cut between.
            let apart = half.after.left + half.before.right - (half.after.stretch - half.before.stretch);
            half.bound = half.bound.max(cuts.weighed + nested.max(apart));
        }
        halves
    }
}

fn first_run(feature: usize, cuts: &Feature) -> Run {
    let nothing = f64::NEG_INFINITY;
    Run {
        feature,
        low: 0,
        high: cuts.places.len() - 1,
        before: End { left: 0.0, right: nothing, stretch: 0.0 },
        after: End { left: nothing, right: 0.0, stretch: 0.0 },
        bound: cuts.weighed,
    }
}

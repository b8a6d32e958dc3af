//! The search from the root, and the search at one node.

use super::pool::{Found, Goal, Pool};
use super::question::{Lanes, Path, Question};
use super::samples::{Orders, Sums, add, cheapest, cheapest_label, padded, sorted};
use super::watch::Watch;
use crate::control::{KeepGoing, Limits, Stop};
use crate::costs::least_and_most;
use crate::tree::Tree;

/// What a search returns.
#[derive(Debug)]
pub struct Answer {
    /// The best tree below the room, if there is one.
    pub tree: Option<Tree>,
    /// No tree of the question weighs less (with a cap: none within the cap has a smaller error).
    pub bound: f64,
    /// Why the search ended.
    pub stop: Stop,
    /// Cuts evaluated.
    pub n_cuts: u64,
}

/// What the search at every node needs.
pub struct Search<'a> {
    /// The question.
    pub question: &'a Question,
    /// Costs of the labels, a row of lanes a sample.
    pub paid: Vec<Lanes>,
    /// Dearest label less cheapest, by sample.
    pub swing: Vec<f64>,
    /// Dearest label, by sample.
    pub dearest: Vec<f64>,
    /// Time and Ctrl-C.
    pub watch: Watch<'a>,
}

/// Return the best tree that weighs less than `room` (with a cap: whose error is less).
pub fn solve(question: &Question, room: f64, limits: Limits, going: KeepGoing<'_>) -> Answer {
    let rows = question.paid.chunks(question.n_classes).map(least_and_most);
    let (dearest, swing) = rows.map(|(least, most)| (most, most - least)).unzip();
    let orders = sorted(question);
    let (goal, added) = match question.cap {
        Some(cap) => (Goal::Capped { cap, below: room }, question.multiplier * cap),
        None => (Goal::Best, 0.0),
    };
    let watch = Watch::new(limits, added, going);
    let mut search = Search { question, paid: padded(question), swing, dearest, watch };
    let found = search.best(&orders, question.depth, question.start(), room + added, goal);
    let stop = search.watch.stop().unwrap_or(Stop::Optimal);
    let tree = found.points.first().map(|point| point.tree.clone());
    let reached = found.points.first().map_or(room, |point| match goal {
        Goal::Capped { .. } => point.error,
        _ => point.error + question.multiplier * point.cost,
    });
    let bound = if stop == Stop::Optimal { reached } else { reached.min(found.bound - added) };
    Answer { tree, bound, stop, n_cuts: search.watch.n_cuts }
}

impl Search<'_> {
    /// The trees of at most `depth` levels for the samples of `orders` that weigh less than `room`.
    pub fn best(&mut self, orders: &Orders, depth: usize, path: Path, room: f64, goal: Goal) -> Found {
        let sums = self.sums(orders[0].iter().map(|entry| entry.sample));
        let inner = if goal == Goal::Best { Goal::Best } else { Goal::Front };
        if depth == 1 {
            let nothing = self.sums(std::iter::empty());
            let is_left = vec![true; self.question.n];
            let [found, _] = self.stumps(orders, &is_left, [&sums, &nothing], path, [room, 0.0], inner);
            if inner == goal {
                return found;
            }
            let mut pool = Pool::new(goal, self.question.multiplier, room);
            pool.take(found.points);
            return pool.found(f64::INFINITY);
        }
        let mut pool = Pool::new(goal, self.question.multiplier, room);
        let closed = self.question.closed_labels(path.n_read);
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

    /// What samples add up to.
    pub fn sums(&self, samples: impl Iterator<Item = u32>) -> Sums {
        let chunks = self.question.n_classes.div_ceil(8);
        let mut sums = Sums { count: 0, frequency: 0.0, haste: 0.0, labels: vec![[0.0; 8]; chunks] };
        for sample in samples.map(|sample| sample as usize) {
            sums.count += 1;
            sums.frequency += self.question.frequency[sample];
            sums.haste += self.question.haste[sample];
            add(&mut sums.labels, &self.paid[sample * chunks..(sample + 1) * chunks]);
        }
        sums
    }

    /// Error and cost that one split adds for the samples of `sums`.
    pub fn charge(&self, sums: &Sums, path: Path, next: Path, price: f64) -> (f64, f64) {
        let haste = if next.n_read > path.n_read { sums.haste } else { 0.0 };
        (self.question.penalty + haste, sums.frequency * price)
    }
}

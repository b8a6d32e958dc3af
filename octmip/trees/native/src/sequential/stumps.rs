//! The best stumps of the two sides of a cut in one pass over the lists of their node.

use super::pool::{Found, Goal, Pool};
use super::problem::{Lanes, Path};
use super::samples::{Orders, Sums, add, cheapest, cheapest_label, cheapest_rest};
use super::solve::Search;
use crate::tree::Tree;

/// State of one side in a sweep along one feature.
struct Sweep {
    left: Vec<Lanes>,
    count: usize,
    rank: u32,
    /// Stretch passed since the last look, and how much must pass before a better cut is possible.
    passed: f64,
    wait: f64,
    /// Only leaves that cost less in sum are of interest.
    limit: f64,
    cut: Option<u32>,
}

impl Search<'_> {
    /// The best leaf or stump of each side, `is_left` by sample, both after the readings of `path`.
    pub(crate) fn stumps(
        &self,
        orders: &Orders,
        is_left: &[bool],
        sums: [&Sums; 2],
        path: Path,
        rooms: [f64; 2],
        goal: Goal,
    ) -> [Found; 2] {
        let problem = self.problem;
        let closed = problem.closed_labels(path.n_read);
        let mut pools = rooms.map(|room| Pool::new(goal, problem.multiplier, room));
        for (pool, sum) in pools.iter_mut().zip(sums) {
            pool.offer(cheapest(&sum.labels, &closed), 0.0, || Tree::leaf(cheapest_label(&sum.labels, &closed)));
        }
        for feature in (0..problem.p).filter(|&feature| problem.allowed[feature]) {
            let (next, price) = problem.step(path, feature);
            let closed = problem.closed_labels(next.n_read);
            let charges = [0, 1].map(|side| self.charge(sums[side], path, next, price));
            let limits = [0, 1].map(|side| pools[side].room - charges[side].0 - problem.multiplier * charges[side].1);
            let sweeps = self.sweep(&orders[feature], is_left, sums, &closed, limits);
            for (side, sweep) in sweeps.into_iter().enumerate() {
                let Some(cut) = sweep.cut else { continue };
                let (left, right) = self.labels_at(&orders[feature], is_left, side, cut, &closed);
                pools[side].offer(charges[side].0 + sweep.limit, charges[side].1, || {
                    Tree::join(feature as u32, cut, &Tree::leaf(left), &Tree::leaf(right))
                });
            }
        }
        pools.map(|pool| pool.found(f64::INFINITY))
    }

    fn sweep(
        &self,
        list: &[super::samples::Entry],
        is_left: &[bool],
        sums: [&Sums; 2],
        closed: &[Lanes],
        limits: [f64; 2],
    ) -> [Sweep; 2] {
        let (chunks, least) = (closed.len(), self.problem.leaf_size);
        let mut sweeps = limits.map(|limit| Sweep {
            left: vec![[0.0; 8]; chunks],
            count: 0,
            rank: u32::MAX,
            passed: 0.0,
            wait: f64::NEG_INFINITY,
            limit,
            cut: None,
        });
        if limits.iter().all(|&limit| limit <= 0.0) {
            return sweeps;
        }
        for entry in list {
            let sample = entry.sample as usize;
            let side = usize::from(!is_left[sample]);
            let sweep = &mut sweeps[side];
            if entry.rank != sweep.rank {
                let is_large = sweep.count >= least && sums[side].count - sweep.count >= least;
                // A sample that changes sides lowers the sum by its cost range at most: it leaves a label and enters
                // one.
                if sweep.passed > sweep.wait && is_large {
                    let rest = cheapest_rest(&sums[side].labels, &sweep.left, closed);
                    let value = cheapest(&sweep.left, closed) + rest;
                    if value < sweep.limit {
                        (sweep.limit, sweep.cut) = (value, Some(sweep.rank));
                    }
                    (sweep.passed, sweep.wait) = (0.0, value - sweep.limit);
                }
                sweep.rank = entry.rank;
            }
            sweep.count += 1;
            sweep.passed += self.ranges[sample];
            add(&mut sweep.left, &self.paid[sample * chunks..(sample + 1) * chunks]);
        }
        sweeps
    }

    fn labels_at(
        &self,
        list: &[super::samples::Entry],
        is_left: &[bool],
        side: usize,
        cut: u32,
        closed: &[Lanes],
    ) -> (u32, u32) {
        let chunks = closed.len();
        let mut sums = [vec![[0.0; 8]; chunks], vec![[0.0; 8]; chunks]];
        for entry in list {
            let sample = entry.sample as usize;
            if usize::from(!is_left[sample]) == side {
                let at = usize::from(entry.rank > cut);
                add(&mut sums[at], &self.paid[sample * chunks..(sample + 1) * chunks]);
            }
        }
        (cheapest_label(&sums[0], closed), cheapest_label(&sums[1], closed))
    }
}

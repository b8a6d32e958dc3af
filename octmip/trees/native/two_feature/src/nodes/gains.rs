//! Gains of slope intervals: what a split in one of them saves at most of the most that a set of samples can cost.
//!
//! With most(S) the sum of the largest costs of a set, a split saves most(S) - cost(S). Of a subset T it saves no more:
//! cost(S) <= cost(T) + most(S without T), as the same split and labels serve S, and no leaf has shrunk; so
//! most(T) - cost(T) <= most(S) - cost(S). The largest saving that an interval was once found to hold for the samples
//! of a child with all open ones therefore holds in every node inside, where these samples have become fewer. In
//! costs: cost(T) >= most(T) - gain, and where T has samples beyond those that the gain speaks of, cost(T) is no less
//! than that of those within.
//!
//! Most nodes are bounded but once, by samples settled and open together, and a full scan of all dual planes is what
//! that costs. One scan of a node around them tells which intervals can matter in any of them.

use std::sync::Arc;

use crate::loss::INFEASIBLE;
use crate::nodes::known::Notes;
use crate::nodes::node::{Child, Node, Partition, SearchContext};
use crate::regions::slope_interval::SlopeInterval;
use crate::stumps::histograms::Most;
use crate::stumps::search::StumpTask;

/// Gains are learnt again when so many times fewer samples are open.
const FEWER: usize = 2;

impl SearchContext<'_> {
    /// The most that the samples of a child with all open ones can cost; None where gains are switched off.
    pub(crate) fn most(&self, child: &Child, partition: &Partition, s: usize) -> Option<Most> {
        let samples = self.instance.samples();
        let beyond: Vec<u32> = partition.wide[s].iter().copied().filter(|&i| !holds(&child.within, i)).collect();
        let all = samples.loss.most(&partition.wide_tallies[s]);
        let known = all - samples.loss.most(&samples.tally(&beyond));
        self.instance.switches.gains.then_some(Most { all, known })
    }

    /// Learn the gains of the intervals of both children for all nodes inside, without solving any stump.
    pub(crate) fn learn_gains(&self, root: &mut Node, partition: &Partition, notes: &Notes<'_>) {
        let switches = self.instance.switches;
        let is_time = self.is_time_to_learn(root.n_learnt, partition);
        if !(switches.wide && is_time && notes.is_wide_worth_while()) {
            return;
        }
        root.n_learnt = partition.open.len();
        for s in [0, 1] {
            // No region is split: `lower` of the result is no bound, and is not looked at.
            let task = StumpTask { most_tried: 0, ..self.wide_task(root, partition, s, [INFEASIBLE, 0]) };
            let mut intervals = root.children[s].intervals.to_vec();
            let line = self.solve_stump(&root.children[s], task, &mut intervals).line;
            let child = &mut root.children[s];
            child.remember(line);
            child.intervals = Arc::new(intervals);
            child.narrow_within(&partition.wide[s]);
        }
    }

    /// Whether so few samples are open that scanning for all nodes inside pays.
    pub(crate) fn is_time_to_learn(&self, n_learnt: usize, partition: &Partition) -> bool {
        self.instance.switches.gains && partition.open.len() * FEWER <= n_learnt
    }

    /// Keep the intervals after the bound of a child with all open samples, if that says enough that is new.
    pub(crate) fn keep_wide_intervals(
        &self,
        child: &mut Child,
        intervals: Vec<SlopeInterval>,
        dead: i64,
        (ids, learns): (&[u32], bool),
    ) {
        let switches = self.instance.switches;
        let n_alive = intervals.iter().filter(|interval| interval.bound < dead).count();
        // A copy in every node is too much memory; those that learn gains have one for all nodes inside.
        if !switches.gains || learns || n_alive * 4 <= child.intervals.len() * 3 {
            child.keep_intervals_below(intervals, dead, switches);
            child.narrow_within(ids);
        }
    }
}

impl Child {
    /// The gains of the intervals have been learnt for these samples, and still hold for those before.
    fn narrow_within(&mut self, ids: &[u32]) {
        let mut bits = vec![0; self.within.len()];
        ids.iter().for_each(|&i| bits[i as usize / 64] |= 1 << (i % 64));
        self.within = self.within.iter().zip(bits).map(|(old, new)| old & new).collect();
    }
}

fn holds(set: &[u64], i: u32) -> bool {
    set[i as usize / 64] >> (i % 64) & 1 == 1
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use fastrand::Rng;

    use super::*;
    use crate::depth_two::intervals_of;
    use crate::instance::Instance;
    use crate::nodes::known::Known;
    use crate::regions::region::split;
    use octmip_check::problem::{Planes, Problem};
    use octmip_oracle::problem_of_ranks;

    fn random_problem(seed: u64) -> Problem {
        let (mut rng, n, k) = (Rng::with_seed(seed), 90, 3);
        let values = (0..2 * n).map(|_| rng.f64()).collect();
        let labels: Vec<u32> = (0..n).map(|_| rng.u32(0..k as u32)).collect();
        Problem {
            n_classes: k,
            n_ranks: vec![2 * n as u32; 2],
            weights: (0..n).map(|_| rng.i64(1..4)).collect(),
            costs: (0..k * k).map(|at| if at % (k + 1) == 0 { 0 } else { rng.i64(1..6) }).collect(),
            penalty: rng.i64(0..3),
            planes: Some(Planes { values, split_size: 2, groups: None, integer_normals: None }),
            ..problem_of_ranks(&(0..2 * n as u32).collect::<Vec<u32>>(), &labels)
        }
    }

    #[test]
    fn no_split_of_fewer_samples_saves_more_than_its_interval_was_found_to() {
        let stop = AtomicBool::new(false);
        let mut n_compared = 0;
        for seed in 0..3 {
            let problem = random_problem(seed);
            let instance = Instance::new(&problem);
            let context = SearchContext::new(&problem, &instance, 16, &stop).unwrap();
            let intervals = intervals_of(&context, &[true; 2]);
            let (features, place) = (context.dual_planes[2].features, context.dual_planes[2].region((2, 9), (20, 50)));
            let children = [0, 1].map(|_| Child::new(intervals.clone(), problem.n));
            let mut node = Node { dual_plane: 2, region: place, key: 0, children, n_learnt: 2 * problem.n };
            let around = context.partition(features, &place);
            context.learn_gains(&mut node, &around, &Notes::new(&Known::new(&instance, 1)));
            for region in split(&instance.plane, features, &place, &around.open, None) {
                let inside = context.partition(features, &region);
                for (s, child) in node.children.iter().enumerate() {
                    let most = context.most(child, &inside, s).unwrap();
                    // Lines of other intervals would be better.
                    let alone = Child { lines: Vec::new(), ..child.clone() };
                    let leaf = instance.loss.leaf(&inside.wide_tallies[s]).0;
                    for interval in child.intervals.iter() {
                        let task = StumpTask { most: None, ..context.wide_task(&node, &inside, s, [INFEASIBLE, 0]) };
                        let lower = context.solve_stump(&alone, task, &mut vec![*interval]).lower;
                        assert!(lower == leaf || lower >= most.known - interval.gain, "{lower} {most:?} {interval:?}");
                        n_compared += usize::from(lower < leaf && interval.gain < INFEASIBLE);
                    }
                }
            }
        }
        assert!(n_compared > 20, "{n_compared}");
    }
}

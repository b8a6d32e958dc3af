//! Gains of slope intervals: what a split in one of them saves at most of the most that a set of samples can cost.
//!
//! With most(S) the sum of the largest costs of a set, a split saves most(S) - cost(S). Of a subset T it saves no more:
//! cost(S) <= cost(T) + most(S without T), as the same split and labels serve S, and no leaf has shrunk; so
//! most(T) - cost(T) <= most(S) - cost(S). The largest saving that an interval was once found to hold for the samples
//! of a child with all open ones therefore holds in every node inside, where these samples have become fewer. In costs:
//! cost(T) >= most(T) - gain, and where T has samples beyond those that the gain speaks of, cost(T) is no less than that
//! of those within.
//!
//! Most nodes are bounded but once, by samples settled and open together, and a full scan of all dual planes is what
//! that costs. One scan of a node around them tells which intervals can matter in any of them.

use std::sync::Arc;

use crate::two_feature::loss::INFEASIBLE;
use crate::two_feature::nodes::known::Notes;
use crate::two_feature::nodes::node::{Child, Node, Partition, SearchContext};
use crate::two_feature::regions::slope_interval::SlopeInterval;
use crate::two_feature::stumps::histograms::Most;
use crate::two_feature::stumps::search::StumpTask;

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
        let is_time = partition.open.len() * FEWER <= root.n_learnt;
        if !(switches.gains && switches.wide && is_time && notes.is_wide_worth_while()) {
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

    /// Keep the intervals after the bound of a child with all open samples, if that says enough that is new.
    pub(crate) fn keep_wide_intervals(
        &self,
        child: &mut Child,
        intervals: Vec<SlopeInterval>,
        dead: i64,
        ids: &[u32],
    ) {
        let switches = self.instance.switches;
        let n_alive = intervals.iter().filter(|interval| interval.bound < dead).count();
        // A copy in every node is too much memory; those that learn gains have one for all nodes inside.
        if !switches.gains || n_alive * 4 <= child.intervals.len() * 3 {
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

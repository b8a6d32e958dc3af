//! Bounds of a node, the cheaper ones first.

use std::sync::atomic::Ordering;

use crate::geometry::line::Line;
use crate::label_count::{label_count_bound, two_labels_at_least};
use crate::loss::INFEASIBLE;
use crate::nodes::known::Notes;
use crate::nodes::node::{Child, Goal, Node, Partition, SearchContext};
use crate::regions::slope_interval::SlopeInterval;
use crate::stumps::search::{StumpResult, StumpTask};
use crate::stumps::solver::best_split;
use crate::weighted_samples::sum;

impl SearchContext<'_> {
    /// The incumbent of a child over some samples: cost and line of the best of a leaf and these lines.
    pub(crate) fn incumbent<'l>(
        &self,
        lines: impl Iterator<Item = &'l Line>,
        ids: &[u32],
        tally: &[i64],
        need: i64,
    ) -> (i64, Option<Line>) {
        let samples = self.instance.samples();
        lines.fold((self.leaf(tally, need), None), |best, line| {
            let cost = samples.cost_of(line, ids, tally, need);
            if cost < best.0 && line.is_clear_of(samples.plane, ids) { (cost, Some(*line)) } else { best }
        })
    }

    /// The incumbents of both children without the open samples, and with all of them, among their own lines and those
    /// known elsewhere; their lines are kept. Open samples are sorted by a line once for all four.
    fn incumbents(&self, root: &mut Node, partition: &Partition, notes: &Notes<'_>) -> [[i64; 2]; 2] {
        let samples = self.instance.samples();
        let sorted = |line: &Line| (*line, samples.left_of(line, &partition.open));
        let known: Vec<(Line, Vec<i64>)> = notes.lines().map(sorted).collect();
        let needs = [self.need() - partition.open.len() as i64, self.need()];
        let mut costs = [[INFEASIBLE; 2]; 2];
        for (s, child) in root.children.iter_mut().enumerate() {
            let own: Vec<(Line, Vec<i64>)> = child.lines.iter().map(sorted).collect();
            let sets = [&partition.sides[s], &partition.wide[s]];
            let tallies = [&partition.tallies[s], &partition.wide_tallies[s]];
            let mut best = [0, 1].map(|k| (self.leaf(tallies[k], needs[k]), None));
            for (line, open) in own.iter().chain(&known) {
                let settled = samples.left_of(line, sets[0]);
                let lefts = [sum(&settled, open), settled];
                for (k, left) in lefts.iter().rev().enumerate() {
                    let cost = samples.cost_of_left(line.features, left, tallies[k], needs[k]);
                    if cost < best[k].0 && line.is_clear_of(samples.plane, sets[k]) {
                        best[k] = (cost, Some(*line));
                    }
                }
            }
            for (k, (cost, line)) in best.into_iter().enumerate() {
                costs[k][s] = cost;
                child.remember(line);
            }
        }
        costs
    }

    fn leaf(&self, tally: &[i64], need: i64) -> i64 {
        let loss = &self.instance.loss;
        if tally[loss.k] >= need { loss.leaf(tally).0 } else { INFEASIBLE }
    }

    /// Bounds that other nodes have learnt of much the same samples.
    fn recall(&self, root: &mut Node, partition: &Partition, notes: &Notes<'_>) {
        for s in [0, 1] {
            let child = &mut root.children[s];
            let all = self.instance.loss.most(&partition.wide_tallies[s]);
            // Samples that left the set since the last bound lowered it by no more than they can cost.
            child.wide.0 -= child.wide.1 - all;
            child.wide.1 = all;
            child.floor = child.floor.max(notes.at_least([&partition.sides[s], &[]]));
            child.wide.0 = child.wide.0.max(notes.at_least([&partition.sides[s], &partition.open]));
        }
        self.raise_key_by_label_count(root, partition);
        if notes.keeps_sets() {
            let bound = root.children[0].wide.0 + root.children[1].wide.0 - partition.open_most + self.price(root);
            root.key = root.key.max(bound);
        }
    }

    /// Raise the key of a node as far as the target, by the cheaper bounds first.
    pub(crate) fn bound(&self, root: &mut Node, partition: &Partition, goal: Goal, notes: &mut Notes<'_>) {
        let target = goal.target;
        for s in [0, 1] {
            let child = &mut root.children[s];
            child.floor = child.floor.max(self.two_labels(&partition.tallies[s]));
        }
        self.raise_key_by_label_count(root, partition);
        if root.key >= target {
            return;
        }
        self.recall(root, partition, notes);
        if root.key >= target {
            return;
        }
        let price = self.price(root);
        let [narrow, wide] = self.incumbents(root, partition, notes);
        // No bound exceeds the incumbent: one that cannot reach the target is not worth its price.
        let narrow_reach = self.by_label_count(partition, narrow) + price;
        let wide_reach = wide[0] + wide[1] + price - partition.open_most;
        let mut order = [(narrow_reach, false), (wide_reach, true)];
        order.sort_by_key(|&(reach, _)| std::cmp::Reverse(reach));
        let switches = self.instance.switches;
        for (reach, is_wide) in order {
            let is_on = if is_wide { switches.wide && notes.is_wide_worth_while() } else { switches.narrow };
            let is_vain = reach < target && switches.reach;
            if !is_on || is_vain || root.key >= target || self.stop.load(Ordering::Relaxed) {
                continue;
            }
            if is_wide {
                self.bound_wide(root, partition, wide, goal, notes);
                notes.note_wide(root.key >= target);
            } else {
                self.bound_narrow(root, partition, narrow, goal, notes);
            }
        }
    }

    /// Least cost of a child when each of its samples may choose one of two labels: no stump names more, and in it some
    /// samples choose badly. Prices only add.
    pub(crate) fn two_labels(&self, tally: &[i64]) -> i64 {
        if self.instance.switches.two_labels { two_labels_at_least(&self.instance.loss, tally) } else { 0 }
    }

    /// The label-count bound of the children's costs.
    pub(crate) fn by_label_count(&self, partition: &Partition, costs: [i64; 2]) -> i64 {
        let tallies = [&partition.tallies[0][..], &partition.tallies[1]];
        if self.instance.switches.label_count {
            label_count_bound(&self.instance.loss, costs, tallies, &partition.open_tally)
        } else {
            costs[0] + costs[1]
        }
    }

    /// The least cost of child `s` that, with `other` for the other child, brings the label-count bound to `goal`.
    pub(crate) fn least_to_reach(&self, partition: &Partition, s: usize, other: i64, goal: i64) -> i64 {
        let (mut low, mut high) = (0, goal.max(0));
        while low < high {
            let middle = low + (high - low) / 2;
            let costs = if s == 0 { [middle, other] } else { [other, middle] };
            if self.by_label_count(partition, costs) >= goal {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        high
    }

    fn raise_key_by_label_count(&self, root: &mut Node, partition: &Partition) {
        let floors = [root.children[0].floor, root.children[1].floor];
        let bound = self.by_label_count(partition, floors) + self.price(root);
        root.key = root.key.max(bound);
    }

    /// The bound STUMP(L) + STUMP(R), joined by the label-count bound.
    ///
    /// The child of a root line of the node holds L and perhaps open samples; without these the same split costs no
    /// more, so STUMP(L) is at most its cost. A leaf size of m asks for m samples with the open ones: of L for m less
    /// those. Cutoffs and `hopeless` decide how far a bound is computed, never what it is.
    fn bound_narrow(
        &self,
        root: &mut Node,
        partition: &Partition,
        mut reach: [i64; 2],
        goal: Goal,
        notes: &mut Notes<'_>,
    ) {
        let Goal { target, upper } = goal;
        let (price, switches) = (self.price(root), self.instance.switches);
        // The larger child first: its bound is more expensive, but more often enough.
        let first = usize::from(partition.sides[1].len() > partition.sides[0].len());
        for s in [first, 1 - first] {
            let other = root.children[1 - s].floor;
            let task = StumpTask {
                ids: &partition.sides[s],
                need: self.need() - partition.open.len() as i64,
                cutoff: self.least_to_reach(partition, s, other, target - price),
                floor: root.children[s].floor,
                most_tried: usize::MAX,
                hopeless: self.least_to_reach(partition, s, reach[1 - s], target - price),
                dead: self.least_to_reach(partition, s, other, upper - price),
                less: 0,
                most: None,
            };
            let mut intervals = root.children[s].intervals.to_vec();
            let result = self.solve_stump(&root.children[s], task, &mut intervals);
            reach[s] = result.incumbent;
            let child = &mut root.children[s];
            child.floor = child.floor.max(result.lower);
            child.remember(result.line);
            child.keep_intervals_below(intervals, task.dead, switches);
            if result.lower > task.floor {
                let bound = result.lower.min(child.struck).min(task.dead);
                notes.add([&partition.sides[s], &[]], bound, result.line);
            }
            self.raise_key_by_label_count(root, partition);
            if root.key >= target || (result.incumbent < task.hopeless && switches.hopeless) {
                return;
            }
        }
    }

    /// The bound STUMP(L + O) + STUMP(R + O) - most(O).
    ///
    /// A root line parts O as O1 + O2. The left child's tree, O2 sent through it too, costs at most most(O2) more, and
    /// no leaf has shrunk: STUMP(L + O) <= cost(L + O1) + most(O2); likewise on the right; most(O1) + most(O2) =
    /// most(O).
    fn bound_wide(
        &self,
        root: &mut Node,
        partition: &Partition,
        mut reach: [i64; 2],
        goal: Goal,
        notes: &mut Notes<'_>,
    ) {
        let Goal { target, upper } = goal;
        let (price, most) = (self.price(root), partition.open_most);
        let switches = self.instance.switches;
        self.raise_wide_by_labels(root, partition);
        let learns = self.is_time_to_learn(root.n_learnt, partition);
        if learns {
            root.n_learnt = partition.open.len();
        }
        for s in [0, 1] {
            let owed = target - price + most;
            let task = self.wide_task(root, partition, s, [owed - root.children[1 - s].wide.0, owed - reach[1 - s]]);
            let dead = upper - price - root.children[1 - s].floor;
            let dead = if switches.dead_intervals { dead } else { INFEASIBLE };
            let mut intervals = root.children[s].intervals_below(dead);
            let result = self.solve_stump(&root.children[s], task, &mut intervals);
            reach[s] = result.incumbent;
            let child = &mut root.children[s];
            child.wide.0 = child.wide.0.max(result.lower);
            child.floor = child.floor.max(result.lower - task.less);
            child.remember(result.line);
            if result.lower > task.floor {
                notes.add([&partition.sides[s], &partition.open], result.lower.min(child.struck), result.line);
            }
            self.keep_wide_intervals(child, intervals, dead, (&partition.wide[s], learns));
            let bound = root.children[0].wide.0 + root.children[1].wide.0 - most + price;
            root.key = root.key.max(bound);
            if root.key >= target || (result.incumbent < task.hopeless && switches.hopeless) {
                return;
            }
        }
        self.raise_key_by_label_count(root, partition);
    }

    /// Raise the bounds of the children with all open samples by their other bounds.
    fn raise_wide_by_labels(&self, root: &mut Node, partition: &Partition) {
        for (child, tally) in root.children.iter_mut().zip(&partition.wide_tallies) {
            child.wide.0 = child.wide.0.max(child.floor).max(self.two_labels(tally));
        }
    }

    /// The stump of a child with all open samples, to be solved as far as the cutoff.
    pub(crate) fn wide_task<'p>(
        &self,
        root: &Node,
        partition: &'p Partition,
        s: usize,
        [cutoff, hopeless]: [i64; 2],
    ) -> StumpTask<'p> {
        let keeps_bound = self.instance.switches.dead_intervals || self.need() == 1;
        StumpTask {
            ids: &partition.wide[s],
            need: self.need(),
            cutoff,
            floor: root.children[s].wide.0,
            most_tried: usize::MAX,
            hopeless,
            // The bounds found here are of more samples than an interval's bound has to hold for: none is left out.
            dead: INFEASIBLE,
            // True of every child with leaves of the full size. A log speaks of children that lack samples (where no
            // interval is struck off), and may only say so where one sample fills a leaf.
            less: if keeps_bound { partition.open_most } else { INFEASIBLE },
            most: self.most(&root.children[s], partition, s),
        }
    }

    /// Solve the stump of a child in some of its slope intervals.
    pub(crate) fn solve_stump(
        &self,
        child: &Child,
        task: StumpTask<'_>,
        intervals: &mut Vec<SlopeInterval>,
    ) -> StumpResult {
        let lines = child.lines.iter().copied();
        let samples = self.instance.samples();
        best_split(samples, &self.dual_planes, task, lines, intervals, self.stop)
    }
}

//! Bounds of a box, the cheaper ones first.

use std::sync::atomic::Ordering;

use super::boxes::{Child, Field, Goal, RootBox, Sorted};
use super::known::Notes;
use super::labels::{two_labels_at_least, with_labels};
use super::loss::INFEASIBLE;
use super::strips::Strip;
use super::stump::{Answer, Question, best_split};
use super::view::Line;

impl Field<'_> {
    /// Best cost of a child over some samples by a leaf or one of these lines.
    pub(super) fn attained<'l>(
        &self,
        lines: impl Iterator<Item = &'l Line>,
        ids: &[u32],
        tally: &[i64],
        need: i64,
    ) -> (i64, Option<Line>) {
        let view = self.ground.view();
        let leaf = if tally[view.loss.k] >= need { view.loss.leaf(tally).0 } else { INFEASIBLE };
        lines.fold((leaf, None), |best, line| {
            let cost = view.cost_of(line, ids, tally, need);
            if cost < best.0 && line.is_clear_of(view.plane, ids) { (cost, Some(*line)) } else { best }
        })
    }

    /// Best cost of a child by what it remembers and what is known elsewhere; it remembers the best.
    fn attained_by_all(&self, child: &mut Child, notes: &Notes<'_>, ids: &[u32], tally: &[i64], need: i64) -> i64 {
        let (cost, line) = self.attained(child.lines.iter().chain(notes.lines()), ids, tally, need);
        child.remember(line);
        cost
    }

    /// Bounds that other boxes have learnt of much the same samples.
    fn recall(&self, root: &mut RootBox, sorted: &Sorted, notes: &Notes<'_>) {
        for s in [0, 1] {
            let child = &mut root.children[s];
            let all = self.ground.loss.most(&sorted.wide_tallies[s]);
            // Samples that left the set since the last bound lowered it by no more than they can cost.
            child.wide.0 -= child.wide.1 - all;
            child.wide.1 = all;
            child.floor = child.floor.max(notes.at_least([&sorted.sides[s], &[]]));
            child.wide.0 = child.wide.0.max(notes.at_least([&sorted.sides[s], &sorted.open]));
        }
        self.raise_key_by_labels(root, sorted);
        if notes.keeps_sets() {
            let bound = root.children[0].wide.0 + root.children[1].wide.0 - sorted.open_most + self.price(root);
            root.key = root.key.max(bound);
        }
    }

    /// Raise the key of a box as far as the target, by the cheaper bounds first.
    pub(super) fn bound(&self, root: &mut RootBox, sorted: &Sorted, goal: Goal, notes: &mut Notes<'_>) {
        let target = goal.target;
        for s in [0, 1] {
            let child = &mut root.children[s];
            child.floor = child.floor.max(self.two_labels(&sorted.tallies[s]));
        }
        self.raise_key_by_labels(root, sorted);
        if root.key >= target {
            return;
        }
        self.recall(root, sorted, notes);
        if root.key >= target {
            return;
        }
        let price = self.price(root);
        let relaxed = self.need() - sorted.open.len() as i64;
        let mut attained = |s: usize, ids: &[Vec<u32>; 2], tallies: &[Vec<i64>; 2], need: i64| {
            self.attained_by_all(&mut root.children[s], notes, &ids[s], &tallies[s], need)
        };
        let narrow = [0, 1].map(|s| attained(s, &sorted.sides, &sorted.tallies, relaxed));
        let wide = [0, 1].map(|s| attained(s, &sorted.wide, &sorted.wide_tallies, self.need()));
        // No bound exceeds what is attained: one that cannot reach the target is not worth its price.
        let narrow_reach = self.by_labels(sorted, narrow) + price;
        let wide_reach = wide[0] + wide[1] + price - sorted.open_most;
        let mut order = [(narrow_reach, false), (wide_reach, true)];
        order.sort_by_key(|&(reach, _)| std::cmp::Reverse(reach));
        let switches = self.ground.switches;
        for (reach, is_wide) in order {
            let is_on = if is_wide { switches.wide && notes.is_wide_worth_while() } else { switches.narrow };
            let is_vain = reach < target && switches.reach;
            if !is_on || is_vain || root.key >= target || self.stop.load(Ordering::Relaxed) {
                continue;
            }
            if is_wide {
                self.bound_wide(root, sorted, wide, goal, notes);
                notes.note_wide(root.key >= target);
            } else {
                self.bound_narrow(root, sorted, narrow, goal, notes);
            }
        }
    }

    /// What a child costs when each of its samples may choose one of two labels: no stump names more, and in it some
    /// samples choose badly. Prices only add.
    pub(super) fn two_labels(&self, tally: &[i64]) -> i64 {
        if self.ground.switches.two_labels { two_labels_at_least(&self.ground.loss, tally) } else { 0 }
    }

    pub(super) fn by_labels(&self, sorted: &Sorted, costs: [i64; 2]) -> i64 {
        let tallies = [&sorted.tallies[0][..], &sorted.tallies[1]];
        if self.ground.switches.labels_due {
            with_labels(&self.ground.loss, costs, tallies, &sorted.open_tally)
        } else {
            costs[0] + costs[1]
        }
    }

    /// The least cost of child `s` that, with `other` for the other child, brings the labels' bound to `goal`.
    pub(super) fn least_to_reach(&self, sorted: &Sorted, s: usize, other: i64, goal: i64) -> i64 {
        let (mut low, mut high) = (0, goal.max(0));
        while low < high {
            let middle = low + (high - low) / 2;
            let costs = if s == 0 { [middle, other] } else { [other, middle] };
            if self.by_labels(sorted, costs) >= goal {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        high
    }

    fn raise_key_by_labels(&self, root: &mut RootBox, sorted: &Sorted) {
        let floors = [root.children[0].floor, root.children[1].floor];
        let bound = self.by_labels(sorted, floors) + self.price(root);
        root.key = root.key.max(bound);
    }

    /// STUMP(L) + STUMP(R) with the labels' due.
    ///
    /// The child of a root line of the box holds L and perhaps open samples; without these the same split costs no more,
    /// so STUMP(L) is at most its cost. A leaf size of m asks for m samples with the open ones: of L for m less those.
    /// Cutoffs and `hopeless` decide how far a bound is computed, never what it is.
    fn bound_narrow(
        &self,
        root: &mut RootBox,
        sorted: &Sorted,
        mut reach: [i64; 2],
        goal: Goal,
        notes: &mut Notes<'_>,
    ) {
        let Goal { target, upper } = goal;
        let (price, switches) = (self.price(root), self.ground.switches);
        // The larger child first: its bound is dearer, but oftener enough.
        let first = usize::from(sorted.sides[1].len() > sorted.sides[0].len());
        for s in [first, 1 - first] {
            let other = root.children[1 - s].floor;
            let question = Question {
                ids: &sorted.sides[s],
                need: self.need() - sorted.open.len() as i64,
                cutoff: self.least_to_reach(sorted, s, other, target - price),
                floor: root.children[s].floor,
                most_tried: usize::MAX,
                hopeless: self.least_to_reach(sorted, s, reach[1 - s], target - price),
                dead: self.least_to_reach(sorted, s, other, upper - price),
                less: 0,
            };
            let mut strips = root.children[s].strips.to_vec();
            let answer = self.ask(&root.children[s], question, &mut strips);
            reach[s] = answer.attained;
            let child = &mut root.children[s];
            child.floor = child.floor.max(answer.lower);
            child.remember(answer.line);
            child.keep_strips_below(strips, question.dead, switches);
            if answer.lower > question.floor {
                let bound = answer.lower.min(child.struck).min(question.dead);
                notes.add([&sorted.sides[s], &[]], bound, answer.line);
            }
            self.raise_key_by_labels(root, sorted);
            if root.key >= target || (answer.attained < question.hopeless && switches.hopeless) {
                return;
            }
        }
    }

    /// STUMP(L + O) + STUMP(R + O) - most(O).
    ///
    /// A root line parts O as O1 + O2. The left child's tree, O2 sent through it too, costs at most most(O2) more, and no
    /// leaf has shrunk: STUMP(L + O) <= cost(L + O1) + most(O2); likewise on the right; most(O1) + most(O2) = most(O).
    fn bound_wide(&self, root: &mut RootBox, sorted: &Sorted, mut reach: [i64; 2], goal: Goal, notes: &mut Notes<'_>) {
        let Goal { target, upper } = goal;
        let (price, most) = (self.price(root), sorted.open_most);
        let switches = self.ground.switches;
        for s in [0, 1] {
            let by_classes = self.two_labels(&sorted.wide_tallies[s]);
            let child = &mut root.children[s];
            child.wide.0 = child.wide.0.max(child.floor).max(by_classes);
        }
        for s in [0, 1] {
            let other = &root.children[1 - s];
            let question = Question {
                ids: &sorted.wide[s],
                need: self.need(),
                cutoff: target - price + most - other.wide.0,
                floor: root.children[s].wide.0,
                most_tried: usize::MAX,
                hopeless: target - price + most - reach[1 - s],
                // What is learnt here is of more samples than a strip's bound has to hold for: it kills none.
                dead: INFEASIBLE,
                // True of every child with leaves of the full size. A log speaks of children that lack samples (where no
                // strip is struck off), and may only say so where one sample fills a leaf.
                less: if switches.dead_strips || self.need() == 1 { most } else { INFEASIBLE },
            };
            let less = question.less;
            let dead = upper - price - other.floor;
            let dead = if switches.dead_strips { dead } else { INFEASIBLE };
            let alive = root.children[s].strips.iter().filter(|s| s.bound < dead);
            let mut strips: Vec<Strip> = alive.copied().collect();
            if strips.len() < root.children[s].strips.len() {
                root.children[s].struck = root.children[s].struck.min(dead);
            }
            let answer = self.ask(&root.children[s], question, &mut strips);
            reach[s] = answer.attained;
            let child = &mut root.children[s];
            child.wide.0 = child.wide.0.max(answer.lower);
            child.floor = child.floor.max(answer.lower - less);
            child.remember(answer.line);
            if answer.lower > question.floor {
                notes.add([&sorted.sides[s], &sorted.open], answer.lower.min(child.struck), answer.line);
            }
            child.keep_strips_below(strips, dead, switches);
            let bound = root.children[0].wide.0 + root.children[1].wide.0 - most + price;
            root.key = root.key.max(bound);
            if root.key >= target || (answer.attained < question.hopeless && switches.hopeless) {
                return;
            }
        }
        self.raise_key_by_labels(root, sorted);
    }

    pub(super) fn ask(&self, child: &Child, question: Question<'_>, strips: &mut Vec<Strip>) -> Answer {
        let lines = child.lines.iter().copied();
        let view = self.ground.view();
        best_split(view, &self.charts, question, lines, strips, self.stop)
    }
}

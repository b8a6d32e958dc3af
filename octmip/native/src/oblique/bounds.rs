//! Bounds of a box, the cheaper ones first.

use std::sync::atomic::Ordering;

use super::boxes::{Child, Field, RootBox, Sorted};
use super::labels::{two_labels_at_least, with_labels};
use super::loss::INFEASIBLE;
use super::stump::{Answer, Question, Strip, best_split};
use super::view::Line;

/// What a bound is computed for.
#[derive(Clone, Copy)]
pub(super) struct Goal {
    /// A bound of this much is enough for now.
    pub(super) target: i64,
    /// Trees of this much and more are of no interest.
    pub(super) upper: i64,
}

impl Field<'_> {
    /// Best cost of a child over some samples by a leaf or the lines it remembers.
    pub(super) fn attained(
        &self,
        child: &Child,
        ids: &[u32],
        tally: &[i64],
        need: i64,
    ) -> (i64, Option<Line>) {
        let view = self.ground.view();
        let leaf = if tally[view.loss.k] >= need {
            view.loss.leaf(tally).0
        } else {
            INFEASIBLE
        };
        child.lines.iter().fold((leaf, None), |best, line| {
            let cost = view.cost_of(line, ids, tally, need);
            if cost < best.0 && line.is_clear_of(view.plane, ids) {
                (cost, Some(*line))
            } else {
                best
            }
        })
    }

    /// Raise the key of a box as far as the target, by the cheaper bounds first.
    pub(super) fn bound(&self, root: &mut RootBox, sorted: &Sorted, goal: Goal) {
        let target = goal.target;
        for s in [0, 1] {
            let child = &mut root.children[s];
            let by_classes = two_labels_at_least(&self.ground.loss, &sorted.tallies[s]);
            child.floor = child.floor.max(by_classes);
        }
        self.raise_key_by_labels(root, sorted);
        if root.key >= target {
            return;
        }
        let price = self.price(root);
        let relaxed = self.need() - sorted.open.len() as i64;
        let narrow = [0, 1].map(|s| {
            self.attained(
                &root.children[s],
                &sorted.sides[s],
                &sorted.tallies[s],
                relaxed,
            )
            .0
        });
        // No bound exceeds what is attained: one that cannot reach the target is not worth its price.
        let narrow_reach = self.by_labels(sorted, narrow) + price;
        let wide = [0, 1].map(|s| {
            self.attained(
                &root.children[s],
                &sorted.wide[s],
                &sorted.wide_tallies[s],
                self.need(),
            )
            .0
        });
        let wide_reach = wide[0] + wide[1] + price - sorted.open_most;
        let mut order = [(narrow_reach, false), (wide_reach, true)];
        order.sort_by_key(|&(reach, _)| std::cmp::Reverse(reach));
        for (reach, is_wide) in order {
            if reach < target || root.key >= target || self.stop.load(Ordering::Relaxed) {
                continue;
            }
            if is_wide {
                self.bound_wide(root, sorted, wide, goal);
            } else {
                self.bound_narrow(root, sorted, narrow, goal);
            }
        }
    }

    fn by_labels(&self, sorted: &Sorted, costs: [i64; 2]) -> i64 {
        let tallies = [&sorted.tallies[0][..], &sorted.tallies[1]];
        with_labels(&self.ground.loss, costs, tallies, &sorted.open_tally)
    }

    /// The least cost of child `s` that, with `other` for the other child, brings the labels' bound to `goal`.
    fn least_to_reach(&self, sorted: &Sorted, s: usize, other: i64, goal: i64) -> i64 {
        let (mut low, mut high) = (0, goal.max(0));
        while low < high {
            let middle = low + (high - low) / 2;
            let costs = if s == 0 {
                [middle, other]
            } else {
                [other, middle]
            };
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
    fn bound_narrow(
        &self,
        root: &mut RootBox,
        sorted: &Sorted,
        mut reach: [i64; 2],
        Goal { target, upper }: Goal,
    ) {
        let price = self.price(root);
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
            };
            let mut strips = root.children[s].strips.to_vec();
            let answer = self.ask(&root.children[s], question, &mut strips);
            reach[s] = answer.attained;
            let child = &mut root.children[s];
            child.floor = child.floor.max(answer.lower);
            child.remember(answer.line);
            child.keep_strips_below(strips, question.dead);
            self.raise_key_by_labels(root, sorted);
            if root.key >= target || answer.attained < question.hopeless {
                return;
            }
        }
    }

    /// STUMP(L + O) + STUMP(R + O) - most(O).
    fn bound_wide(
        &self,
        root: &mut RootBox,
        sorted: &Sorted,
        mut reach: [i64; 2],
        Goal { target, upper }: Goal,
    ) {
        let (price, most) = (self.price(root), sorted.open_most);
        for s in [0, 1] {
            let all = self.ground.loss.most(&sorted.wide_tallies[s]);
            let child = &mut root.children[s];
            // Samples that left the set since the last bound lowered it by no more than they can cost.
            child.wide.0 -= child.wide.1 - all;
            let by_classes = two_labels_at_least(&self.ground.loss, &sorted.wide_tallies[s]);
            child.wide.0 = child.wide.0.max(child.floor).max(by_classes);
            child.wide.1 = all;
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
                dead: upper - price - other.floor,
            };
            let mut strips = root.children[s].strips.to_vec();
            let answer = self.ask(&root.children[s], question, &mut strips);
            reach[s] = answer.attained;
            let child = &mut root.children[s];
            for (strip, known) in strips.iter_mut().zip(child.strips.iter()) {
                strip.bound = known.bound.max(strip.bound - most);
            }
            child.wide.0 = child.wide.0.max(answer.lower);
            child.floor = child.floor.max(answer.lower - most);
            child.remember(answer.line);
            child.keep_strips_below(strips, question.dead);
            let bound = root.children[0].wide.0 + root.children[1].wide.0 - most + price;
            root.key = root.key.max(bound);
            if root.key >= target || answer.attained < question.hopeless {
                return;
            }
        }
        self.raise_key_by_labels(root, sorted);
    }

    pub(super) fn ask(
        &self,
        child: &Child,
        question: Question<'_>,
        strips: &mut [Strip],
    ) -> Answer {
        let lines = child.lines.iter().copied();
        let view = self.ground.view();
        best_split(view, &self.charts, question, lines, strips, self.stop)
    }
}

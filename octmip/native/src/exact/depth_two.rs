//! The best tree of at most two levels: bisection over the cuts of the root, both children answered by best stumps.

use crate::exact::axis::Interval;
use crate::exact::branch::{Answer, Search};
use crate::exact::plan::Plan;
use crate::exact::stumps::Place;
use crate::exact::view::View;

impl Search<'_> {
    /// The best tree of at most two levels if it costs less than `upper`, else the proof that none does.
    ///
    /// `floor` is a bound known beforehand: a tree that costs no more ends the search.
    pub fn depth_two(&mut self, view: &View, upper: i64, floor: i64) -> Answer {
        let leaf = view.leaf();
        if upper <= floor {
            return Answer::none(floor);
        }
        if leaf <= floor.max(self.samples.penalty) || view.len < 2 * self.samples.leaf_size {
            return Answer::cheapest(leaf, Plan::Leaf, upper);
        }
        let mut finder = self.take_finder(view);
        finder.load(self.samples, view);
        let whole = Place {
            view,
            f: 0,
            k: 0,
            positions: &self.zeros,
        };
        let [_, stump] = finder.both(self.samples, &whole, i64::MAX);
        self.n_evaluated += 1;
        let mut scores = Vec::new();
        finder.attained(&mut scores);
        let mut best = Answer::cheapest(stump.value, Plan::Stump, upper);
        self.attained.clear();
        self.attained.resize(self.samples.p, i64::MAX);
        for f in self.features_by(|f| -scores[f]) {
            let current = best.cost(upper);
            if current <= floor || self.is_stopped() {
                break;
            }
            self.depth_two_feature(&mut *finder, view, f, stump.lower, current, &mut best);
        }
        self.return_finder(view, finder);
        self.report_effort();
        best.closed(upper)
    }

    fn depth_two_feature(
        &mut self,
        finder: &mut dyn crate::exact::stumps::Stumps,
        view: &View,
        f: usize,
        whole: i64,
        mut current: i64,
        best: &mut Answer,
    ) {
        let samples = self.samples;
        let mut axis = std::mem::take(&mut self.axis);
        let mut positions = std::mem::take(&mut self.positions);
        axis.lay(samples, view, f, 2, whole, &self.switches);
        for (position, &i) in view.list(f).iter().enumerate() {
            positions[i as usize] = position as u32;
        }
        finder.rewind();
        let mut open: Vec<Interval> = axis.whole().into_iter().collect();
        while let Some(interval) = open.pop() {
            let target = current - samples.penalty;
            let Some(interval) = axis.narrow(interval, target) else {
                continue;
            };
            let Some(k) = axis.pick(&interval, target) else {
                continue;
            };
            if self.is_stopped() {
                break;
            }
            let close = target
                + if self.switches.slack {
                    axis.slack(&interval, k)
                } else {
                    0
                };
            let place = Place {
                view,
                f,
                k: axis.positions[k] as usize,
                positions: &positions,
            };
            let [left, right] = finder.both(samples, &place, close);
            self.n_evaluated += 1;
            (axis.left[k], axis.right[k]) = (left.lower, right.lower);
            let cost = left.value + right.value + samples.penalty;
            self.attained[f] = self.attained[f].min(cost);
            if cost < current {
                current = cost;
                let sides = [Plan::Stump, Plan::Stump];
                *best = Answer::found(cost, Plan::split(samples, view, f, place.k, sides));
            }
            if interval.high > k {
                open.push(Interval {
                    a: k,
                    b: interval.b,
                    low: k + 1,
                    high: interval.high,
                });
            }
            if interval.low < k {
                open.push(Interval {
                    a: interval.a,
                    b: k,
                    low: interval.low,
                    high: k - 1,
                });
            }
        }
        self.axis = axis;
        self.positions = positions;
    }
}

//! A node of features of few values, counted value by value: its best tree of one split, what more splits cost at
//! least, and its best tree of two levels. It closes most nodes of trees that pay for splits, and sorts no list.
//!
//! `q` is the price of a split, `range(S)` the cost of a set without any gain, `lost(S)` what equal samples of
//! different labels lose in every tree (`Samples::lost`). A side of a cut costs its leaf, or, with splits:
//!
//! * two leaves: `q`, and the samples outside its two heaviest labels, or `lost`;
//! * three leaves or more: `2 q + lost`.
//!
//! **No split is worth it** where `leaf(S) <= q + lost(S)`, as every split tree costs as much; nor where
//! `range(S) < 2 q`. Proof: the root split of a tree on `S` has a side `A` with `range(A) < q`. Put the tree of the
//! other side in the place of the split: it saves `q`, and the samples of `A` cost less than `q` in any leaves. Repeat
//! until a leaf is left. ∎
//!
//! **The whole**: a tree for the side `R` of a cut is one for all samples, where those of `L` cost `range(L)` at most.
//! So `e(R) >= e(L and R) - range(L)`, with `e` the least cost of a child's depth, and the same for `L`.
//!
//! The least sum over all cuts, and `q` for the cut itself, bounds every tree with a split. Where trees are deeper than
//! two levels that bound stands for the whole again, until it rises no more.

use crate::node::plan::Plan;
use crate::node::result::NodeResult;
use crate::samples::Samples;

/// Most cuts of a node of two levels whose sides are counted; where more are open, the search closes several at once.
const MOST_OPEN: usize = 16;

/// Samples of a node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Set<'s> {
    /// Their number.
    pub(crate) len: usize,
    /// Their ids; none where nobody looks at them.
    pub(crate) ids: &'s [u32],
    /// Gain of predicting each label for all of them (`n_labels`).
    pub(crate) totals: &'s [i64],
    /// Sum of their cost ranges.
    pub(crate) range: i64,
}

impl Set<'_> {
    /// Added cost of the best leaf.
    pub(crate) fn leaf(&self) -> i64 {
        self.range - self.totals.iter().copied().max().unwrap_or(0)
    }
}

/// A cut: the largest value left of it, the total range there, and lower bounds of both sides.
#[derive(Debug, Clone, Copy)]
struct Cut {
    pub feature: usize,
    value: u32,
    range: i64,
    sides: [i64; 2],
}

impl Cut {
    fn bound(&self) -> i64 {
        self.sides[0] + self.sides[1]
    }
}

/// Counts by value, used again from node to node.
#[derive(Debug, Default)]
pub(crate) struct ByValues {
    /// Gain of each label at each value of each feature (`n_values * n_labels`).
    cells: Vec<i64>,
    /// What is lost at each value (`n_values`).
    lost: Vec<i64>,
    /// Gain of each label left and right of a cut.
    sides: [Vec<i64>; 2],
    cuts: Vec<Cut>,
    /// Samples left and right of a cut.
    parts: [Vec<u32>; 2],
    totals: Vec<i64>,
    /// Sets that were counted.
    pub(crate) n_counted: u64,
}

/// Whether counting a set of so many samples by value takes no longer than a look at the samples.
pub(crate) fn are_few(samples: &Samples, len: usize) -> bool {
    !samples.cells.is_empty() && samples.n_values * samples.n_labels <= samples.p * len
}

impl ByValues {
    /// The best tree of at most `depth` levels below `upper`, or the proof that there is none, where counts tell; else
    /// a bound. No tree of a level less costs less than `whole`.
    pub(crate) fn solve(
        &mut self,
        samples: &Samples,
        set: Set<'_>,
        depth: usize,
        upper: i64,
        mut whole: i64,
    ) -> Result<NodeResult, i64> {
        let (leaf, stump) = (set.leaf(), self.lay(samples, set, depth));
        let (cost, plan) = if leaf <= stump { (leaf, Plan::Leaf) } else { (stump, Plan::Stump) };
        if depth == 1 {
            return Ok(NodeResult::cheapest(cost, plan, upper));
        }
        if depth == 2 {
            whole = cost;
        }
        let mut lower = self.raised(samples, set, whole).min(leaf);
        while depth > 2 && whole < lower && lower < upper.min(cost) {
            whole = lower;
            lower = self.raised(samples, set, whole).min(leaf);
        }
        match lower {
            lower if lower >= upper => Ok(NodeResult::none(lower)),
            lower if lower >= cost => Ok(NodeResult::found(cost, plan)),
            lower if depth > 2 => Err(lower),
            lower => self.two_levels(samples, set, NodeResult::cheapest(cost, plan, upper), upper).ok_or(lower),
        }
    }

    /// Take up the cuts of a set whose trees have `depth` levels; the cost of the best tree of one split.
    fn lay(&mut self, samples: &Samples, set: Set<'_>, depth: usize) -> i64 {
        let mut cuts = std::mem::take(&mut self.cuts);
        cuts.clear();
        self.count(samples, set.ids);
        let all = self.count_lost(samples, set.ids);
        let (price, mut stump) = (samples.penalty, i64::MAX - samples.penalty);
        for feature in 0..samples.p {
            let mut gone = 0;
            self.for_each_cut(samples, set, feature, |value, range, left, right, lost| {
                gone += lost;
                let [a, b] =
                    [side(price, range, left, gone, depth), side(price, set.range - range, right, all - gone, depth)];
                stump = stump.min(a.0 + b.0);
                cuts.push(Cut { feature, value, range, sides: [a.1, b.1] });
            });
        }
        self.cuts = cuts;
        price + stump
    }

    /// The cost of the best tree of at most one split on some of a set.
    fn best_stump(&mut self, samples: &Samples, ids: &[u32]) -> i64 {
        let mut totals = std::mem::take(&mut self.totals);
        totals.clear();
        totals.resize(samples.n_labels, 0);
        ids.iter().for_each(|&i| samples.count(i, 1, &mut totals));
        let set = Set { len: ids.len(), ids, totals: &totals, range: totals.iter().sum() };
        let mut least = set.leaf();
        if least > samples.penalty {
            self.count(samples, ids);
            for feature in 0..samples.p {
                self.for_each_cut(samples, set, feature, |_, range, left, right, _| {
                    let most = |gains: &[i64]| gains.iter().copied().max().unwrap_or(0);
                    least = least.min(samples.penalty + range - most(left) + set.range - range - most(right));
                });
            }
        }
        self.totals = totals;
        least
    }

    /// Count a set: sample after sample, so that no two additions in a row wait for one cell.
    fn count(&mut self, samples: &Samples, ids: &[u32]) {
        self.n_counted += 1;
        self.cells.clear();
        self.cells.resize(samples.n_values * samples.n_labels, 0);
        for &i in ids {
            let gain = samples.multiplicity[i as usize];
            for &cell in samples.cells_of(i) {
                self.cells[cell as usize] += gain;
            }
        }
    }

    /// Count what is lost, all of it returned.
    fn count_lost(&mut self, samples: &Samples, ids: &[u32]) -> i64 {
        self.lost.clear();
        self.lost.resize(samples.n_values, 0);
        let mut all = 0;
        for &i in ids.iter().filter(|_| !samples.lost.is_empty()) {
            let lost = samples.lost[i as usize];
            all += lost;
            for &cell in samples.cells_of(i).iter().filter(|_| lost > 0) {
                self.lost[cell as usize / samples.n_labels] += lost;
            }
        }
        all
    }

    /// Go through the cuts of a feature as it was counted: value, total range, gains left and right, what is lost
    /// between this cut and the one before.
    fn for_each_cut(
        &mut self,
        samples: &Samples,
        set: Set<'_>,
        feature: usize,
        mut act: impl FnMut(u32, i64, &[i64], &[i64], i64),
    ) {
        let first: usize = samples.values[..feature].iter().sum();
        let here = first..first + samples.values[feature];
        let [left, right] = &mut self.sides;
        left.clear();
        left.resize(samples.n_labels, 0);
        right.clear();
        right.extend(set.totals);
        let (mut range, mut lost) = (0, 0);
        let cells = self.cells.chunks_exact(samples.n_labels).skip(first);
        for (value, (cell, gone)) in cells.zip(&self.lost[here]).enumerate() {
            let here: i64 = cell.iter().sum();
            lost += gone;
            if here == 0 {
                continue; // no cut, or one that parts the same weight
            }
            for ((count, left), right) in cell.iter().zip(&mut *left).zip(&mut *right) {
                *left += count;
                *right -= count;
            }
            range += here;
            if range == set.range {
                break;
            }
            act(value as u32, range, left, right, std::mem::take(&mut lost));
        }
    }

    /// Raise the sides of all cuts by the whole; the least cost of a tree with a split.
    fn raised(&mut self, samples: &Samples, set: Set<'_>, whole: i64) -> i64 {
        let mut least = i64::MAX - samples.penalty;
        for cut in &mut self.cuts {
            let [left, right] = cut.sides;
            cut.sides = [left.max(whole - (set.range - cut.range)), right.max(whole - cut.range)];
            least = least.min(cut.bound());
        }
        samples.penalty + least
    }

    /// Whether a feature has a cut whose trees may cost less than `upper`, by the set that was solved last.
    pub(crate) fn is_open(&self, feature: usize, price: i64, upper: i64) -> bool {
        self.cuts.iter().any(|cut| cut.feature == feature && price + cut.bound() < upper)
    }

    /// The best tree of two levels, from the best of one; None where too many cuts are open.
    fn two_levels(&mut self, samples: &Samples, set: Set<'_>, mut best: NodeResult, upper: i64) -> Option<NodeResult> {
        let mut open: Vec<Cut> = Vec::new();
        let target = best.cost(upper) - samples.penalty;
        open.extend(self.cuts.iter().filter(|cut| cut.bound() < target));
        if open.len() > MOST_OPEN {
            return None;
        }
        while let Some(k) = (0..open.len()).min_by_key(|&k| open[k].bound()) {
            let cut = open.remove(k);
            if samples.penalty + cut.bound() >= best.cost(upper) {
                break;
            }
            let costs = self.sides_of(samples, set.ids, &cut);
            let cost = samples.penalty + costs[0] + costs[1];
            if cost < best.cost(upper) {
                let sides = Box::new([Plan::Stump, Plan::Stump]);
                best = NodeResult::found(cost, Plan::Split { feature: cut.feature, cut: cut.value, sides });
            }
            // A larger side costs as much, and a smaller one no less than what it lacks may have cost.
            for other in open.iter_mut().filter(|other| other.feature == cut.feature) {
                let more = other.range - cut.range;
                let [left, right] = [costs[0] + more.min(0), costs[1] - more.max(0)];
                other.sides = [other.sides[0].max(left), other.sides[1].max(right)];
            }
        }
        Some(best.closed(upper))
    }

    /// Cost of the best tree of at most one split on both sides of a cut.
    fn sides_of(&mut self, samples: &Samples, ids: &[u32], cut: &Cut) -> [i64; 2] {
        let mut parts = std::mem::take(&mut self.parts);
        parts.iter_mut().for_each(Vec::clear);
        let ranks = samples.ranks_of(cut.feature);
        ids.iter().for_each(|&i| parts[usize::from(ranks[i as usize] > cut.value)].push(i));
        let costs = [0, 1].map(|side| self.best_stump(samples, &parts[side]));
        self.parts = parts;
        costs
    }
}

/// Cost of the leaf of one side of a cut, and least cost of its trees of one level less than `depth`.
#[inline]
fn side(price: i64, range: i64, gains: &[i64], lost: i64, depth: usize) -> (i64, i64) {
    let (mut first, mut second) = (0, 0);
    for &gain in gains {
        second = second.max(gain.min(first));
        first = first.max(gain);
    }
    let leaf = range - first;
    if leaf <= price + lost || range < 2 * price {
        return (leaf, leaf);
    }
    let two = price + (leaf - second).max(lost);
    let split = if depth > 2 { two.min(2 * price + lost) } else { two };
    (leaf, leaf.min(split))
}

#[cfg(test)]
mod tests {
    use super::side;

    #[test]
    fn a_side_costs_at_most_what_two_and_three_pure_leaves_cost() {
        for price in 1..40 {
            let (leaf, least) = side(price, 90, &[30, 30, 30], 0, 3);
            assert_eq!(leaf, 60);
            assert!(least <= 2 * price && least <= leaf, "three pure leaves at {price}");
            assert!(least >= price.min(leaf), "a bound of one price at least");
            // Of one more level there are two leaves at most, and the third label is lost.
            assert_eq!(side(price, 90, &[30, 30, 30], 0, 2).1, if 90 < 2 * price { 60 } else { leaf.min(price + 30) });
        }
    }
}

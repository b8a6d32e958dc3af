//! What samples cost at least in a tree of so many levels, by the labels that it may give.
//!
//! A tree of d levels gives the labels of some set A of `2^d` at most, and then a sample of class c costs the cheapest
//! label of A for c, or more. So the least over all such sets of what the samples cost is a bound of every tree,
//! without penalties. Proofs: docs/theory/proof.md, (4).

use crate::problem::Problem;

/// Most sets of labels that are gone through one by one.
const MOST_SETS: usize = 64;

/// The sets of labels of a tree. Samples are summed up in a list of numbers.
pub(super) enum LabelSets {
    /// Few sets: their number, and the cost of a unit of weight of each class under each set. Summed up is the cost
    /// under each set.
    Few(usize, Vec<i64>),
    /// Many sets: the number of labels in one, the number of all labels, and for each class its cheapest label, that
    /// cost, and what the next label costs more. Summed up are the cheapest costs, and for each label what its
    /// classes cost more without it.
    Many(usize, usize, Vec<(usize, [i64; 2])>),
}

/// What some samples sum up to, and the place of the least number.
pub(super) struct Sums {
    numbers: Vec<i64>,
    least: usize,
}

impl LabelSets {
    /// The sets of labels of a tree of `depth` levels, of the `labels` that are worth giving.
    pub(super) fn new(q: &Problem, labels: &[usize], depth: usize) -> Self {
        let size = labels.len().min(1 << depth.min(20));
        if !are_few(labels.len(), size) {
            return Self::Many(size, q.n_classes, (0..q.n_classes).map(|c| cheapest_and_next(q, labels, c)).collect());
        }
        let sets = subsets(labels, size);
        let cost = |c, set: &Vec<usize>| set.iter().map(|&k| q.cost(c, k)).min().unwrap_or(0);
        Self::Few(sets.len(), (0..q.n_classes).flat_map(|c| sets.iter().map(move |set| cost(c, set))).collect())
    }

    /// The sums of no samples.
    pub(super) fn none(&self) -> Sums {
        match self {
            Self::Few(n_sets, _) => Sums { numbers: vec![0; *n_sets], least: 0 },
            Self::Many(_, n_labels, _) => Sums { numbers: vec![0; 1 + n_labels], least: 0 },
        }
    }

    /// Count a sample; returns the least that the samples cost together.
    pub(super) fn join(&self, sums: &mut Sums, class: usize, weight: i64) -> i64 {
        match self {
            Self::Few(n_sets, costs) => {
                let costs = &costs[class * n_sets..][..*n_sets];
                sums.numbers.iter_mut().zip(costs).for_each(|(sum, cost)| *sum += weight * cost);
                // No number falls: if the least one has not grown it is the least still.
                if costs[sums.least] > 0 {
                    sums.least = (0..*n_sets).min_by_key(|&set| sums.numbers[set]).unwrap_or(0);
                }
                sums.numbers[sums.least]
            }
            Self::Many(size, _, classes) => {
                let (label, [cheapest, more]) = classes[class];
                sums.numbers[0] += weight * cheapest;
                sums.numbers[1 + label] += weight * more;
                let mut more = sums.numbers[1..].to_vec();
                more.sort_unstable();
                sums.numbers[0] + more.iter().rev().skip(*size).sum::<i64>()
            }
        }
    }
}

impl Sums {
    /// Forget all samples.
    pub(super) fn clear(&mut self) {
        self.numbers.fill(0);
    }
}

/// The labels that no other one covers. A label covers another that costs no less for every class that has weight, and
/// more for some or has a higher number. In place of the other it costs no more, and what it does not cover no other
/// label left out does: so the least over sets of the labels that are left is the least over all sets.
pub(super) fn labels_worth_giving(q: &Problem) -> Vec<usize> {
    let mut has_weight = vec![false; q.n_classes];
    q.labels.iter().zip(&q.weights).for_each(|(&c, &weight)| has_weight[c as usize] |= weight > 0);
    let costs = |k: usize| (0..q.n_classes).filter(|&c| has_weight[c]).map(|c| q.cost(c, k)).collect();
    let costs: Vec<Vec<i64>> = (0..q.n_classes).map(costs).collect();
    let covers = |by: usize, k: usize| {
        (costs[k] != costs[by] || by < k) && costs[k].iter().zip(&costs[by]).all(|(own, other)| own >= other)
    };
    (0..q.n_classes).filter(|&k| !(0..q.n_classes).any(|by| covers(by, k))).collect()
}

/// The cheapest label of a class, its cost, and what the next of the others costs more.
fn cheapest_and_next(q: &Problem, labels: &[usize], c: usize) -> (usize, [i64; 2]) {
    let mut costs: Vec<(i64, usize)> = labels.iter().map(|&k| (q.cost(c, k), k)).collect();
    costs.sort_unstable();
    let (cheapest, label) = costs[0];
    (label, [cheapest, costs.get(1).map_or(0, |next| next.0 - cheapest)])
}

/// Whether there are no more than `MOST_SETS` sets of `size` of `n` labels.
fn are_few(n: usize, size: usize) -> bool {
    let joined = |sets: usize, i: usize| Some(sets * (n - i) / (i + 1)).filter(|&sets| sets <= MOST_SETS);
    // As long as the sets of i labels are no more than half of all labels, they are more with every label.
    (0..size.min(n - size)).try_fold(1, joined).is_some()
}

/// All sets of `size` of some labels.
fn subsets(labels: &[usize], size: usize) -> Vec<Vec<usize>> {
    if labels.len() == size || size == 0 {
        return vec![labels[..size].to_vec()];
    }
    let mut sets = subsets(&labels[1..], size);
    sets.extend(subsets(&labels[1..], size - 1).into_iter().map(|rest| [&labels[..1], &rest[..]].concat()));
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A problem of one sample for each class; depth and all else do not matter.
    fn problem(costs: &[i64]) -> Problem {
        let n = (1..).find(|n| n * n == costs.len()).expect("a square");
        Problem {
            n,
            p: 1,
            n_classes: n,
            ranks: (0..n as u32).collect::<Vec<_>>().into(),
            n_ranks: vec![n as u32],
            labels: (0..n as u32).collect(),
            weights: vec![1; n],
            costs: costs.to_vec(),
            penalty: 0,
            depth: 1,
            leaf_size: 1,
            sensor_of_feature: vec![0],
            sensor_cost: vec![1.0],
            sensor_limit: f64::INFINITY,
            allowed: vec![true],
            planes: None,
        }
    }

    /// The least cost of the classes by the labels of every set that has `size` of them, counted in a row.
    fn by_all_sets(q: &Problem, size: usize) -> i64 {
        let sets = (0..1u32 << q.n_classes).filter(|set| set.count_ones() as usize == size.min(q.n_classes));
        let cost = |set: u32, c| (0..q.n_classes).filter(|k| set >> k & 1 == 1).map(|k| q.cost(c, k)).min();
        sets.map(|set| (0..q.n_classes).filter_map(|c| cost(set, c)).sum()).min().unwrap_or(0)
    }

    fn least(q: &Problem, depth: usize) -> (bool, i64) {
        let sets = LabelSets::new(q, &labels_worth_giving(q), depth);
        let mut sums = sets.none();
        let costs = (0..q.n).map(|i| sets.join(&mut sums, q.labels[i] as usize, q.weights[i]));
        (matches!(sets, LabelSets::Few(..)), costs.last().unwrap_or(0))
    }

    #[test]
    fn few_sets_give_the_least_of_all_of_them() {
        let distances: Vec<i64> = (0..25).map(|e: i64| (e / 5 - e % 5).abs()).collect();
        let covered = [0, 3, 1, 4, 0, 2, 2, 5, 3, 1, 1, 4, 2, 0, 1, 1];
        for q in [problem(&distances), problem(&covered)] {
            for depth in 0..4 {
                assert_eq!(least(&q, depth), (true, by_all_sets(&q, 1 << depth)), "depth {depth}");
            }
        }
    }

    #[test]
    fn many_sets_give_no_more_than_that_and_no_less_where_mistakes_on_a_class_cost_the_same() {
        let costs: Vec<i64> = (0..144).map(|e: i64| if e / 12 == e % 12 { 1 } else { 2 + e / 12 }).collect();
        assert_eq!(least(&problem(&costs), 1), (false, by_all_sets(&problem(&costs), 2)));
        let mixed: Vec<i64> = (0..144).map(|e: i64| if e / 12 == e % 12 { 0 } else { 1 + e % 7 }).collect();
        let (is_few, bound) = least(&problem(&mixed), 1);
        assert!(!is_few && 0 < bound && bound <= by_all_sets(&problem(&mixed), 2));
    }
}

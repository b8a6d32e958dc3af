//! The same problem in fewer rows: what no split can part is counted once.
//!
//! ```text
//! equal samples of one class    one sample of their weight together
//! and of every class            the gain that they have under each label is taken from all of them
//! ```
//!
//! Every tree sends equal samples to one leaf, so the first leaves all trees their cost. So does the second, but for
//! what is `avoided`: where each class gains under one label, a label of its own, and the group gains m or more under
//! each of K labels, its leaf predicts one of them, gains m by it, and loses m by every other. Of two classes one is
//! left in a group; the ranges of the rest are smaller, and with them everything that bounds costs by ranges.
//!
//! Neither holds where leaves have a least size, as samples are counted there. Only features that a split may use are
//! compared.

use std::sync::Arc;

use crate::samples::unit::common_divisor;
use octmip_check::problem::Problem;
use octmip_frame::costs::ClassCosts;

/// Rows that must go for the smaller problem to be worth its memory: one in so many.
const WORTH: usize = 16;

/// A problem in fewer rows.
pub(crate) struct Merged {
    /// Of the samples that are left, each where the first of its rows was.
    pub(crate) problem: Problem,
    /// Rows of the larger problem that each sample is (`n`).
    pub(crate) rows: Vec<u32>,
    /// What every tree costs more in the larger problem.
    pub(crate) avoided: i64,
}

/// The problem with equal samples merged; None where too few are equal. `cancels`: also those of different classes.
pub(crate) fn merged(problem: &Problem, cancels: bool) -> Option<Merged> {
    if problem.leaf_size > 1 || problem.n < 2 {
        return None;
    }
    let usable: Vec<usize> = (0..problem.p).filter(|&f| problem.allowed[f] && problem.n_ranks[f] > 1).collect();
    let groups = Groups::of(problem, &usable)?;
    let single = if cancels { SingleGains::of(problem) } else { None };
    let (mut weights, mut rows, mut avoided) = (vec![0i64; problem.n], vec![0u32; problem.n], 0);
    let mut firsts: Vec<u32> = Vec::new(); // of each class of a group
    groups.for_each(problem, &usable, |group| {
        firsts.clear();
        for &i in group {
            let known = firsts.iter().find(|&&first| problem.labels[first as usize] == problem.labels[i as usize]);
            let to = known.copied().unwrap_or(i) as usize;
            if known.is_none() {
                firsts.push(i);
            }
            weights[to] += problem.weights[i as usize];
            rows[to] += 1;
        }
        if let Some(single) = single.as_ref().filter(|_| firsts.len() == problem.n_classes) {
            avoided += single.cancel(problem, &firsts, &mut weights);
            firsts.iter().filter(|&&i| weights[i as usize] == 0).for_each(|&i| rows[i as usize] = 0);
        }
    });
    if rows.iter().all(|&count| count == 0) {
        rows[0] = 1; // a sample without weight, as there has to be one
    }
    let kept: Vec<usize> = (0..problem.n).filter(|&i| rows[i] > 0).collect();
    // Features that no split may use keep their rows, though not all their values: nothing reads them.
    let ranks = (0..problem.p).flat_map(|f| kept.iter().map(move |&i| problem.feature(f)[i])).collect();
    let smaller = Problem {
        n: kept.len(),
        ranks: Arc::new(ranks),
        labels: kept.iter().map(|&i| problem.labels[i]).collect(),
        weights: kept.iter().map(|&i| weights[i]).collect(),
        n_ranks: problem.n_ranks.clone(),
        costs: problem.costs.clone(),
        sensor_of_feature: problem.sensor_of_feature.clone(),
        sensor_cost: problem.sensor_cost.clone(),
        allowed: problem.allowed.clone(),
        planes: None,
        ..*problem
    };
    Some(Merged { problem: smaller, rows: kept.iter().map(|&i| rows[i]).collect(), avoided })
}

/// Go through the groups of equal samples, each ascending; not where too few are equal.
pub(crate) fn for_each_group(problem: &Problem, usable: &[usize], act: impl FnMut(&[u32])) {
    if let Some(groups) = Groups::of(problem, usable) {
        groups.for_each(problem, usable, act);
    }
}

/// What one unit of weight of each class gains and costs at least, where each class gains under one label and no two
/// under the same.
struct SingleGains {
    gains: Vec<i64>,
    bases: Vec<i64>,
    /// Least common multiple of the gains.
    multiple: i64,
}

impl SingleGains {
    /// None where some class gains under no label or several, or shares its label.
    fn of(problem: &Problem) -> Option<Self> {
        let costs = ClassCosts::of(problem);
        let mut is_taken = vec![false; problem.n_classes];
        let classes = 0..problem.n_classes;
        let gain_of = |class| {
            let (label, gain) = costs.only_gain(class)?;
            (gain > 0 && !std::mem::replace(&mut is_taken[label], true)).then_some(gain)
        };
        let gains: Vec<i64> = classes.clone().map(gain_of).collect::<Option<_>>()?;
        let multiple = gains.iter().try_fold(1i64, |all, &gain| (all / common_divisor(all, gain)).checked_mul(gain))?;
        Some(Self { gains, bases: classes.map(|class| costs.base(class)).collect(), multiple })
    }

    /// Take what a group gains under every label from the weights of its samples, one of each class; what no tree
    /// avoids of their cost.
    fn cancel(&self, problem: &Problem, firsts: &[u32], weights: &mut [i64]) -> i64 {
        let classes = || firsts.iter().map(|&i| (i as usize, problem.labels[i as usize] as usize));
        let least = classes().map(|(i, class)| weights[i] * self.gains[class]).min().unwrap_or(0);
        // Weights are whole numbers, so what is taken from each is a multiple of all gains.
        let taken = least - least % self.multiple;
        let mut avoided = taken * (firsts.len() as i64 - 1);
        for (i, class) in classes() {
            let weight = taken / self.gains[class];
            weights[i] -= weight;
            avoided += weight * self.bases[class];
        }
        avoided
    }
}

/// Samples in the order of a number that equal ones share.
struct Groups {
    hashes: Vec<u64>,
    order: Vec<u32>,
}

impl Groups {
    /// None where too few samples are equal.
    fn of(problem: &Problem, usable: &[usize]) -> Option<Self> {
        let hashes = hashes(problem, usable);
        let mut order: Vec<u32> = (0..problem.n as u32).collect();
        order.sort_unstable_by_key(|&i| (hashes[i as usize], i));
        let n_equal = order.windows(2).filter(|pair| hashes[pair[0] as usize] == hashes[pair[1] as usize]).count();
        (n_equal * WORTH >= problem.n).then_some(Self { hashes, order })
    }

    /// Go through the groups of equal samples, each ascending: several of one hash where it is equal and they are not.
    fn for_each(&self, problem: &Problem, usable: &[usize], mut act: impl FnMut(&[u32])) {
        let are_equal = |a: u32, b: u32| {
            usable.iter().map(|&f| problem.feature(f)).all(|ranks| ranks[a as usize] == ranks[b as usize])
        };
        for run in self.order.chunk_by(|&a, &b| self.hashes[a as usize] == self.hashes[b as usize]) {
            if run.iter().all(|&i| are_equal(run[0], i)) {
                act(run);
                continue;
            }
            let mut rest = run.to_vec();
            while let Some(&first) = rest.first() {
                let group: Vec<u32> = rest.extract_if(.., |i| are_equal(first, *i)).collect();
                act(&group);
            }
        }
    }
}

/// A number for each sample (`n`), the same for equal ones.
fn hashes(problem: &Problem, usable: &[usize]) -> Vec<u64> {
    const ODD: u64 = 0x9E37_79B9_7F4A_7C15; // 2^64 over the golden ratio
    let mut hashes = vec![0; problem.n];
    for &f in usable {
        for (hash, &rank) in hashes.iter_mut().zip(problem.feature(f)) {
            *hash = (u64::rotate_left(*hash, 23) ^ u64::from(rank)).wrapping_mul(ODD);
        }
    }
    hashes
}

#[cfg(test)]
mod tests {
    use super::*;
    use octmip_oracle::problem_of_ranks;

    fn problem(rows: &[[u32; 2]], labels: &[u32], weights: &[i64]) -> Problem {
        let ranks: Vec<u32> = (0..2).flat_map(|f| rows.iter().map(move |row| row[f])).collect();
        Problem { n_classes: 2, costs: vec![0, 1, 1, 0], weights: weights.to_vec(), ..problem_of_ranks(&ranks, labels) }
    }

    #[test]
    fn equal_samples_of_a_class_become_one_where_the_first_was() {
        let given = problem(&[[0, 2], [1, 1], [0, 2], [0, 2]], &[0, 1, 0, 1], &[2, 3, 5, 7]);
        let Merged { problem: found, rows, avoided } = merged(&given, false).expect("fewer");
        assert_eq!((found.n, found.ranks.to_vec()), (3, vec![0, 1, 0, 2, 1, 2]));
        assert_eq!((found.labels, found.weights, rows), (vec![0, 1, 1], vec![7, 3, 7], vec![2, 1, 1]));
        assert_eq!(avoided, 0);
    }

    #[test]
    fn equal_samples_of_both_classes_leave_the_difference_and_what_no_tree_avoids() {
        let mut given = problem(&[[0, 2], [1, 1], [0, 2], [0, 2]], &[0, 1, 0, 1], &[2, 3, 5, 9]);
        let Merged { problem: found, rows, avoided } = merged(&given, true).expect("fewer");
        assert_eq!((found.ranks.to_vec(), found.labels, found.weights), (vec![1, 0, 1, 2], vec![1, 1], vec![3, 2]));
        assert_eq!((rows, avoided), (vec![1, 1], 7));
        // A row of class 0 gains 3 or 0, one of class 1 gains 2 or 0: of 21 and 16, twelve are taken.
        given.weights[3] = 8;
        given.costs = vec![1, 4, 2, 0];
        let Merged { problem: found, avoided, .. } = merged(&given, true).expect("fewer");
        assert_eq!((found.labels, found.weights), (vec![0, 1, 1], vec![3, 3, 2]));
        assert_eq!(avoided, 4 + 12);
    }

    #[test]
    fn one_sample_is_left_where_all_cancel() {
        let given = problem(&[[0, 2], [0, 2]], &[0, 1], &[3, 3]);
        let Merged { problem: found, avoided, .. } = merged(&given, true).expect("fewer");
        assert_eq!((found.n, found.weights, avoided), (1, vec![0], 3));
    }

    #[test]
    fn classes_that_gain_under_one_label_together_are_merged_only() {
        let mut given = problem(&[[0, 2], [0, 2]], &[0, 1], &[3, 3]);
        given.costs = vec![0, 1, 0, 1];
        let Merged { problem: found, avoided, .. } = merged(&given, true).expect("fewer");
        assert_eq!((found.weights, avoided), (vec![3, 3], 0));
    }

    #[test]
    fn features_that_no_split_may_use_part_nothing() {
        let mut given = problem(&[[0, 2], [0, 1], [1, 0]], &[0, 0, 1], &[1, 1, 1]);
        assert!(merged(&given, true).is_none());
        given.allowed[1] = false;
        assert_eq!(merged(&given, true).expect("fewer").problem.weights, vec![2, 1]);
    }

    #[test]
    fn samples_that_are_counted_stay_apart() {
        let mut given = problem(&[[0, 2], [0, 2]], &[0, 0], &[1, 1]);
        given.leaf_size = 2;
        assert!(merged(&given, true).is_none());
    }
}

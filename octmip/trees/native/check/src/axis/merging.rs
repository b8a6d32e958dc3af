//! The same problem in fewer rows: equal samples of one class counted as one of their weight together.
//!
//! Samples that agree in every feature that a split may use go to one leaf of every tree, so both problems have the
//! same trees at the same cost. Where leaves have a least size they are counted, and stay apart. A log counts the rows
//! of the larger problem, so it is kept how many of them each sample is.

use std::sync::Arc;

use crate::problem::Problem;

/// The problem with equal samples merged, each at the place of the first, and how many rows each is; None where no two
/// are equal.
pub(super) fn merged(q: &Problem) -> Option<(Problem, Vec<u32>)> {
    if q.leaf_size > 1 {
        return None;
    }
    let usable: Vec<&[u32]> = (0..q.p).filter(|&f| q.allowed[f]).map(|f| q.feature(f)).collect();
    let key = |&i: &u32| usable.iter().map(move |ranks| ranks[i as usize]).chain([q.labels[i as usize]]);
    let mut order: Vec<u32> = (0..q.n as u32).collect();
    order.sort_by(|a, b| key(a).cmp(key(b)));
    let mut groups: Vec<&[u32]> = order.chunk_by(|a, b| key(a).eq(key(b))).collect();
    if groups.len() == q.n {
        return None;
    }
    groups.sort_unstable_by_key(|group| group[0]);
    let firsts = || groups.iter().map(|group| group[0] as usize);
    let smaller = Problem {
        n: groups.len(),
        ranks: Arc::new((0..q.p).flat_map(|f| firsts().map(move |i| q.feature(f)[i])).collect()),
        labels: firsts().map(|i| q.labels[i]).collect(),
        weights: groups.iter().map(|group| group.iter().map(|&i| q.weights[i as usize]).sum()).collect(),
        planes: None,
        ..q.clone()
    };
    Some((smaller, groups.iter().map(|group| group.len() as u32).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(leaf_size: usize) -> Problem {
        Problem {
            n: 5,
            p: 2,
            n_classes: 2,
            ranks: vec![1, 0, 1, 1, 0, 0, 1, 2, 0, 1].into(),
            n_ranks: vec![2, 3],
            labels: vec![0, 1, 0, 1, 1],
            weights: vec![2, 3, 5, 7, 11],
            costs: vec![0, 1, 1, 0],
            penalty: 0,
            depth: 2,
            leaf_size,
            sensor_of_feature: vec![0, 0],
            sensor_cost: vec![1.0],
            sensor_limit: f64::INFINITY,
            allowed: vec![true, false],
            planes: None,
        }
    }

    #[test]
    fn samples_of_a_class_that_no_split_can_part_become_one() {
        let (q, rows) = merged(&problem(1)).expect("two pairs");
        assert_eq!((q.n, &q.ranks[..], &q.labels[..]), (3, &[1, 0, 1, 0, 1, 0][..], &[0, 1, 1][..]));
        assert_eq!((q.weights, rows), (vec![7, 14, 7], vec![2, 2, 1]));
    }

    #[test]
    fn samples_that_are_counted_or_different_stay_apart() {
        assert!(merged(&problem(2)).is_none());
        assert!(merged(&Problem { allowed: vec![true; 2], labels: vec![0, 1, 0, 1, 0], ..problem(1) }).is_none());
    }
}

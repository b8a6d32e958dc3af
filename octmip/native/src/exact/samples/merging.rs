//! The same problem in fewer rows: samples that no split can part, of one class, are one of their weight together.
//!
//! Every tree sends equal samples to one leaf, so both problems have the same trees at the same cost. It does not hold
//! where leaves have a least size, as samples are counted there. Only features that a split may use are compared.

use std::sync::Arc;

use crate::problem::Problem;

/// Rows that must go for the smaller problem to be worth its memory: one in so many.
const WORTH: usize = 16;

/// The problem with equal samples merged, each where the first of them was, and how many rows of the problem each of
/// them is; None where too few are equal.
pub(crate) fn merged(problem: &Problem) -> Option<(Problem, Vec<u32>)> {
    if problem.leaf_size > 1 || problem.n < 2 {
        return None;
    }
    let usable: Vec<usize> = (0..problem.p).filter(|&f| problem.allowed[f] && problem.n_ranks[f] > 1).collect();
    let first = first_equal(problem, &usable)?;
    let kept: Vec<usize> = (0..problem.n).filter(|&i| first[i] as usize == i).collect();
    let (mut weights, mut rows) = (vec![0i64; problem.n], vec![0u32; problem.n]);
    for (&own, &to) in problem.weights.iter().zip(&first) {
        weights[to as usize] += own;
        rows[to as usize] += 1;
    }
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
    Some((smaller, kept.iter().map(|&i| rows[i]).collect()))
}

/// The first sample that is equal to each one (`n`), itself where there is none before; None where too few are equal.
fn first_equal(problem: &Problem, usable: &[usize]) -> Option<Vec<u32>> {
    let hashes = hashes(problem, usable);
    let mut order: Vec<u32> = (0..problem.n as u32).collect();
    order.sort_unstable_by_key(|&i| (hashes[i as usize], i));
    let same_hash = |pair: &[u32]| hashes[pair[0] as usize] == hashes[pair[1] as usize];
    if order.windows(2).filter(|pair| same_hash(pair)).count() * WORTH < problem.n {
        return None;
    }
    let mut first: Vec<u32> = (0..problem.n as u32).collect();
    for run in order.chunk_by(|&a, &b| hashes[a as usize] == hashes[b as usize]) {
        let mut different: Vec<u32> = Vec::new(); // more than one where hashes are equal and samples are not
        for &i in run {
            match different.iter().find(|&&known| are_equal(problem, usable, known as usize, i as usize)) {
                Some(&known) => first[i as usize] = known,
                None => different.push(i),
            }
        }
    }
    Some(first)
}

fn are_equal(problem: &Problem, usable: &[usize], a: usize, b: usize) -> bool {
    problem.labels[a] == problem.labels[b] && usable.iter().all(|&f| problem.feature(f)[a] == problem.feature(f)[b])
}

/// A number for each sample (`n`), the same for equal ones.
fn hashes(problem: &Problem, usable: &[usize]) -> Vec<u64> {
    const ODD: u64 = 0x9E37_79B9_7F4A_7C15; // 2^64 over the golden ratio
    let mut hashes: Vec<u64> = problem.labels.iter().map(|&label| u64::from(label)).collect();
    for &f in usable {
        for (hash, &rank) in hashes.iter_mut().zip(problem.feature(f)) {
            *hash = (hash.rotate_left(23) ^ u64::from(rank)).wrapping_mul(ODD);
        }
    }
    hashes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(rows: &[[u32; 2]], labels: &[u32], weights: &[i64]) -> Problem {
        Problem {
            n: rows.len(),
            p: 2,
            n_classes: 2,
            ranks: (0..2).flat_map(|f| rows.iter().map(move |row| row[f])).collect::<Vec<_>>().into(),
            n_ranks: vec![3, 3],
            labels: labels.to_vec(),
            weights: weights.to_vec(),
            costs: vec![0, 1, 1, 0],
            penalty: 0,
            depth: 2,
            leaf_size: 1,
            sensor_of_feature: vec![0, 1],
            sensor_cost: vec![0.0; 2],
            sensor_limit: f64::INFINITY,
            allowed: vec![true; 2],
            planes: None,
        }
    }

    #[test]
    fn equal_samples_of_a_class_become_one_where_the_first_was() {
        let given = problem(&[[0, 2], [1, 1], [0, 2], [0, 2]], &[0, 1, 0, 1], &[2, 3, 5, 7]);
        let (found, rows) = merged(&given).expect("fewer");
        assert_eq!((found.n, found.ranks.to_vec()), (3, vec![0, 1, 0, 2, 1, 2]));
        assert_eq!((found.labels, found.weights, rows), (vec![0, 1, 1], vec![7, 3, 7], vec![2, 1, 1]));
    }

    #[test]
    fn features_that_no_split_may_use_part_nothing() {
        let mut given = problem(&[[0, 2], [0, 1], [1, 0]], &[0, 0, 1], &[1, 1, 1]);
        assert!(merged(&given).is_none());
        given.allowed[1] = false;
        assert_eq!(merged(&given).expect("fewer").0.weights, vec![2, 1]);
    }

    #[test]
    fn samples_that_are_counted_stay_apart() {
        let mut given = problem(&[[0, 2], [0, 2]], &[0, 0], &[1, 1]);
        given.leaf_size = 2;
        assert!(merged(&given).is_none());
    }
}

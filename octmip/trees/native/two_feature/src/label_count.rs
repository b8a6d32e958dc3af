//! The label-count bound: leaves that name few labels leave samples of all other classes wrong, wherever the root sends
//! them.

use crate::loss::{INFEASIBLE, Loss};

/// A lower bound of both children's cost together with the open samples, each child naming at most two labels.
///
/// For a pair of labels a child costs at least `costs[side]`, and at least what its samples cost when each may choose
/// one of the two; an open sample may choose among the labels of both children.
pub(crate) fn label_count_bound(loss: &Loss, costs: [i64; 2], tallies: [&[i64]; 2], open: &[i64]) -> i64 {
    let left = label_pairs(loss, costs[0], tallies[0]);
    let right = label_pairs(loss, costs[1], tallies[1]);
    let mut best = INFEASIBLE;
    for &(left_cost, a) in &left {
        if left_cost + right[0].0 >= best {
            break;
        }
        for &(right_cost, b) in &right {
            if left_cost + right_cost >= best {
                break;
            }
            let open_cost = loss.choosing(open, &[a[0], a[1], b[0], b[1]]);
            best = best.min(left_cost + right_cost + open_cost);
        }
    }
    best
}

/// Least cost of samples whose leaves name two labels.
pub(crate) fn two_labels_at_least(loss: &Loss, tally: &[i64]) -> i64 {
    label_pairs(loss, 0, tally)[0].0
}

/// Least cost of samples whose leaves name so many labels, where every mistake costs the same; 0 elsewhere.
pub(crate) fn labels_at_least(loss: &Loss, tally: &[i64], n_labels: usize) -> i64 {
    if !loss.is_uniform() {
        return 0;
    }
    let mut weights = tally[..loss.k].to_vec();
    weights.sort_unstable_by_key(|&weight| std::cmp::Reverse(weight));
    weights.iter().skip(n_labels).sum()
}

/// Every pair of labels with its least cost, the cheapest first.
fn label_pairs(loss: &Loss, least: i64, tally: &[i64]) -> Vec<(i64, [usize; 2])> {
    let mut pairs = Vec::with_capacity(loss.k * loss.k / 2);
    for a in 0..loss.k {
        for b in a + 1..loss.k {
            pairs.push((loss.choosing(tally, &[a, b]).max(least), [a, b]));
        }
    }
    pairs.sort_unstable();
    pairs
}

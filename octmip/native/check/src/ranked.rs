//! A question with the whole numbers of a log, as the checkers count it.

use crate::input::question::Question;
use crate::log::whole_costs::WholeCosts;
use crate::problem::{Planes, Problem};

/// The problem that the checkers count: ranks in place of values, whole numbers in place of costs.
pub(crate) fn problem_of(question: &Question, costs: &WholeCosts) -> Problem {
    let (mut ranks, mut n_ranks) = (Vec::with_capacity(question.n * question.p), Vec::new());
    for f in 0..question.p {
        let values: Vec<f64> = (0..question.n).map(|i| question.features[i * question.p + f]).collect();
        let (own, n_distinct) = ranks_of(&values);
        ranks.extend(own);
        n_ranks.push(n_distinct);
    }
    Problem {
        n: question.n,
        p: question.p,
        n_classes: costs.n_rows,
        ranks,
        n_ranks,
        labels: costs.rows.clone(),
        weights: costs.weights.clone(),
        costs: costs.costs.clone(),
        penalty: costs.penalty,
        depth: question.depth,
        leaf_size: question.leaf_size,
        sensor_of_feature: question.sensor_of_feature.clone(),
        sensor_cost: question.sensor_cost.clone(),
        sensor_limit: question.sensor_limit,
        allowed: (0..question.p).map(|f| question.is_allowed(f)).collect(),
        planes: (question.split_size > 1).then(|| planes_of(question)),
    }
}

/// A bound over real coefficients holds for whole-numbered ones too.
fn planes_of(question: &Question) -> Planes {
    Planes {
        values: question.features.clone(),
        split_size: question.split_size,
        groups: question.allowed_splits.clone(),
        integer_normals: None,
    }
}

/// The rank of each value among the different ones, and how many these are.
fn ranks_of(values: &[f64]) -> (Vec<u32>, u32) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    // No value is NaN; 0.0 and -0.0 are equal.
    order.sort_unstable_by(|&i, &j| (values[i] + 0.0).total_cmp(&(values[j] + 0.0)));
    let (mut ranks, mut rank) = (vec![0; values.len()], 0);
    for (k, &i) in order.iter().enumerate() {
        rank += u32::from(k > 0 && values[order[k - 1]] != values[i]);
        ranks[i] = rank;
    }
    (ranks, rank + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_values_share_a_rank() {
        assert_eq!(ranks_of(&[4.0, -0.0, 1.5, 0.0, -3.25, 1e300, 4.0]), (vec![3, 1, 2, 1, 0, 4, 3], 5));
    }
}

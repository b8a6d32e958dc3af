//! A question with the whole numbers of a log, as the checkers count it.

use std::sync::Arc;

use crate::input::question::Question;
use crate::log::whole_costs::WholeCosts;
use crate::problem::{Planes, Problem};

/// The problem that the checkers count: ranks in place of values, whole numbers in place of costs.
pub(crate) fn problem_of(question: &Question, costs: &WholeCosts) -> Problem {
    let columns = columns_of(question);
    let (mut ranks, mut n_ranks) = (Vec::with_capacity(question.n * columns.len()), Vec::new());
    for &(feature, missing) in &columns {
        let value = |i: usize| Some(question.features[i * question.p + feature]).filter(|value| !value.is_nan());
        let values: Vec<f64> = (0..question.n).map(|i| value(i).unwrap_or(missing)).collect();
        let (own, n_distinct) = ranks_of(&values);
        ranks.extend(own);
        n_ranks.push(n_distinct);
    }
    Problem {
        n: question.n,
        p: columns.len(),
        n_classes: costs.n_rows,
        ranks: Arc::new(ranks),
        n_ranks,
        labels: costs.rows.clone(),
        weights: costs.weights.clone(),
        costs: costs.costs.clone(),
        penalty: costs.penalty,
        depth: question.depth,
        leaf_size: question.leaf_size,
        sensor_of_feature: columns.iter().map(|&(feature, _)| question.sensor_of_feature[feature]).collect(),
        sensor_cost: question.sensor_cost.clone(),
        sensor_limit: question.sensor_limit,
        allowed: columns.iter().map(|&(feature, _)| question.is_allowed(feature)).collect(),
        planes: (question.split_size > 1).then(|| planes_of(question)),
    }
}

/// The columns that a tree of ranks reads, each with its feature and what stands for a missing value in it.
///
/// A split of a tree sends missing values left or right. So a feature that lacks values is two columns, one after the
/// other: in the first they rank below all others and go left at every cut, in the second above and go right. A tree
/// over the columns is a tree with a side at each split, and the other way round: docs/theory/missing.md.
fn columns_of(question: &Question) -> Vec<(usize, f64)> {
    let column = |feature: usize| {
        let mut values = (0..question.n).map(|i| question.features[i * question.p + feature]);
        let ends: &[f64] = if values.any(f64::is_nan) { &[f64::NEG_INFINITY, f64::INFINITY] } else { &[0.0] };
        ends.iter().map(move |&end| (feature, end))
    };
    (0..question.p).flat_map(column).collect()
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
pub(crate) fn ranks_of(values: &[f64]) -> (Vec<u32>, u32) {
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
    use crate::log::whole_costs::rounded;

    #[test]
    fn equal_values_share_a_rank() {
        assert_eq!(ranks_of(&[4.0, -0.0, 1.5, 0.0, -3.25, 1e300, 4.0]), (vec![3, 1, 2, 1, 0, 4, 3], 5));
    }

    #[test]
    fn a_feature_that_lacks_values_is_two_columns() {
        let file = r#"{"format": "octmip-problem", "version": 2, "features": [[0.5, 1], [null, 0], [0.25, 1]],
            "labels": [0, 1, 1], "weights": [1, 1, 1], "costs": [[0, 1], [1, 0]], "depth": 1, "split": "axis",
            "split_size": 1, "leaf_size": 1, "leaf_penalty": 0, "sensor_of_feature": [1, 0], "sensor_cost": [1, 1],
            "sensor_limit": null, "allowed_splits": [[0]]}"#;
        let question = Question::from_json(file).expect("the file is right");
        let problem = problem_of(&question, &rounded(&question, 0, 0, 1).expect("the grid is right"));
        assert_eq!((problem.p, &problem.ranks[..]), (3, &[2, 0, 1, 1, 2, 0, 1, 0, 1][..]));
        assert_eq!(problem.sensor_of_feature, [1, 1, 0]);
        assert_eq!(problem.allowed, [true, true, false]);
    }
}

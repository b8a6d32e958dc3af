//! The ranking of features by how little a logistic regression can spare them.

use crate::logistic::regression::{Fitted, GoOn, PreferredSide, WORK_BETWEEN_POLLS, cholesky, solve};
use crate::prepared::values::Values;

/// A removal's price is multiplied by up to this power of e at random.
const NOISE: f64 = 1.0;

/// The features from the one that weighs most to the one that weighs least in a fit over all of them.
///
/// Around its optimum beta the loss is a quadratic of Hessian H. Of the features left, the one whose removal raises it
/// least goes first, that of least `beta_j^2 / (H^-1)_jj`; beta and `H^-1` follow. The rises are perturbed at random,
/// so that fits to the same samples do not always give the same features. Source: Hassibi & Stork (1993), Second order
/// derivatives for network pruning: Optimal Brain Surgeon.
pub(crate) fn leading(
    values: &Values,
    sides: &[PreferredSide],
    features: &[u32],
    ridge: f64,
    rng: &mut fastrand::Rng,
    go_on: GoOn,
) -> Option<Vec<u32>> {
    let fitted = Fitted::new(values, sides, features, ridge, go_on)?;
    let m = features.len() + 1;
    let mut inverse = inverse_of(fitted.hessian, m, go_on)?;
    let mut beta = fitted.beta;
    let mut left: Vec<usize> = (0..features.len()).collect();
    let mut order = Vec::with_capacity(features.len());
    let stride = WORK_BETWEEN_POLLS / (m * m) + 1;
    while !left.is_empty() {
        if left.len() % stride == stride - 1 && !go_on() {
            return None;
        }
        let rise = |&j: &usize| beta[j] * beta[j] / inverse[j * m + j];
        let rises: Vec<f64> = left.iter().map(|j| rise(j) * (NOISE * rng.f64()).exp()).collect();
        let position = (0..left.len()).min_by(|&a, &b| rises[a].total_cmp(&rises[b]))?;
        let j = left.swap_remove(position);
        order.push(features[j]);
        remove(j, &mut beta, &mut inverse);
    }
    order.reverse();
    Some(order)
}

/// Set coefficient `j` to 0 and move the others to where the quadratic is then least.
fn remove(j: usize, beta: &mut [f64], inverse: &mut [f64]) {
    let m = beta.len();
    let row = inverse[j * m..(j + 1) * m].to_vec();
    let factor = beta[j] / row[j];
    for a in 0..m {
        beta[a] -= factor * row[a];
        let share = row[a] / row[j];
        inverse[a * m..(a + 1) * m].iter_mut().zip(&row).for_each(|(entry, r)| *entry -= share * r);
    }
}

/// The inverse of a symmetric matrix given by its lower triangle; none where it is not positive definite or the caller
/// says stop.
fn inverse_of(matrix: Vec<f64>, m: usize, go_on: GoOn) -> Option<Vec<f64>> {
    let factor = cholesky(matrix, m, go_on)?;
    let stride = WORK_BETWEEN_POLLS / (m * m) + 1;
    let mut inverse = Vec::with_capacity(m * m);
    for a in 0..m {
        if a % stride == stride - 1 && !go_on() {
            return None;
        }
        let mut unit = vec![0.0; m];
        unit[a] = 1.0;
        inverse.extend(solve(&factor, unit, m));
    }
    Some(inverse)
}

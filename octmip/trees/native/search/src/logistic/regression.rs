//! Ridge logistic regression by Newton's method: a direction that parts two groups of samples.
//!
//! minimise over (w, b)  sum_j weight_j log(1 + exp(-t_j (w . z_j + b))) + ridge / 2 |w|^2,  t_j = +1 (right) or -1
//! (left), z the features of the fit standardised over its samples. Source: Hastie, Tibshirani & Friedman (2009), The
//! Elements of Statistical Learning, sec. 4.4.1 (Newton steps), 3.4.1 (ridge).

use crate::prepared::values::{Values, exponent_of, times_power};

/// The side that a sample of a fit prefers, and the weight of that preference.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PreferredSide {
    /// Sample.
    pub(crate) sample: u32,
    /// Whether it should go right.
    pub(crate) goes_right: bool,
    /// Weight in the fit.
    pub(crate) weight: f64,
}

/// Newton steps; more bring nothing, since only the direction is used and the offset is found exactly afterwards.
const STEPS: usize = 6;
/// Steps that compute the Hessian again; the others keep it, which costs a tenth. Few samples can often be parted
/// without an error, the curvature changes from step to step, and every step computes it.
const CURVED_STEPS: usize = 2;
const FEW: usize = 250;

/// More features are not fitted at once: the Hessian would take more memory than all else.
pub(crate) const MOST_FITTED: usize = 1000;
/// Multiplications between two questions whether to go on.
pub(super) const WORK_BETWEEN_POLLS: usize = 1 << 20;

/// Whether to go on.
pub(super) type GoOn<'a> = &'a dyn Fn() -> bool;

/// Normal over `features`, its largest coefficient between a half and 1, and offset; none where nothing can be fitted
/// or the caller says stop.
pub(crate) fn fit(
    values: &Values,
    sides: &[PreferredSide],
    features: &[u32],
    ridge: f64,
    go_on: GoOn,
) -> Option<(Vec<f64>, f64)> {
    let fitted = Fitted::new(values, sides, features, ridge, go_on)?;
    let q = features.len();
    let normal: Vec<f64> = fitted.beta[..q].iter().zip(&fitted.deviations).map(|(b, s)| b / s).collect();
    let offset = normal.iter().zip(&fitted.means).map(|(w, m)| w * m).sum::<f64>() - fitted.beta[q];
    let is_usable = normal.iter().all(|w| w.is_finite()) && offset.is_finite() && normal.iter().any(|&w| w != 0.0);
    let top = normal.iter().map(|&w| exponent_of(w)).max()?;
    let normalised = |value: f64| times_power(value, -top);
    is_usable.then(|| (normal.into_iter().map(normalised).collect(), normalised(offset)))
}

/// A regression over standardised features, the intercept last.
pub(super) struct Fitted {
    means: Vec<f64>,
    deviations: Vec<f64>,
    pub(super) beta: Vec<f64>,
    /// Of the last step that made one, row-major, lower triangle.
    pub(super) hessian: Vec<f64>,
}

impl Fitted {
    pub(super) fn new(
        values: &Values,
        sides: &[PreferredSide],
        features: &[u32],
        ridge: f64,
        go_on: GoOn,
    ) -> Option<Self> {
        let total: f64 = sides.iter().map(|side| side.weight).sum();
        if total <= 0.0 || features.is_empty() || features.len() > MOST_FITTED || !go_on() {
            return None;
        }
        let (means, deviations) = moments(values, sides, features, total);
        let m = features.len() + 1;
        let scaled = standardise(values, sides, features, &means, &deviations);
        let (mut beta, mut hessian, mut factor) = (vec![0.0; m], vec![0.0; m * m], Vec::new());
        for step in 0..STEPS {
            let is_curved = step < CURVED_STEPS || sides.len() <= FEW;
            let curved = is_curved.then_some(&mut hessian);
            let gradient = derivatives(sides, &scaled, &beta, (total, ridge), curved, go_on)?;
            if is_curved {
                factor = cholesky(hessian.clone(), m, go_on)?;
            }
            let moves = solve(&factor, gradient, m);
            beta.iter_mut().zip(&moves).for_each(|(b, s)| *b -= s);
            if moves.iter().all(|s| s.abs() < 1e-3) {
                break;
            }
        }
        Some(Self { means, deviations, beta, hessian })
    }
}

fn moments(values: &Values, sides: &[PreferredSide], features: &[u32], total: f64) -> (Vec<f64>, Vec<f64>) {
    let mut means = vec![0.0; features.len()];
    let mut squares = vec![0.0; features.len()];
    for side in sides {
        let row = values.row(side.sample);
        means.iter_mut().zip(features).for_each(|(m, &f)| *m += side.weight * row[f as usize] / total);
    }
    for side in sides {
        let row = values.row(side.sample);
        for ((square, mean), &f) in squares.iter_mut().zip(&means).zip(features) {
            *square += side.weight * (row[f as usize] - mean).powi(2) / total;
        }
    }
    let deviation = |square: f64| if square > 0.0 { square.sqrt() } else { 1.0 };
    (means, squares.into_iter().map(deviation).collect())
}

fn standardise(
    values: &Values,
    sides: &[PreferredSide],
    features: &[u32],
    means: &[f64],
    deviations: &[f64],
) -> Vec<f64> {
    let mut scaled = Vec::with_capacity(sides.len() * (features.len() + 1));
    for side in sides {
        let row = values.row(side.sample);
        let terms = features.iter().zip(means).zip(deviations);
        scaled.extend(terms.map(|((&f, mean), deviation)| (row[f as usize] - mean) / deviation));
        scaled.push(1.0);
    }
    scaled
}

/// Gradient of the loss divided by the total weight; its Hessian (row-major, lower triangle) too where that is wanted.
fn derivatives(
    sides: &[PreferredSide],
    scaled: &[f64],
    beta: &[f64],
    (total, ridge): (f64, f64),
    hessian: Option<&mut Vec<f64>>,
    go_on: GoOn,
) -> Option<Vec<f64>> {
    let q = beta.len();
    let (mut gradient, mut curvatures) = (vec![0.0; q], Vec::with_capacity(sides.len()));
    for (side, z) in sides.iter().zip(scaled.chunks_exact(q)) {
        let height: f64 = z.iter().zip(beta).map(|(z, b)| z * b).sum();
        let chance = 1.0 / (1.0 + (-height).exp());
        let weight = side.weight / total;
        let error = weight * (chance - f64::from(u8::from(side.goes_right)));
        curvatures.push(weight * chance * (1.0 - chance));
        gradient.iter_mut().zip(z).for_each(|(g, z)| *g += error * z);
    }
    // A trace of ridge on the intercept too keeps the system solvable when all samples prefer one side.
    let own = |a: usize| if a + 1 < q { ridge } else { 1e-6 };
    (0..q).for_each(|a| gradient[a] += own(a) * beta[a]);
    if let Some(hessian) = hessian {
        fill_curvatures(hessian, &curvatures, scaled, q, go_on)?;
        (0..q).for_each(|a| hessian[a * q + a] += own(a));
    }
    Some(gradient)
}

/// The Hessian of the samples alone, lower triangle; none where the caller says stop.
fn fill_curvatures(hessian: &mut [f64], curvatures: &[f64], scaled: &[f64], q: usize, go_on: GoOn) -> Option<()> {
    hessian.fill(0.0);
    let stride = WORK_BETWEEN_POLLS / (q * q) + 1;
    for (row, (curvature, z)) in curvatures.iter().zip(scaled.chunks_exact(q)).enumerate() {
        if row % stride == stride - 1 && !go_on() {
            return None;
        }
        for (a, &za) in z.iter().enumerate() {
            let scaled_a = curvature * za;
            hessian[a * q..=a * q + a].iter_mut().zip(&z[..=a]).for_each(|(h, zb)| *h += scaled_a * zb);
        }
    }
    Some(())
}

/// The Cholesky factor (lower triangle) of a symmetric matrix; none where it is not positive definite or the caller
/// says stop.
pub(super) fn cholesky(mut matrix: Vec<f64>, q: usize, go_on: GoOn) -> Option<Vec<f64>> {
    let stride = WORK_BETWEEN_POLLS / (q * q) + 1;
    for a in 0..q {
        if a % stride == stride - 1 && !go_on() {
            return None;
        }
        for b in 0..=a {
            let dot: f64 = (0..b).map(|c| matrix[a * q + c] * matrix[b * q + c]).sum();
            let rest = matrix[a * q + b] - dot;
            if a == b && (rest <= 0.0 || !rest.is_finite()) {
                return None;
            }
            matrix[a * q + b] = if a == b { rest.sqrt() } else { rest / matrix[b * q + b] };
        }
    }
    Some(matrix)
}

/// Solve the system of a Cholesky factor.
pub(super) fn solve(factor: &[f64], mut rhs: Vec<f64>, q: usize) -> Vec<f64> {
    for a in 0..q {
        let dot: f64 = (0..a).map(|c| factor[a * q + c] * rhs[c]).sum();
        rhs[a] = (rhs[a] - dot) / factor[a * q + a];
    }
    for a in (0..q).rev() {
        let dot: f64 = (a + 1..q).map(|c| factor[c * q + a] * rhs[c]).sum();
        rhs[a] = (rhs[a] - dot) / factor[a * q + a];
    }
    rhs
}

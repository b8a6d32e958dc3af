//! A classification problem over dense ranks, with integer weights and costs.

use std::sync::Arc;

/// A fault of a problem, with its numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProblemError(pub String);

/// Samples, costs and the limits of the tree that is wanted.
///
/// minimise `sum_i weights[i] * costs[labels[i]][predicted[i]] + penalty * (features summed over the splits)`.
#[derive(Debug, Clone)]
pub struct Problem {
    /// Number of samples.
    pub n: usize,
    /// Number of features.
    pub p: usize,
    /// Number of classes.
    pub n_classes: usize,
    /// Dense ranks, feature-major: the rank of sample `i` in feature `f` is `ranks[f * n + i]`; a search shares them.
    pub ranks: Arc<Vec<u32>>,
    /// Number of distinct values of each feature (`p`).
    pub n_ranks: Vec<u32>,
    /// Class of each sample (`n`).
    pub labels: Vec<u32>,
    /// Risk weight of each sample (`n`), 0 or more.
    pub weights: Vec<i64>,
    /// Cost of predicting label `k` for class `i` (`n_classes * n_classes`, row-major), 0 or more.
    pub costs: Vec<i64>,
    /// Price of one feature in one split.
    pub penalty: i64,
    /// Levels of splits, 1 or more.
    pub depth: usize,
    /// Fewest samples in a leaf, 1 or more.
    pub leaf_size: usize,
    /// Index of the sensor that each feature is read from (`p`).
    pub sensor_of_feature: Vec<u32>,
    /// Cost of each sensor.
    pub sensor_cost: Vec<f64>,
    /// Most sensor cost in the whole tree, room for rounding included; infinite without a budget.
    pub sensor_limit: f64,
    /// Whether a feature may be used in an axis-aligned split (`p`).
    pub allowed: Vec<bool>,
    /// Data of hyperplane splits; none where every split is axis-aligned.
    pub planes: Option<Planes>,
}

/// Data of splits over more than one feature.
#[derive(Debug, Clone)]
pub struct Planes {
    /// Feature values, sample-major: feature `f` of sample `i` is `values[i * p + f]`.
    pub values: Vec<f64>,
    /// Most features in one split.
    pub split_size: usize,
    /// Groups of features that may meet in one split, each ascending; none: any may.
    pub groups: Option<Vec<Vec<u32>>>,
    /// Coefficients are integers of at most this size; none: real.
    pub integer_normals: Option<i64>,
}

impl Problem {
    /// The ranks of one feature, by sample.
    pub fn feature(&self, f: usize) -> &[u32] {
        &self.ranks[f * self.n..(f + 1) * self.n]
    }

    /// The feature values of a sample; empty without planes.
    pub fn row(&self, sample: u32) -> &[f64] {
        let start = sample as usize * self.p;
        self.planes.as_ref().map_or(&[], |planes| &planes.values[start..start + self.p])
    }

    /// The feature values, feature-major as the ranks are; none without planes.
    pub fn values_by_feature(&self) -> Option<Vec<f64>> {
        let values = &self.planes.as_ref()?.values;
        let column = |f: usize| (0..self.n).map(move |i| values[i * self.p + f]);
        Some((0..self.p).flat_map(column).collect())
    }

    /// Cost of predicting class `k` for one unit of weight of class `label`.
    pub fn cost(&self, label: usize, k: usize) -> i64 {
        self.costs[label * self.n_classes + k]
    }

    /// Check every length and index once, so that the solvers may rely on them.
    pub fn validate(&self) -> Result<(), ProblemError> {
        let lengths = [
            ("ranks", self.ranks.len(), self.p * self.n),
            ("n_ranks", self.n_ranks.len(), self.p),
            ("labels", self.labels.len(), self.n),
            ("weights", self.weights.len(), self.n),
            ("costs", self.costs.len(), self.n_classes * self.n_classes),
            ("sensor_of_feature", self.sensor_of_feature.len(), self.p),
            ("allowed", self.allowed.len(), self.p),
        ];
        for (name, got, expected) in lengths {
            if got != expected {
                return Err(ProblemError(format!("{name} has {got} entries, expected {expected}")));
            }
        }
        if self.n == 0 || self.p == 0 || self.depth == 0 || self.leaf_size == 0 {
            return Err(ProblemError(format!(
                "n = {}, p = {}, depth = {}, leaf_size = {}: each must be 1 or more",
                self.n, self.p, self.depth, self.leaf_size
            )));
        }
        if let Some(i) = self.labels.iter().position(|&l| l as usize >= self.n_classes) {
            return Err(ProblemError(format!("label {} of sample {i} is not a class", self.labels[i])));
        }
        if self.weights.iter().chain(&self.costs).chain([&self.penalty]).any(|&v| v < 0) {
            return Err(ProblemError("a weight, cost or penalty is negative".into()));
        }
        for f in 0..self.p {
            if let Some(i) = self.feature(f).iter().position(|&r| r >= self.n_ranks[f]) {
                return Err(ProblemError(format!("rank of sample {i} in feature {f} is out of range")));
            }
            if self.sensor_of_feature[f] as usize >= self.sensor_cost.len() {
                return Err(ProblemError(format!("feature {f} names sensor {}", self.sensor_of_feature[f])));
            }
        }
        self.planes.as_ref().map_or(Ok(()), |planes| self.validate_planes(planes))
    }

    fn validate_planes(&self, planes: &Planes) -> Result<(), ProblemError> {
        let (got, expected) = (planes.values.len(), self.p * self.n);
        if got != expected {
            return Err(ProblemError(format!("values has {got} entries, expected {expected}")));
        }
        if let Some(position) = planes.values.iter().position(|value| !value.is_finite()) {
            return Err(ProblemError(format!("value {position} is {}", planes.values[position])));
        }
        if planes.split_size == 0 || planes.integer_normals.is_some_and(|most| most < 1) {
            return Err(ProblemError(format!(
                "split_size = {}, integer_normals = {:?}: each must be 1 or more",
                planes.split_size, planes.integer_normals
            )));
        }
        let members = planes.groups.iter().flatten().flatten();
        match members.into_iter().find(|&&f| f as usize >= self.p) {
            Some(f) => Err(ProblemError(format!("a group names feature {f} of {}", self.p))),
            None => Ok(()),
        }
    }
}

//! A regression problem as it was given: samples, targets, weights and the limits of a tree, in float64.

use crate::input::digests::{float_field, whole_field};
use crate::input::sha256::Sha256;
use crate::regression::slopes::Slopes;

/// Deepest tree that is asked for.
const MOST_DEPTH: usize = 30;

/// A regression problem and the axis-aligned tree of constant leaves that is wanted of it.
#[derive(Debug, Clone, PartialEq)]
pub struct RegressionQuestion {
    /// Number of samples.
    pub n: usize,
    /// Number of features.
    pub p: usize,
    /// Feature values, sample-major.
    pub features: Vec<f64>,
    /// Number to predict, of each sample.
    pub targets: Vec<f64>,
    /// Weight of each sample's error, 0 or more.
    pub weights: Vec<f64>,
    /// Those of the error; None where it is squared.
    pub slopes: Option<Slopes>,
    /// Levels of splits.
    pub depth: usize,
    /// Fewest samples in a leaf.
    pub leaf_size: usize,
    /// Price of a split.
    pub leaf_penalty: f64,
    /// Index of the sensor that each feature is read from.
    pub sensor_of_feature: Vec<u32>,
    /// Cost of each sensor.
    pub sensor_cost: Vec<f64>,
    /// Most sensor cost in the whole tree, room for rounding included; infinite without a budget.
    pub sensor_limit: f64,
}

impl RegressionQuestion {
    /// The question, if all its lengths, indices and signs are what they must be.
    pub fn validated(self) -> Result<Self, String> {
        let lengths = [
            ("features", self.features.len(), self.n.saturating_mul(self.p)),
            ("targets", self.targets.len(), self.n),
            ("weights", self.weights.len(), self.n),
            ("sensor_of_feature", self.sensor_of_feature.len(), self.p),
        ];
        if let Some((name, got, expected)) = lengths.iter().find(|(_, got, expected)| got != expected) {
            return Err(format!("{name} has {got} entries, expected {expected}"));
        }
        let ranges = [
            ("n_samples", self.n, u32::MAX as usize),
            ("n_features", self.p, u32::MAX as usize),
            ("depth", self.depth, MOST_DEPTH),
            ("leaf_size", self.leaf_size, usize::MAX),
        ];
        if let Some((name, got, most)) = ranges.iter().find(|(_, got, most)| !(1..=*most).contains(got)) {
            return Err(format!("{name} is {got}, expected 1 to {most}"));
        }
        if let Some(slopes) = self.slopes.filter(|slopes| !slopes.is_known()) {
            return Err(format!("the error is {slopes:?}, expected an absolute one or that of a quantile"));
        }
        self.check_numbers()?;
        match self.sensor_of_feature.iter().find(|&&sensor| sensor as usize >= self.sensor_cost.len()) {
            Some(index) => {
                Err(format!("sensor_of_feature holds {index}, expected less than {}", self.sensor_cost.len()))
            }
            None => Ok(self),
        }
    }

    fn check_numbers(&self) -> Result<(), String> {
        for (name, values) in [("features", &self.features), ("targets", &self.targets)] {
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(format!("{name} holds {value}, expected finite numbers"));
            }
        }
        let limit = if self.sensor_limit == f64::INFINITY { 0.0 } else { self.sensor_limit };
        let limits = vec![self.leaf_penalty, limit];
        for (name, values) in [("weights", &self.weights), ("sensor_cost", &self.sensor_cost), ("a limit", &limits)] {
            if let Some(value) = values.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
                return Err(format!("{name} holds {value}, expected finite numbers of 0 or more"));
            }
        }
        Ok(())
    }

    /// The SHA-256 of the samples, their targets and weights.
    pub fn data_digest(&self) -> String {
        let mut sha = Sha256::default();
        whole_field(&mut sha, "shape", [self.n, self.p]);
        for (name, values) in [("features", &self.features), ("targets", &self.targets), ("weights", &self.weights)] {
            float_field(&mut sha, name, values);
        }
        sha.hex()
    }

    /// The SHA-256 of everything else: loss, depth, limits, sensors.
    pub fn question_digest(&self) -> String {
        let mut sha = Sha256::default();
        whole_field(&mut sha, "sizes", [usize::from(self.slopes.is_some()), self.depth, self.leaf_size]);
        if let Some(Slopes { up, down, over }) = self.slopes.filter(|&slopes| slopes != Slopes::ABSOLUTE) {
            whole_field(&mut sha, "slopes", [up, down, over].map(|slope| slope as usize));
        }
        float_field(&mut sha, "limits", &[self.leaf_penalty, self.sensor_limit]);
        whole_field(&mut sha, "sensor_of_feature", self.sensor_of_feature.iter().map(|&sensor| sensor as usize));
        float_field(&mut sha, "sensor_cost", &self.sensor_cost);
        sha.hex()
    }
}

//! The problem as it was given: samples, labels, weights, costs and the limits of a tree, in float64.

/// Deepest tree that is asked for.
const MOST_DEPTH: usize = 30;

/// A classification problem and the tree that is wanted of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Number of samples.
    pub n: usize,
    /// Number of features.
    pub p: usize,
    /// Number of classes.
    pub n_classes: usize,
    /// Feature values, sample-major: feature `f` of sample `i` is `features[i * p + f]`; NaN where it is missing, never
    /// infinite.
    pub features: Vec<f64>,
    /// Class of each sample.
    pub labels: Vec<u32>,
    /// Risk weight of each sample, 0 or more.
    pub weights: Vec<f64>,
    /// Cost of predicting label `k` for a sample of class `i`, row-major, 0 or more.
    pub costs: Vec<f64>,
    /// Levels of splits.
    pub depth: usize,
    /// Whether splits are hyperplanes, also where each may read one feature only.
    pub is_hyperplane: bool,
    /// Most features in one split.
    pub split_size: usize,
    /// Fewest samples in a leaf.
    pub leaf_size: usize,
    /// Price of one feature in one split.
    pub leaf_penalty: f64,
    /// Index of the sensor that each feature is read from.
    pub sensor_of_feature: Vec<u32>,
    /// Cost of each sensor.
    pub sensor_cost: Vec<f64>,
    /// Most sensor cost in the whole tree, room for rounding included; infinite without a budget.
    pub sensor_limit: f64,
    /// Groups of features that may meet in one split; none: any may.
    pub allowed_splits: Option<Vec<Vec<u32>>>,
}

impl Question {
    /// The question, if all its lengths, indices and signs are what they must be.
    pub fn validated(self) -> Result<Self, String> {
        self.check_lengths()?;
        self.check_ranges()?;
        self.check_numbers()?;
        self.check_indices()?;
        Ok(self)
    }

    fn check_lengths(&self) -> Result<(), String> {
        let lengths = [
            ("features", self.features.len(), self.n.saturating_mul(self.p)),
            ("labels", self.labels.len(), self.n),
            ("weights", self.weights.len(), self.n),
            ("costs", self.costs.len(), self.n_classes.saturating_mul(self.n_classes)),
            ("sensor_of_feature", self.sensor_of_feature.len(), self.p),
        ];
        match lengths.iter().find(|(_, got, expected)| got != expected) {
            Some((name, got, expected)) => Err(format!("{name} has {got} entries, expected {expected}")),
            None => Ok(()),
        }
    }

    fn check_ranges(&self) -> Result<(), String> {
        let ranges = [
            ("n_samples", self.n, u32::MAX as usize),
            ("n_features", self.p, u32::MAX as usize),
            ("n_classes", self.n_classes, u32::MAX as usize),
            ("depth", self.depth, MOST_DEPTH),
            ("leaf_size", self.leaf_size, usize::MAX),
            ("split_size", self.split_size, if self.is_hyperplane { self.p } else { 1 }),
        ];
        match ranges.iter().find(|(_, got, most)| !(1..=*most).contains(got)) {
            Some((name, got, most)) => Err(format!("{name} is {got}, expected 1 to {most}")),
            None => Ok(()),
        }
    }

    fn check_numbers(&self) -> Result<(), String> {
        let limits = [("leaf_penalty", self.leaf_penalty), ("sensor_limit", self.sensor_limit)];
        let positive = [("weights", &self.weights), ("costs", &self.costs), ("sensor_cost", &self.sensor_cost)];
        let all = positive.iter().flat_map(|(name, values)| values.iter().map(move |&value| (*name, value)));
        let is_wrong =
            |name: &str, value: f64| value.is_nan() || value < 0.0 || (value.is_infinite() && name != "sensor_limit");
        if let Some((name, value)) = all.chain(limits).find(|&(name, value)| is_wrong(name, value)) {
            return Err(format!("{name} holds {value}, expected finite numbers of 0 or more"));
        }
        match self.features.iter().find(|value| value.is_infinite() || (self.is_hyperplane && value.is_nan())) {
            Some(value) => {
                Err(format!("features hold {value}, expected finite numbers, missing ones in axis splits only"))
            }
            None => Ok(()),
        }
    }

    /// Whether some value is missing.
    pub fn has_missing(&self) -> bool {
        self.features.iter().any(|value| value.is_nan())
    }

    fn check_indices(&self) -> Result<(), String> {
        let groups = || self.allowed_splits.iter().flatten().flatten();
        let indices = [
            ("labels", self.labels.iter().max(), self.n_classes),
            ("sensor_of_feature", self.sensor_of_feature.iter().max(), self.sensor_cost.len()),
            ("allowed_splits", groups().max(), self.p),
        ];
        match indices.iter().find(|(_, largest, n)| largest.is_some_and(|&index| index as usize >= *n)) {
            Some((name, Some(index), n)) => Err(format!("{name} holds {index}, expected indices below {n}")),
            _ => Ok(()),
        }
    }

    /// Whether a feature may be used in a split.
    pub fn is_allowed(&self, feature: usize) -> bool {
        let has = |group: &Vec<u32>| group.contains(&(feature as u32));
        self.allowed_splits.as_ref().is_none_or(|groups| groups.iter().any(has))
    }
}

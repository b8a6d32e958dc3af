//! A problem of sequential sensing: samples, costs, and the sensors' costs along a path.

/// Costs of eight labels together.
pub(crate) type Lanes = [f64; 8];

/// Sensors of a path are the bits of one word.
pub(crate) const MOST_SENSORS: usize = 128;

/// Samples and their costs, sensors and their groups, limits of the tree.
#[derive(Debug, Clone)]
pub struct SequentialProblem {
    /// Samples.
    pub n: usize,
    /// Features.
    pub p: usize,
    /// Labels.
    pub n_classes: usize,
    /// Dense rank of feature j at sample i: `ranks[j * n + i]`.
    pub ranks: Vec<u32>,
    /// Cost of label k for sample i: `paid[i * n_classes + k]`.
    pub paid: Vec<f64>,
    /// Multiplicity of each sample in the reading cost.
    pub frequency: Vec<f64>,
    /// Error that each reading adds, by sample.
    pub delay_costs: Vec<f64>,
    /// Price of a split.
    pub penalty: f64,
    /// Levels of splits.
    pub depth: usize,
    /// Samples in a leaf, at least.
    pub leaf_size: usize,
    /// Sensor of each feature.
    pub sensor_of_feature: Vec<usize>,
    /// Cost of each sensor.
    pub sensor_cost: Vec<f64>,
    /// Group of each sensor.
    pub group_of_sensor: Vec<usize>,
    /// Cost of a path's first sensor in a group, beside its own, by group.
    pub setup_costs: Vec<f64>,
    /// Most readings after which a label may be predicted, by label.
    pub most_readings: Vec<usize>,
    /// Whether a feature may be used.
    pub allowed: Vec<bool>,
    /// Sensors that are read before the root.
    pub read: Vec<usize>,
    /// Weight of a unit of reading cost beside the error.
    pub multiplier: f64,
    /// Most reading cost: the least error within it is wanted, instead of the least sum.
    pub cap: Option<f64>,
}

/// Sensors and groups read on the way to a node.
#[derive(Debug, Clone, Copy, Default)]
pub struct Path {
    sensors: u128,
    groups: u128,
    /// Readings so far.
    pub n_read: usize,
}

impl SequentialProblem {
    /// Check every length and index; the error says which does not fit.
    pub fn validate(&self) -> Result<(), String> {
        let (n, p, groups) = (self.n, self.p, self.setup_costs.len());
        let sensors = self.sensor_cost.len();
        let lengths = [
            ("ranks", self.ranks.len(), n * p),
            ("paid", self.paid.len(), n * self.n_classes),
            ("frequency", self.frequency.len(), n),
            ("delay_costs", self.delay_costs.len(), n),
            ("sensor_of_feature", self.sensor_of_feature.len(), p),
            ("allowed", self.allowed.len(), p),
            ("group_of_sensor", self.group_of_sensor.len(), sensors),
            ("most_readings", self.most_readings.len(), self.n_classes),
        ];
        if let Some((name, got, wanted)) = lengths.into_iter().find(|(_, got, wanted)| got != wanted) {
            return Err(format!("{name} has {got} entries; expected {wanted}"));
        }
        if n == 0 || p == 0 || sensors > MOST_SENSORS || groups > MOST_SENSORS {
            return Err(format!("{n} samples, {p} features, {sensors} sensors; expected 1 to {MOST_SENSORS} sensors"));
        }
        let indices = self.sensor_of_feature.iter().chain(&self.read);
        if indices.into_iter().any(|&s| s >= sensors) || self.group_of_sensor.iter().any(|&g| g >= groups) {
            return Err(format!("a sensor or group is out of range; expected below {sensors} and {groups}"));
        }
        Ok(())
    }

    /// The path on which the sensors of `read` have been read.
    pub(crate) fn start(&self) -> Path {
        self.read.iter().fold(Path::default(), |path, &sensor| self.with_sensor(path, sensor).0)
    }

    /// The path after a feature has been read, and the cost of the reading.
    pub(crate) fn step(&self, path: Path, feature: usize) -> (Path, f64) {
        self.with_sensor(path, self.sensor_of_feature[feature])
    }

    fn with_sensor(&self, path: Path, sensor: usize) -> (Path, f64) {
        let (bit, group) = (1_u128 << sensor, self.group_of_sensor[sensor]);
        if path.sensors & bit != 0 {
            return (path, 0.0);
        }
        let is_open = path.groups & (1_u128 << group) != 0;
        let cost = self.sensor_cost[sensor] + if is_open { 0.0 } else { self.setup_costs[group] };
        let next =
            Path { sensors: path.sensors | bit, groups: path.groups | (1_u128 << group), n_read: path.n_read + 1 };
        (next, cost)
    }

    /// The most that `levels` more readings can cost.
    pub(crate) fn most_path_cost(&self, levels: usize) -> f64 {
        let mut costs: Vec<f64> = self
            .sensor_cost
            .iter()
            .zip(&self.group_of_sensor)
            .map(|(cost, &group)| cost + self.setup_costs[group])
            .collect();
        costs.sort_by(|a, b| b.total_cmp(a));
        costs.iter().take(levels).sum()
    }

    /// Zero for labels that may be predicted after `n_read` readings, infinity for the others and for the padding.
    pub(crate) fn closed_labels(&self, n_read: usize) -> Vec<Lanes> {
        let mut closed = vec![[f64::INFINITY; 8]; self.n_classes.div_ceil(8)];
        for (label, &most) in self.most_readings.iter().enumerate() {
            if n_read <= most {
                closed[label / 8][label % 8] = 0.0;
            }
        }
        closed
    }
}

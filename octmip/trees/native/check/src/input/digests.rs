//! The digests that bind a log to a problem.

use super::question::Question;
use super::sha256::Sha256;

impl Question {
    /// The SHA-256 of the samples, their labels and weights.
    pub fn data_digest(&self) -> String {
        let mut sha = Sha256::default();
        whole_field(&mut sha, "shape", [self.n, self.p]);
        float_field(&mut sha, "features", &self.features);
        whole_field(&mut sha, "labels", self.labels.iter().map(|&label| label as usize));
        float_field(&mut sha, "weights", &self.weights);
        sha.hex()
    }

    /// The SHA-256 of everything else: costs, depth, limits, sensors.
    pub fn question_digest(&self) -> String {
        let mut sha = Sha256::default();
        let sizes = [self.n_classes, self.depth, usize::from(self.is_hyperplane), self.split_size, self.leaf_size];
        whole_field(&mut sha, "sizes", sizes);
        float_field(&mut sha, "costs", &self.costs);
        float_field(&mut sha, "limits", &[self.leaf_penalty, self.sensor_limit]);
        whole_field(&mut sha, "sensor_of_feature", self.sensor_of_feature.iter().map(|&sensor| sensor as usize));
        float_field(&mut sha, "sensor_cost", &self.sensor_cost);
        whole_field(&mut sha, "is_limited", [usize::from(self.allowed_splits.is_some())]);
        for group in self.allowed_splits.iter().flatten() {
            whole_field(&mut sha, "group", group.iter().map(|&feature| feature as usize));
        }
        sha.hex()
    }
}

/// Feed a field: its name and length as text, its numbers as 8 bytes each, the lowest first.
pub(crate) fn whole_field(sha: &mut Sha256, name: &str, values: impl IntoIterator<Item = usize>) {
    let bytes: Vec<u8> = values.into_iter().flat_map(|value| (value as u64).to_le_bytes()).collect();
    sha.update(format!("{name} {}\n", bytes.len() / 8).as_bytes());
    sha.update(&bytes);
}

pub(crate) fn float_field(sha: &mut Sha256, name: &str, values: &[f64]) {
    sha.update(format!("{name} {}\n", values.len()).as_bytes());
    for chunk in values.chunks(1 << 16) {
        sha.update(&chunk.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
    }
}

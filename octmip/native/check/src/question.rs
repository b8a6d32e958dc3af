//! What is asked: samples, labels, weights, costs and the limits of a tree, in float64 as they were given.
//!
//! It is read from the JSON file that `octmip solve --write-problem` writes, or made from the same arrays in memory.

use crate::json::{Json, parse};
use crate::sha256::Sha256;

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
    /// Feature values, sample-major: feature `f` of sample `i` is `features[i * p + f]`; finite.
    pub features: Vec<f64>,
    /// Class of each sample.
    pub labels: Vec<u32>,
    /// Risk weight of each sample, 0 or more.
    pub weights: Vec<f64>,
    /// Cost of predicting column `k` for a sample of class row `i`, row-major, 0 or more.
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
    /// Read a problem file; the error says what is wrong with which entry.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let file = parse(text)?;
        let entries = Entries(&file);
        let format = entries.get("format")?;
        if *format != Json::Text("octmip-problem".into()) {
            return Err(format!("format is {}, expected \"octmip-problem\"", shown(format)));
        }
        if entries.whole("version")? != 1 {
            return Err("version is not 1; a newer octmip wrote the file".into());
        }
        let rows = list(entries.get("features")?, "features")?;
        let (n, p) = (rows.len(), list(rows.first().unwrap_or(&Json::Null), "features[0]")?.len());
        let mut features = Vec::with_capacity(n * p);
        for (i, row) in rows.iter().enumerate() {
            let row = numbers(row, &format!("features[{i}]"))?;
            if row.len() != p {
                return Err(format!("features[{i}] has {} values, expected {p}", row.len()));
            }
            features.extend(row);
        }
        let costs = list(entries.get("costs")?, "costs")?;
        let rows: Vec<Vec<f64>> = costs.iter().map(|row| numbers(row, "a row of costs")).collect::<Result<_, _>>()?;
        let groups = match entries.get("allowed_splits")? {
            Json::Null => None,
            groups => {
                let groups = list(groups, "allowed_splits")?.iter();
                Some(groups.map(|group| wholes(group, "a group of allowed_splits")).collect::<Result<_, _>>()?)
            }
        };
        let question = Self {
            n,
            p,
            n_classes: rows.len(),
            features,
            labels: wholes(entries.get("labels")?, "labels")?,
            weights: numbers(entries.get("weights")?, "weights")?,
            costs: rows.concat(),
            depth: entries.whole("depth")?,
            is_hyperplane: match entries.get("split")? {
                Json::Text(kind) if kind == "axis" => false,
                Json::Text(kind) if kind == "hyperplane" => true,
                other => return Err(format!("split is {}, expected \"axis\" or \"hyperplane\"", shown(other))),
            },
            split_size: entries.whole("split_size")?,
            leaf_size: entries.whole("leaf_size")?,
            leaf_penalty: number(entries.get("leaf_penalty")?, "leaf_penalty")?,
            sensor_of_feature: wholes(entries.get("sensor_of_feature")?, "sensor_of_feature")?,
            sensor_cost: numbers(entries.get("sensor_cost")?, "sensor_cost")?,
            sensor_limit: match entries.get("sensor_limit")? {
                Json::Null => f64::INFINITY,
                limit => number(limit, "sensor_limit")?,
            },
            allowed_splits: groups,
        };
        question.validated()
    }

    /// The question, if all its lengths, indices and signs are what they must be.
    pub fn validated(self) -> Result<Self, String> {
        let lengths = [
            ("features", self.features.len(), self.n.saturating_mul(self.p)),
            ("labels", self.labels.len(), self.n),
            ("weights", self.weights.len(), self.n),
            ("costs", self.costs.len(), self.n_classes.saturating_mul(self.n_classes)),
            ("sensor_of_feature", self.sensor_of_feature.len(), self.p),
        ];
        if let Some((name, got, expected)) = lengths.iter().find(|(_, got, expected)| got != expected) {
            return Err(format!("{name} has {got} entries, expected {expected}"));
        }
        let ranges = [
            ("n_samples", self.n, u32::MAX as usize),
            ("n_features", self.p, u32::MAX as usize),
            ("n_classes", self.n_classes, u32::MAX as usize),
            ("depth", self.depth, MOST_DEPTH),
            ("leaf_size", self.leaf_size, usize::MAX),
            ("split_size", self.split_size, if self.is_hyperplane { self.p } else { 1 }),
        ];
        if let Some((name, got, most)) = ranges.iter().find(|(_, got, most)| !(1..=*most).contains(got)) {
            return Err(format!("{name} is {got}, expected 1 to {most}"));
        }
        let limits = [("leaf_penalty", self.leaf_penalty), ("sensor_limit", self.sensor_limit)];
        let positive = [("weights", &self.weights), ("costs", &self.costs), ("sensor_cost", &self.sensor_cost)];
        let all = positive.iter().flat_map(|(name, values)| values.iter().map(move |&value| (*name, value)));
        let is_wrong =
            |name: &str, value: f64| value.is_nan() || value < 0.0 || (value.is_infinite() && name != "sensor_limit");
        if let Some((name, value)) = all.chain(limits).find(|&(name, value)| is_wrong(name, value)) {
            return Err(format!("{name} holds {value}, expected finite numbers of 0 or more"));
        }
        if let Some(value) = self.features.iter().find(|value| !value.is_finite()) {
            return Err(format!("features hold {value}, expected finite numbers"));
        }
        let groups = || self.allowed_splits.iter().flatten().flatten();
        let indices = [
            ("labels", self.labels.iter().max(), self.n_classes),
            ("sensor_of_feature", self.sensor_of_feature.iter().max(), self.sensor_cost.len()),
            ("allowed_splits", groups().max(), self.p),
        ];
        match indices.iter().find(|(_, largest, n)| largest.is_some_and(|&index| index as usize >= *n)) {
            Some((name, Some(index), n)) => Err(format!("{name} holds {index}, expected indices below {n}")),
            _ => Ok(self),
        }
    }

    /// Whether a feature may be used in a split.
    pub fn is_allowed(&self, feature: usize) -> bool {
        let has = |group: &Vec<u32>| group.contains(&(feature as u32));
        self.allowed_splits.as_ref().is_none_or(|groups| groups.iter().any(has))
    }

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
fn whole_field(sha: &mut Sha256, name: &str, values: impl IntoIterator<Item = usize>) {
    let bytes: Vec<u8> = values.into_iter().flat_map(|value| (value as u64).to_le_bytes()).collect();
    sha.update(format!("{name} {}\n", bytes.len() / 8).as_bytes());
    sha.update(&bytes);
}

fn float_field(sha: &mut Sha256, name: &str, values: &[f64]) {
    sha.update(format!("{name} {}\n", values.len()).as_bytes());
    for chunk in values.chunks(1 << 16) {
        sha.update(&chunk.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
    }
}

/// A value as a message can show it: a text's beginning, or that it is none.
fn shown(value: &Json) -> String {
    if let Json::Text(text) = value {
        format!("{:?}", text.chars().take(40).collect::<String>())
    } else {
        "no text".into()
    }
}

/// The entries of an object.
struct Entries<'a>(&'a Json);

impl<'a> Entries<'a> {
    fn get(&self, name: &str) -> Result<&'a Json, String> {
        let Json::Object(entries) = self.0 else { return Err("the file holds no object".into()) };
        let entry = entries.iter().find(|(key, _)| key == name);
        entry.map(|(_, value)| value).ok_or_else(|| format!("the entry {name:?} is missing"))
    }

    fn whole(&self, name: &str) -> Result<usize, String> {
        whole(self.get(name)?, name)
    }
}

fn list<'a>(value: &'a Json, name: &str) -> Result<&'a [Json], String> {
    if let Json::List(values) = value { Ok(values) } else { Err(format!("{name} is no list")) }
}

fn number(value: &Json, name: &str) -> Result<f64, String> {
    if let Json::Number(number) = value { Ok(*number) } else { Err(format!("{name} holds what is no number")) }
}

fn numbers(value: &Json, name: &str) -> Result<Vec<f64>, String> {
    list(value, name)?.iter().map(|value| number(value, name)).collect()
}

fn whole(value: &Json, name: &str) -> Result<usize, String> {
    let value = number(value, name)?;
    let is_whole = (0.0..2f64.powi(53)).contains(&value) && value.fract() == 0.0;
    if is_whole { Ok(value as usize) } else { Err(format!("{name} holds {value}, expected a whole number")) }
}

fn wholes(value: &Json, name: &str) -> Result<Vec<u32>, String> {
    let index = |value: &Json| {
        let value = whole(value, name)?;
        u32::try_from(value).map_err(|_| format!("{name} holds {value}, expected a number below 2^32"))
    };
    list(value, name)?.iter().map(index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"{"format": "octmip-problem", "version": 1, "feature_names": ["a", "b"],
        "features": [[0.5, 1], [1.5, -2e300]], "labels": [0, 1], "weights": [1, 0.25], "costs": [[0, 1], [3, 0]],
        "depth": 2, "split": "axis", "split_size": 1, "leaf_size": 1, "leaf_penalty": 0.5,
        "sensor_of_feature": [0, 0], "sensor_cost": [1.5], "sensor_limit": null, "allowed_splits": [[1]]}"#;

    #[test]
    fn a_problem_file_is_read() {
        let question = Question::from_json(FILE).expect("the file is right");
        assert_eq!((question.n, question.p, question.n_classes, question.depth), (2, 2, 2, 2));
        assert_eq!(question.features, [0.5, 1.0, 1.5, -2e300]);
        assert_eq!(question.sensor_limit, f64::INFINITY);
        assert_eq!([question.is_allowed(0), question.is_allowed(1)], [false, true]);
    }

    /// The digests that octmip.formats.problem_file writes of the same problem, its penalty, names and sensors included.
    #[test]
    fn the_digests_are_those_of_the_writer() {
        let question = Question::from_json(FILE).expect("the file is right");
        let data = "ea2156859d3c807d3a8179cdd06cbf0b695ab9a2fefc967b1f8c86bc5438c293";
        assert_eq!(question.data_digest(), data);
        let asked = "e975103f6cc07f126d2ff5435479d231a9b6c954e604b724b05dc6a10d8680f7";
        assert_eq!(question.question_digest(), asked);
    }

    #[test]
    fn every_change_of_the_problem_changes_a_digest() {
        let question = Question::from_json(FILE).expect("the file is right");
        let digests = (question.data_digest(), question.question_digest());
        let data = [("0.5, 1", "0.5, 2"), ("\"labels\": [0, 1]", "\"labels\": [1, 1]"), ("0.25]", "0.5]")];
        for (old, new) in data {
            let other = Question::from_json(&FILE.replace(old, new)).expect("still right");
            assert_ne!(other.data_digest(), digests.0, "{new}");
        }
        let asked = [
            ("[3, 0]", "[3, 1]"),
            ("depth\": 2", "depth\": 3"),
            ("[[1]]", "[[0]]"),
            ("[[1]]", "null"),
            ("null, \"all", "4, \"all"),
            ("\"axis\"", "\"hyperplane\""),
            ("penalty\": 0.5", "penalty\": 0"),
            ("[1.5]", "[1]"),
        ];
        for (old, new) in asked {
            let other = Question::from_json(&FILE.replace(old, new)).expect("still right");
            assert_ne!(other.question_digest(), digests.1, "{new}");
            assert_eq!(other.data_digest(), digests.0);
        }
    }

    #[test]
    fn each_wrong_entry_is_refused_by_name() {
        let changes = [
            ("octmip-problem", "octmip-tree", "format"),
            ("version\": 1", "version\": 2", "version"),
            ("[1.5, -2e300]", "[1.5]", "features[1]"),
            ("\"labels\": [0, 1]", "\"labels\": [0, 2]", "labels"),
            ("\"labels\": [0, 1]", "\"labels\": [0]", "labels"),
            ("0.25]", "-1]", "weights"),
            ("[3, 0]", "[3]", "costs"),
            ("depth\": 2", "depth\": 0", "depth"),
            ("depth\": 2", "depth\": 31", "depth"),
            ("depth\": 2", "depth\": 1.5", "depth"),
            ("\"axis\"", "\"line\"", "split"),
            ("split_size\": 1", "split_size\": 2", "split_size"),
            ("leaf_size\": 1", "leaf_size\": 0", "leaf_size"),
            ("[0, 0], \"sensor_cost", "[0, 1], \"sensor_cost", "sensor_of_feature"),
            ("[[1]]", "[[2]]", "allowed_splits"),
            ("[[1]]", "7", "allowed_splits"),
            ("null", "\"x\"", "sensor_limit"),
            ("\"depth\": 2,", "", "depth"),
            ("\"weights\": [1, 0.25]", "\"weights\": 3", "weights"),
        ];
        for (old, new, name) in changes {
            assert!(FILE.contains(old), "{old}");
            let refused = Question::from_json(&FILE.replacen(old, new, 1));
            assert!(refused.as_ref().is_err_and(|error| error.contains(name)), "{new}: {refused:?}");
        }
    }
}

//! Problem files: the JSON that `octmip solve --write-problem` writes, read as a question.

use super::json::{Json, parse};
use super::question::Question;

impl Question {
    /// Read a problem file; the error says what is wrong with which entry.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let file = parse(text)?;
        let entries = Entries(&file);
        entries.check_format("octmip-problem", 2)?;
        let (n, p, features) = entries.features()?;
        let costs = list(entries.get("costs")?, "costs")?;
        let rows: Vec<Vec<f64>> = costs.iter().map(|row| numbers(row, "a row of costs")).collect::<Result<_, _>>()?;
        let allowed_splits = entries.allowed_splits()?;
        let question = Self {
            n,
            p,
            n_classes: rows.len(),
            features,
            labels: wholes(entries.get("labels")?, "labels")?,
            weights: numbers(entries.get("weights")?, "weights")?,
            costs: rows.concat(),
            depth: entries.whole("depth")?,
            is_hyperplane: entries.is_hyperplane()?,
            split_size: entries.whole("split_size")?,
            leaf_size: entries.whole("leaf_size")?,
            leaf_penalty: number(entries.get("leaf_penalty")?, "leaf_penalty")?,
            sensor_of_feature: wholes(entries.get("sensor_of_feature")?, "sensor_of_feature")?,
            sensor_cost: numbers(entries.get("sensor_cost")?, "sensor_cost")?,
            sensor_limit: entries.sensor_limit()?,
            allowed_splits,
        };
        question.validated()
    }
}

/// A value as a message can show it: a text's beginning, or that it is none.
pub(crate) fn shown(value: &Json) -> String {
    if let Json::Text(text) = value {
        format!("{:?}", text.chars().take(40).collect::<String>())
    } else {
        "no text".into()
    }
}

/// The entries of an object.
pub(crate) struct Entries<'a>(pub(crate) &'a Json);

impl<'a> Entries<'a> {
    pub(crate) fn get(&self, name: &str) -> Result<&'a Json, String> {
        let Json::Object(entries) = self.0 else { return Err("the file holds no object".into()) };
        let entry = entries.iter().find(|(key, _)| key == name);
        entry.map(|(_, value)| value).ok_or_else(|| format!("the entry {name:?} is missing"))
    }

    pub(crate) fn whole(&self, name: &str) -> Result<usize, String> {
        whole(self.get(name)?, name)
    }

    pub(crate) fn check_format(&self, expected: &str, newest: usize) -> Result<(), String> {
        let format = self.get("format")?;
        if *format != Json::Text(expected.into()) {
            return Err(format!("format is {}, expected {expected:?}", shown(format)));
        }
        if !(1..=newest).contains(&self.whole("version")?) {
            return Err(format!("version is not 1 to {newest}; a newer octmip wrote the file"));
        }
        Ok(())
    }

    /// Numbers of samples and of features, and the values, sample-major; since version 2 `null` is a missing one.
    pub(crate) fn features(&self) -> Result<(usize, usize, Vec<f64>), String> {
        let rows = list(self.get("features")?, "features")?;
        let (n, p) = (rows.len(), list(rows.first().unwrap_or(&Json::Null), "features[0]")?.len());
        let takes_missing = self.whole("version")? > 1;
        let mut features = Vec::with_capacity(n * p);
        for (i, row) in rows.iter().enumerate() {
            let name = format!("features[{i}]");
            let value = |value: &Json| match value {
                Json::Null if takes_missing => Ok(f64::NAN),
                value => number(value, &name),
            };
            let row: Vec<f64> = list(row, &name)?.iter().map(value).collect::<Result<_, _>>()?;
            if row.len() != p {
                return Err(format!("features[{i}] has {} values, expected {p}", row.len()));
            }
            features.extend(row);
        }
        Ok((n, p, features))
    }

    fn is_hyperplane(&self) -> Result<bool, String> {
        match self.get("split")? {
            Json::Text(split) if split == "axis" => Ok(false),
            Json::Text(split) if split == "hyperplane" => Ok(true),
            other => Err(format!("split is {}, expected \"axis\" or \"hyperplane\"", shown(other))),
        }
    }

    pub(crate) fn sensor_limit(&self) -> Result<f64, String> {
        match self.get("sensor_limit")? {
            Json::Null => Ok(f64::INFINITY),
            limit => number(limit, "sensor_limit"),
        }
    }

    fn allowed_splits(&self) -> Result<Option<Vec<Vec<u32>>>, String> {
        let groups = self.get("allowed_splits")?;
        if *groups == Json::Null {
            return Ok(None);
        }
        let groups = list(groups, "allowed_splits")?.iter();
        groups.map(|group| wholes(group, "a group of allowed_splits")).collect::<Result<_, _>>().map(Some)
    }
}

fn list<'a>(value: &'a Json, name: &str) -> Result<&'a [Json], String> {
    if let Json::List(values) = value { Ok(values) } else { Err(format!("{name} is no list")) }
}

pub(crate) fn number(value: &Json, name: &str) -> Result<f64, String> {
    if let Json::Number(number) = value { Ok(*number) } else { Err(format!("{name} holds what is no number")) }
}

pub(crate) fn numbers(value: &Json, name: &str) -> Result<Vec<f64>, String> {
    list(value, name)?.iter().map(|value| number(value, name)).collect()
}

fn whole(value: &Json, name: &str) -> Result<usize, String> {
    let value = number(value, name)?;
    let is_whole = (0.0..2f64.powi(53)).contains(&value) && value.fract() == 0.0;
    if is_whole { Ok(value as usize) } else { Err(format!("{name} holds {value}, expected a whole number")) }
}

pub(crate) fn wholes(value: &Json, name: &str) -> Result<Vec<u32>, String> {
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

    #[test]
    fn a_value_may_be_missing_since_version_2() {
        let file = FILE.replace("version\": 1", "version\": 2").replace("-2e300", "null");
        let question = Question::from_json(&file).expect("the file is right");
        assert!(question.has_missing() && question.features[3].is_nan());
        assert!(Question::from_json(&file.replace("\"axis\"", "\"hyperplane\"")).is_err());
    }

    /// The digests that octmip.trees.question.problem_file writes of the same problem, its penalty, names and sensors
    /// included.
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
            ("version\": 1", "version\": 3", "version"),
            ("[1.5, -2e300]", "[1.5, null]", "features[1]"),
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

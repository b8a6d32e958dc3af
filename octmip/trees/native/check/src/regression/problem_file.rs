//! Problem files of regression: the JSON that `octmip solve --target ... --write-problem` writes, read as a question.

use crate::input::json::{Json, parse};
use crate::input::problem_file::{Entries, number, numbers, shown, wholes};
use crate::regression::question::RegressionQuestion;
use crate::regression::slopes::Slopes;

/// Format of the files.
pub const FORMAT: &str = "octmip-regression-problem";

impl RegressionQuestion {
    /// Whether a text is a problem file of regression, whatever else is wrong with it.
    pub fn is_file(text: &str) -> bool {
        parse(text)
            .is_ok_and(|file| Entries(&file).get("format").is_ok_and(|format| *format == Json::Text(FORMAT.into())))
    }

    /// Read a problem file; the error says what is wrong with which entry.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let file = parse(text)?;
        let entries = Entries(&file);
        entries.check_format(FORMAT, 1)?;
        let (n, p, features) = entries.features()?;
        let loss = entries.get("loss")?;
        let named = if let Json::Text(name) = loss { Slopes::of_name(name) } else { None };
        let expected = "\"squared\", \"absolute\" or a quantile such as \"quantile:9/10\"";
        let slopes = named.ok_or_else(|| format!("loss is {}, expected {expected}", shown(loss)))?;
        let question = Self {
            n,
            p,
            features,
            targets: numbers(entries.get("targets")?, "targets")?,
            weights: numbers(entries.get("weights")?, "weights")?,
            slopes,
            depth: entries.whole("depth")?,
            leaf_size: entries.whole("leaf_size")?,
            leaf_penalty: number(entries.get("leaf_penalty")?, "leaf_penalty")?,
            sensor_of_feature: wholes(entries.get("sensor_of_feature")?, "sensor_of_feature")?,
            sensor_cost: numbers(entries.get("sensor_cost")?, "sensor_cost")?,
            sensor_limit: entries.sensor_limit()?,
        };
        question.validated()
    }
}

//! The cases of a proof under a budget: every tree reads a sensor or does not.

use crate::log::cursor::Cursor;
use crate::refusal::{Checked, ensure};

/// The decisions that hold for the case whose proof comes next in a log.
///
/// A decision is followed by the proof of the trees that do not read the sensor, and then by that of those that do.
/// They are kept in a list and not on the stack, so that a log of many decisions cannot exhaust it.
pub(crate) struct Decisions {
    /// For each sensor what is decided of it.
    read: Vec<Option<bool>>,
    /// The sensors that are decided, the last one last.
    path: Vec<usize>,
}

impl Decisions {
    pub(crate) fn new(n_sensors: usize) -> Self {
        Self { read: vec![None; n_sensors], path: Vec::new() }
    }

    /// Read the decisions that come next in a log.
    pub(crate) fn read(&mut self, cursor: &mut Cursor<'_>) -> Checked<()> {
        while cursor.peek().is_some_and(|line| line.starts_with("S ")) {
            let [sensor] = cursor.expect("S")?;
            ensure!(self.decide(sensor), cursor.line(), "sensor {sensor} cannot be decided here");
        }
        Ok(())
    }

    /// Decide a sensor: first that it is not read. False if there is no such sensor, or it is decided already.
    fn decide(&mut self, sensor: i64) -> bool {
        let sensor = usize::try_from(sensor).unwrap_or(usize::MAX);
        let is_open = self.read.get(sensor) == Some(&None);
        if is_open {
            self.read[sensor] = Some(false);
            self.path.push(sensor);
        }
        is_open
    }

    /// Go on from a case that is proven to the next one; false if that was the last.
    pub(crate) fn go_on(&mut self) -> bool {
        while let Some(&sensor) = self.path.last() {
            if self.read[sensor] == Some(false) {
                self.read[sensor] = Some(true);
                return true;
            }
            self.read[sensor] = None;
            self.path.pop();
        }
        false
    }

    /// Whether trees of this case may read each sensor, if they read `most` different ones at most: one that cannot be
    /// paid for beside those that are read is not read either.
    pub(crate) fn may_read(&self, sensor_cost: &[f64], sensor_limit: f64, most: usize) -> Vec<bool> {
        let taken: Vec<usize> = (0..self.read.len()).filter(|&s| self.read[s] == Some(true)).collect();
        let paid: f64 = taken.iter().map(|&s| sensor_cost[s]).sum();
        // Sums are rounded: whatever may be within the limit is.
        let is_within = |s: usize| (paid + sensor_cost[s]) * (1.0 - 1e-12) <= sensor_limit;
        let may_read = |s: usize| self.read[s].unwrap_or_else(|| taken.len() < most && is_within(s));
        (0..self.read.len()).map(may_read).collect()
    }
}

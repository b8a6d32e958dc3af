//! Time, nodes and Ctrl-C.

use std::time::Instant;

use crate::control::{KeepGoing, Limits, Progress, Stop};

/// Says when to stop.
pub struct Watch<'a> {
    start: Instant,
    limits: Limits,
    going: KeepGoing<'a>,
    /// What bounds and rooms of the root hold beside the objective.
    added: f64,
    /// Cuts evaluated.
    pub n_cuts: u64,
    /// Why the search stops, if it does.
    pub stop: Option<Stop>,
}

impl<'a> Watch<'a> {
    /// A watch that starts now.
    pub fn new(limits: Limits, added: f64, going: KeepGoing<'a>) -> Self {
        Self { start: Instant::now(), limits, going, added, n_cuts: 0, stop: None }
    }

    /// Stop when the root's bound is as near to its best as was asked for.
    pub fn compare(&mut self, bound: f64, best: f64) {
        let (bound, best) = (bound - self.added, best - self.added);
        if self.limits.gap > 0.0 && best.is_finite() && best - bound <= self.limits.gap * best.abs() {
            self.stop = self.stop.or(Some(Stop::Gap));
        }
    }

    /// Count one cut; whether the search must stop.
    pub fn must_stop(&mut self) -> bool {
        if self.stop.is_none() {
            self.n_cuts += 1;
            let seconds = self.start.elapsed().as_secs_f64();
            let state = Progress { seconds, objective: i64::MAX, bound: 0, n_nodes: self.n_cuts };
            if seconds >= self.limits.seconds {
                self.stop = Some(Stop::Time);
            } else if self.n_cuts as f64 > self.limits.nodes {
                self.stop = Some(Stop::Nodes);
            } else if !(self.going)(state) {
                self.stop = Some(Stop::Interrupted);
            }
        }
        self.stop.is_some()
    }
}

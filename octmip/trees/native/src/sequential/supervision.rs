//! Supervision of a search in the calling thread, which polls at every cut.

use crate::control::{KeepGoing, Limits, Progress, Stop};
use crate::supervise::Supervision;

/// Limits of a search, and the cuts it has evaluated.
pub(crate) struct CutSupervision<'a> {
    supervision: Supervision,
    keep_going: KeepGoing<'a>,
    /// Part of the root's bounds and rooms that is not the objective.
    added: f64,
    /// Cuts evaluated.
    pub(crate) n_cuts: u64,
}

impl<'a> CutSupervision<'a> {
    /// A search that begins now.
    pub(crate) fn new(limits: Limits, added: f64, keep_going: KeepGoing<'a>) -> Self {
        Self { supervision: Supervision::new(limits), keep_going, added, n_cuts: 0 }
    }

    /// Stop when the root's bound is as near to its best as was asked for.
    pub(crate) fn compare(&mut self, bound: f64, best: f64) {
        if best.is_finite()
            && let Some(gap) = self.supervision.gap_reached(best - self.added - (bound - self.added), best - self.added)
        {
            self.supervision.stop(gap);
        }
    }

    /// Count one cut; whether the search must stop.
    pub(crate) fn must_stop(&mut self) -> bool {
        if self.stop().is_none() {
            if let Some(limit) = self.supervision.spent(self.n_cuts, 0.0) {
                self.supervision.stop(limit);
            }
            self.n_cuts += 1;
            let state = Progress { seconds: 0.0, objective: i64::MAX, bound: 0, n_nodes: self.n_cuts };
            self.supervision.poll(&mut self.keep_going, state);
        }
        self.stop().is_some()
    }

    /// Why the search must stop, if it must.
    pub(crate) fn stop(&self) -> Option<Stop> {
        self.supervision.reason()
    }
}

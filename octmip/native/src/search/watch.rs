//! What the threads of a search tell each other: the best objective, limits, and who cannot be beaten.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, AtomicUsize, Ordering};

use crate::control::{KeepGoing, Limits, Progress, Stop};
use crate::exact::effort::Control;
use crate::supervise::Supervision;

/// The bound that needs no search: no cost is negative.
pub const TRIVIAL_BOUND: i64 = 0;

/// See the module.
#[derive(Debug)]
pub struct Watch {
    /// Clock and limits.
    pub supervision: Supervision,
    /// The first place of the round that cannot be beaten: later ones need not go on, earlier ones must.
    first_optimal: AtomicUsize,
    objective: AtomicI64,
    n_visits: AtomicU64,
    /// Tells the exact blocks to give up.
    pub control: Control,
    /// The same for the lines over pairs of features.
    pub is_stopped: Arc<AtomicBool>,
}

/// A watch as one restart asks it: its place in the present round decides whether it goes on.
#[derive(Debug, Clone, Copy)]
pub struct Supervisor<'a> {
    /// The watch.
    pub watch: &'a Watch,
    /// The place.
    pub place: usize,
}

impl Supervisor<'_> {
    /// Whether to go on. Every loop whose work grows with the problem asks this often enough.
    pub fn goes_on(&self) -> bool {
        self.watch.goes_on(self.place)
    }
}

impl Watch {
    /// A search that begins now.
    pub fn new(limits: Limits) -> Self {
        let supervision = Supervision::new(limits);
        Self {
            first_optimal: AtomicUsize::new(usize::MAX),
            objective: AtomicI64::new(i64::MAX),
            n_visits: AtomicU64::new(0),
            control: Control::reading(supervision.flag()),
            is_stopped: supervision.flag().clone(),
            supervision,
        }
    }

    /// Whether the restart at this place of its round should go on.
    pub fn goes_on(&self, place: usize) -> bool {
        !self.supervision.check_time()
            && self.supervision.reason().is_none()
            && place < self.first_optimal.load(Ordering::Relaxed)
            && self.supervision.spent(self.n_visits(), 0.0).is_none()
    }

    /// A tree of this objective is known, and so many nodes were visited since the last word.
    pub fn found(&self, objective: i64, n_visits: u64) {
        self.objective.fetch_min(objective, Ordering::Relaxed);
        self.n_visits.fetch_add(n_visits, Ordering::Relaxed);
    }

    /// Nothing beats what the restart at this place of its round has found.
    pub fn is_best(&self, place: usize) {
        self.first_optimal.fetch_min(place, Ordering::Relaxed);
    }

    /// Whether some restart cannot be beaten.
    pub fn has_best(&self) -> bool {
        self.first_optimal.load(Ordering::Relaxed) < usize::MAX
    }

    /// Tell the caller how far the search is, and take up its word to stop.
    pub fn look(&self, keep_going: KeepGoing) {
        let progress = Progress {
            seconds: 0.0,
            objective: self.objective.load(Ordering::Relaxed),
            bound: TRIVIAL_BOUND,
            n_nodes: self.n_visits(),
        };
        self.supervision.poll(keep_going, progress);
        // Exact blocks and lines read the flag alone.
        if !self.goes_on(0) {
            self.supervision.halt();
        }
    }

    /// Nodes visited.
    pub fn n_visits(&self) -> u64 {
        self.n_visits.load(Ordering::Relaxed)
    }

    /// Why the search ended.
    pub fn stop(&self) -> Stop {
        let limit = || self.supervision.spent(self.n_visits(), 0.0);
        self.supervision.reason().or_else(limit).unwrap_or(Stop::Finished)
    }
}

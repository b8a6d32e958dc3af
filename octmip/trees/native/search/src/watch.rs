//! The state that the threads of a search share: the best objective, limits, and the restart that cannot be beaten.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, AtomicUsize, Ordering};

use octmip_frame::control::{KeepGoing, Limits, Progress, Stop};
use octmip_frame::effort::Control;
use octmip_frame::supervise::Supervision;

/// The bound that needs no search: no cost is negative.
pub(crate) const TRIVIAL_BOUND: i64 = 0;

/// Seconds beyond the time limit in which answers of other processes are waited for.
const LATE: f64 = 2.0;

/// The shared state of a running search.
#[derive(Debug)]
pub(crate) struct Watch {
    /// Clock and limits.
    pub(crate) supervision: Supervision,
    /// The first place of the round that cannot be beaten: later ones need not go on, earlier ones must.
    first_optimal: AtomicUsize,
    objective: AtomicI64,
    n_visits: AtomicU64,
    /// The flag by which exact blocks give up.
    pub(crate) control: Control,
    /// The same for the lines over pairs of features.
    pub(crate) is_stopped: Arc<AtomicBool>,
}

/// A watch as one restart asks it: its place in the present round decides whether it goes on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Supervisor<'a> {
    /// The watch.
    pub(crate) watch: &'a Watch,
    /// The place.
    pub(crate) place: usize,
}

impl Supervisor<'_> {
    /// Whether to go on. Every loop whose work grows with the problem asks this often enough.
    pub(crate) fn goes_on(&self) -> bool {
        self.watch.goes_on(self.place)
    }
}

impl Watch {
    /// A search that begins now.
    pub(crate) fn new(limits: Limits) -> Self {
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
    pub(crate) fn goes_on(&self, place: usize) -> bool {
        !self.supervision.check_time()
            && self.supervision.reason().is_none()
            && place < self.first_optimal.load(Ordering::Relaxed)
            && self.supervision.spent(self.n_visits(), 0.0).is_none()
    }

    /// Whether a turn that another process takes for the restart at this place is still waited for. The time limit ends
    /// it there, and its answer takes a moment longer.
    pub(crate) fn waits(&self, place: usize) -> bool {
        let supervision = &self.supervision;
        supervision.seconds() < supervision.limits().seconds + LATE
            && supervision.reason().is_none_or(|reason| reason == Stop::Time)
            && place < self.first_optimal.load(Ordering::Relaxed)
            && supervision.spent(self.n_visits(), 0.0).is_none()
    }

    /// What is left of the limits.
    pub(crate) fn left(&self) -> Limits {
        let limits = self.supervision.limits();
        let (seconds, nodes) = (limits.seconds - self.supervision.seconds(), limits.nodes - self.n_visits() as f64);
        Limits { seconds, nodes, ..*limits }
    }

    /// Whether a restart at this place of its round may have been stopped by one that cannot be beaten.
    pub(crate) fn is_beaten(&self, place: usize) -> bool {
        self.first_optimal.load(Ordering::Relaxed) < place
    }

    /// A tree of this objective is known, and so many nodes were visited since the last report.
    pub(crate) fn found(&self, objective: i64, n_visits: u64) {
        self.objective.fetch_min(objective, Ordering::Relaxed);
        self.n_visits.fetch_add(n_visits, Ordering::Relaxed);
    }

    /// Nothing beats the tree that the restart at this place of its round has found.
    pub(crate) fn is_best(&self, place: usize) {
        self.first_optimal.fetch_min(place, Ordering::Relaxed);
    }

    /// Whether some restart cannot be beaten.
    pub(crate) fn has_best(&self) -> bool {
        self.first_optimal.load(Ordering::Relaxed) < usize::MAX
    }

    /// Report progress to the caller, who may wish to stop.
    pub(crate) fn look(&self, keep_going: KeepGoing) {
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
    pub(crate) fn n_visits(&self) -> u64 {
        self.n_visits.load(Ordering::Relaxed)
    }

    /// The reason for which the search ended.
    pub(crate) fn stop(&self) -> Stop {
        let limit = || self.supervision.spent(self.n_visits(), 0.0);
        self.supervision.reason().or_else(limit).unwrap_or(Stop::Finished)
    }
}

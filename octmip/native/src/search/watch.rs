//! What the threads of a search tell each other: the best objective, limits, and who cannot be beaten.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use crate::control::{KeepGoing, Limits, Progress, Stop};
use crate::exact::effort::Control;

/// The bound that needs no search: no cost is negative.
pub const TRIVIAL_BOUND: i64 = 0;

/// See the module.
#[derive(Debug)]
pub struct Watch {
    started: Instant,
    limits: Limits,
    /// The first place of the round that cannot be beaten: later ones need not go on, earlier ones must.
    first_optimal: AtomicUsize,
    objective: AtomicI64,
    n_visits: AtomicU64,
    is_interrupted: AtomicBool,
    is_out_of_time: AtomicBool,
    /// Tells the exact blocks to give up.
    pub control: Control,
    /// The same for the lines over pairs of features.
    pub is_stopped: AtomicBool,
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
        Self {
            started: Instant::now(),
            limits,
            first_optimal: AtomicUsize::new(usize::MAX),
            objective: AtomicI64::new(i64::MAX),
            n_visits: AtomicU64::new(0),
            is_interrupted: AtomicBool::new(false),
            is_out_of_time: AtomicBool::new(false),
            control: Control::new(),
            is_stopped: AtomicBool::new(false),
        }
    }

    /// Whether the restart at this place of its round should go on.
    pub fn goes_on(&self, place: usize) -> bool {
        if self.started.elapsed().as_secs_f64() >= self.limits.seconds {
            self.is_out_of_time.store(true, Ordering::Relaxed);
        }
        !self.is_interrupted.load(Ordering::Relaxed)
            && !self.is_out_of_time.load(Ordering::Relaxed)
            && place < self.first_optimal.load(Ordering::Relaxed)
            && (self.n_visits.load(Ordering::Relaxed) as f64) < self.limits.nodes
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
            seconds: self.started.elapsed().as_secs_f64(),
            objective: self.objective.load(Ordering::Relaxed),
            bound: TRIVIAL_BOUND,
            n_nodes: self.n_visits(),
        };
        if !keep_going(progress) {
            self.is_interrupted.store(true, Ordering::Relaxed);
        }
        // Exact blocks look at the control alone.
        if !self.goes_on(0) {
            self.control.stop();
            self.is_stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Nodes visited.
    pub fn n_visits(&self) -> u64 {
        self.n_visits.load(Ordering::Relaxed)
    }

    /// Why the search ended.
    pub fn stop(&self) -> Stop {
        if self.is_interrupted.load(Ordering::Relaxed) {
            Stop::Interrupted
        } else if self.is_out_of_time.load(Ordering::Relaxed) {
            Stop::Time
        } else if self.n_visits() as f64 >= self.limits.nodes {
            Stop::Nodes
        } else {
            Stop::Finished
        }
    }
}

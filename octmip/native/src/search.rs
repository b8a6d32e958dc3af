//! Local search: good trees of any size, without a proof.
//!
//! Independent restarts, each a descent from a greedy tree and kicks out of its local optimum (`climb`). A restart's
//! random stream depends on the seed and its number alone and the best restart of lowest number wins, so that one
//! seed gives one tree whatever the number of threads.

mod axis;
mod blocks;
mod climb;
mod ground;
mod kick;
mod line;
mod logistic;
mod melt;
mod orders;
mod plane;
mod restart;
mod sensors;
mod start;
mod state;
mod tally;
mod view;

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use crate::exact::effort::Control;
use crate::exact::samples::Samples;
use crate::problem::Problem;
use crate::tree::Tree;

use climb::Climber;
use ground::Ground;
use restart::Start;
use state::State;

/// How hard to search.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Number of restarts.
    pub n_restarts: usize,
    /// Kicks in a row without a better tree that end a restart.
    pub n_kicks: usize,
    /// Of the random choices.
    pub seed: u64,
    /// Threads.
    pub n_threads: usize,
}

/// The bound that needs no search: no cost is negative.
const TRIVIAL_BOUND: i64 = 0;

/// Kicks of the axis-aligned tree that a hyperplane tree must not be worse than.
const AXIS_KICKS: usize = 10;

/// How often the calling thread looks whether to go on.
const LOOK: Duration = Duration::from_millis(20);

/// Search for a tree of low objective, from `start` too when one is given.
///
/// The bound returned is the trivial one.
pub fn search(
    problem: &Problem,
    options: Options,
    start: Option<&Tree>,
    limits: Limits,
    keep_going: KeepGoing,
) -> Outcome {
    let ground = Ground::new(problem);
    let samples = Samples::new(problem);
    let shared = Shared::new(limits);
    let mut found = std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        for _ in 0..options.n_threads.clamp(1, options.n_restarts.max(1)) {
            let (sender, ground, samples, shared) = (sender.clone(), &ground, &samples, &shared);
            scope.spawn(move || {
                while let Some(restart) = shared.next(options.n_restarts) {
                    // The receiver outlives every sender: it is dropped at the end of the scope.
                    let _ = sender.send(run(ground, samples, shared, options, start, restart));
                }
            });
        }
        drop(sender);
        let mut found = Vec::new();
        loop {
            match receiver.recv_timeout(LOOK) {
                Ok(result) => found.push(result),
                Err(RecvTimeoutError::Disconnected) => break found,
                Err(RecvTimeoutError::Timeout) => {}
            }
            shared.look(&mut *keep_going);
        }
    });
    found.sort_by_key(|result| (result.objective, result.restart));
    let best = found.into_iter().next();
    let (state, objective) = match best {
        Some(result) => (result.state, result.objective),
        None => {
            let state = State::leaf(problem);
            let objective = state.objective(&ground.prices);
            (state, objective)
        }
    };
    let stop = if objective == TRIVIAL_BOUND {
        Stop::Optimal
    } else {
        shared.stop(limits)
    };
    let n_nodes = shared.n_visits.load(Ordering::Relaxed);
    Outcome {
        tree: state.to_tree(&ground.prices),
        objective,
        bound: TRIVIAL_BOUND,
        stop,
        n_nodes,
    }
}

struct Found {
    objective: i64,
    restart: usize,
    state: State,
}

fn run(
    ground: &Ground,
    samples: &Samples,
    shared: &Shared,
    options: Options,
    known: Option<&Tree>,
    restart: usize,
) -> Found {
    let go_on = || shared.goes_on(restart);
    let seed = options
        .seed
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .wrapping_add(restart as u64);
    let mut climber = Climber::new(ground, samples, &shared.control, seed, &go_on);
    let start = match (restart, known) {
        (0, Some(tree)) => Start::Known(tree),
        (0, None) | (1, Some(_)) => Start::Greedy,
        _ => Start::Random,
    };
    let state = if !ground.has_planes() {
        restart::axis(&mut climber, ground, start, options.n_kicks)
    } else {
        let is_first = !matches!(start, Start::Random);
        let floor = is_first.then(|| restart::axis(&mut climber, ground, start, AXIS_KICKS));
        restart::planes(&mut climber, ground, start, floor, options.n_kicks)
    };
    let objective = state.objective(&ground.prices);
    let is_best = !ground.has_planes() && climber.blocks.has_proven(&state, objective);
    shared.record(restart, objective, climber.n_visits, is_best);
    Found {
        objective,
        restart,
        state,
    }
}

/// What the threads tell each other.
struct Shared {
    started: Instant,
    limits: Limits,
    next: AtomicUsize,
    /// The first restart that cannot be beaten: later ones need not go on, earlier ones must.
    first_optimal: AtomicUsize,
    objective: AtomicI64,
    n_visits: AtomicU64,
    is_interrupted: AtomicBool,
    is_out_of_time: AtomicBool,
    /// Tells the exact blocks to give up.
    control: Control,
}

impl Shared {
    fn new(limits: Limits) -> Self {
        Self {
            started: Instant::now(),
            limits,
            next: AtomicUsize::new(0),
            first_optimal: AtomicUsize::new(usize::MAX),
            objective: AtomicI64::new(i64::MAX),
            n_visits: AtomicU64::new(0),
            is_interrupted: AtomicBool::new(false),
            is_out_of_time: AtomicBool::new(false),
            control: Control::new(),
        }
    }

    fn next(&self, n_restarts: usize) -> Option<usize> {
        let restart = self.next.fetch_add(1, Ordering::Relaxed);
        (restart < n_restarts && self.goes_on(restart)).then_some(restart)
    }

    fn goes_on(&self, restart: usize) -> bool {
        if self.started.elapsed().as_secs_f64() >= self.limits.seconds {
            self.is_out_of_time.store(true, Ordering::Relaxed);
        }
        !self.is_interrupted.load(Ordering::Relaxed)
            && !self.is_out_of_time.load(Ordering::Relaxed)
            && restart < self.first_optimal.load(Ordering::Relaxed)
            && (self.n_visits.load(Ordering::Relaxed) as f64) < self.limits.nodes
    }

    fn record(&self, restart: usize, objective: i64, n_visits: u64, is_best: bool) {
        self.objective.fetch_min(objective, Ordering::Relaxed);
        self.n_visits.fetch_add(n_visits, Ordering::Relaxed);
        if is_best || objective == TRIVIAL_BOUND {
            self.first_optimal.fetch_min(restart, Ordering::Relaxed);
        }
    }

    fn look(&self, keep_going: KeepGoing) {
        let progress = Progress {
            seconds: self.started.elapsed().as_secs_f64(),
            objective: self.objective.load(Ordering::Relaxed),
            bound: TRIVIAL_BOUND,
            n_nodes: self.n_visits.load(Ordering::Relaxed),
        };
        if !keep_going(progress) {
            self.is_interrupted.store(true, Ordering::Relaxed);
        }
        // Exact blocks look at the control alone.
        if !self.goes_on(0) {
            self.control.stop();
        }
    }

    fn stop(&self, limits: Limits) -> Stop {
        if self.is_interrupted.load(Ordering::Relaxed) {
            Stop::Interrupted
        } else if self.is_out_of_time.load(Ordering::Relaxed) {
            Stop::Time
        } else if self.n_visits.load(Ordering::Relaxed) as f64 >= limits.nodes {
            Stop::Nodes
        } else {
            Stop::Finished
        }
    }
}

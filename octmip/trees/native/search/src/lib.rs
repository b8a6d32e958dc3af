//! Local search: good trees of any size, without a proof.
//!
//! Independent restarts (`restart`), each a descent from a tree of its own and perturbations of its local optimum, in
//! groups: all of a group begin, the better ones go on; the best of all groups goes on longest. A restart's random
//! stream depends on the seed and its number alone, rounds end together, and the best restart of lowest number wins, so
//! that one seed gives one tree whatever the number of threads, or of the processes that take turns (`turns`).
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod axis;
mod gains;
mod greedy;
mod local_search;
mod logistic;
mod options;
mod perturbation;
mod planes;
mod prepared;
mod rebuild;
mod restart;
mod soft_tree;
mod tree;
mod turn_solver;
mod turns;
mod watch;

pub use options::Options;
pub use turn_solver::TurnSolver;
pub use turns::{FinishedTurn, OtherProcesses, Turn, TurnTask};

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

use octmip_check::problem::Problem;
use octmip_exact::Samples;
use octmip_frame::control::{KeepGoing, Limits, Outcome, Stop};
use octmip_frame::tree::Tree;

use crate::prepared::{Made, Prepared};
use crate::restart::{Restart, Round};
use crate::watch::{TRIVIAL_BOUND, Watch};

/// Number of restarts that begin together; one in so many of them goes on.
const GROUP: usize = 9;
const GOES_ON_ONE_IN: usize = 3;

/// Time between two polls of the calling thread, which ask whether to go on.
const POLL: Duration = Duration::from_millis(10);

/// Search for a tree of low objective, from `start` too when one is given.
///
/// The bound returned is the trivial one. `others` take the turns where there are any, else this process does.
pub fn search(
    problem: &Problem,
    options: Options,
    start: Option<&Tree>,
    limits: Limits,
    others: Option<&OtherProcesses<'_>>,
    keep_going: KeepGoing,
) -> Outcome {
    let prepared = Prepared { problem, made: &Made::new(problem) };
    let samples = Samples::new(problem);
    let watch = Watch::new(limits);
    let new = |k| Restart::new(&prepared, &samples, &watch, options.seed, k);
    let rounds = Round::all(options, start, problem);
    let n = options.n_restarts.max(1);
    let mut best: Option<Restart> = None;
    let mut turn = |restarts, number: usize| {
        let takers = Takers { number, round: &rounds[number], n_threads: options.n_threads, others };
        run(restarts, takers, &watch, &mut *keep_going)
    };
    // Groups know nothing of one another, and the first whose best cannot be beaten has the best of lowest number:
    // so many processes as there are do several at once, and end with the same tree.
    let at_once = GROUP * others.map_or(1, |others| others.n_at_once.div_ceil(GROUP).max(1));
    for first in (0..n).step_by(at_once) {
        let last = n.min(first + at_once);
        let begun = turn((first..last).map(new).collect(), 0);
        let (going_on, resting) = best_of_each_group(begun, first);
        let gone_on = turn(going_on, 1);
        best = best.into_iter().chain(gone_on).chain(resting).min_by_key(Restart::rank);
        if watch.has_best() || !watch.goes_on(0) {
            break;
        }
    }
    let best = turn(best.into_iter().collect(), 2).swap_remove(0);
    Outcome {
        tree: best.state.to_tree(&prepared.prices),
        objective: best.objective,
        bound: TRIVIAL_BOUND,
        stop: match best.objective {
            TRIVIAL_BOUND => Stop::Optimal,
            _ => watch.stop(),
        },
        n_nodes: watch.n_visits(),
    }
}

/// The restarts of each group that go on, group after group, and those that rest.
///
/// All come from best to worst, and the first of them has the number `first`.
fn best_of_each_group(begun: Vec<Restart>, first: usize) -> (Vec<Restart>, Vec<Restart>) {
    let mut groups: Vec<Vec<Restart>> = Vec::new();
    for restart in begun {
        let group = (restart.number - first) / GROUP;
        groups.resize_with(groups.len().max(group + 1), Vec::new);
        groups[group].push(restart);
    }
    let (mut going_on, mut resting) = (Vec::new(), Vec::new());
    for mut group in groups {
        resting.extend(group.split_off(group.len().div_ceil(GOES_ON_ONE_IN)));
        going_on.extend(group);
    }
    (going_on, resting)
}

/// Who takes the turns of a round: threads of this process, or other processes.
#[derive(Clone, Copy)]
struct Takers<'t> {
    number: usize,
    round: &'t Round<'t>,
    n_threads: usize,
    others: Option<&'t OtherProcesses<'t>>,
}

impl Takers<'_> {
    /// Turns that are taken at once.
    fn n_at_once(&self) -> usize {
        self.others.map_or(self.n_threads, |others| others.n_at_once)
    }

    /// Have a turn taken.
    fn take(&self, restart: &mut Restart) {
        match self.others {
            Some(others) => restart.run_in_other_process(self.number, others.ask),
            None => {
                restart.run(self.round);
            }
        }
    }
}

/// Give every restart its turn in a round, in order, as many at once as there are takers; returns them from best to
/// worst.
fn run<'a>(restarts: Vec<Restart<'a>>, takers: Takers, watch: &Watch, keep_going: KeepGoing) -> Vec<Restart<'a>> {
    let n = restarts.len();
    let mut done = Vec::with_capacity(n);
    let wait = |(place, mut restart): (usize, Restart<'a>)| {
        restart.place = place;
        Mutex::new(Some(restart))
    };
    let waiting: Vec<Mutex<Option<Restart>>> = restarts.into_iter().enumerate().map(wait).collect();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        for _ in 0..takers.n_at_once().clamp(1, n.max(1)) {
            let (sender, waiting, next) = (sender.clone(), &waiting, &next);
            scope.spawn(move || {
                while let Some(slot) = waiting.get(next.fetch_add(1, Ordering::Relaxed)) {
                    // Nobody else asks for this place, and the receiver outlives every sender.
                    let Some(mut restart) = slot.lock().ok().and_then(|mut slot| slot.take()) else {
                        continue;
                    };
                    takers.take(&mut restart);
                    let _ = sender.send(restart);
                }
            });
        }
        drop(sender);
        watch.supervision.wait(&receiver, POLL, |restart| done.push(restart), || watch.look(&mut *keep_going));
        done.iter_mut().for_each(Restart::take_back_if_beaten);
        done.sort_by_key(Restart::rank);
        done
    })
}

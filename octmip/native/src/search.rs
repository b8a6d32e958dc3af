//! Local search: good trees of any size, without a proof.
//!
//! Independent restarts (`restart`), each a descent from a tree of its own and perturbations of its local optimum, in
//! groups: all of a group begin, the better ones go on; the best of all groups goes on longest. A restart's random
//! stream depends on the seed and its number alone, rounds end together, and the best restart of lowest number wins, so
//! that one seed gives one tree whatever the number of threads.

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
mod watch;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

use crate::control::{KeepGoing, Limits, Outcome, Stop};
use crate::exact::samples::Samples;
use crate::problem::Problem;
use crate::tree::Tree;

use crate::search::prepared::Prepared;
use crate::search::restart::{Restart, Round};
use crate::search::watch::{TRIVIAL_BOUND, Watch};

pub use options::Options;

/// Number of restarts that begin together; one in so many of them goes on.
const GROUP: usize = 9;
const GOES_ON_ONE_IN: usize = 3;

/// Time between two polls of the calling thread, which ask whether to go on.
const POLL: Duration = Duration::from_millis(10);

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
    let prepared = Prepared::new(problem);
    let samples = Samples::new(problem);
    let watch = Watch::new(limits);
    let new = |k| Restart::new(&prepared, &samples, &watch, options.seed, k);
    let rounds = Round::all(options, start, problem);
    let mut turn = |restarts, round| run(restarts, round, options.n_threads, &watch, &mut *keep_going);
    let mut restarts: Vec<Restart> = Vec::new();
    for first in (0..options.n_restarts.max(1)).step_by(GROUP) {
        let group = (first..options.n_restarts.max(1).min(first + GROUP)).map(new);
        let mut begun = turn(group.collect(), &rounds[0]);
        let others = begun.split_off(begun.len().div_ceil(GOES_ON_ONE_IN));
        restarts.extend(turn(begun, &rounds[1]));
        restarts.extend(others);
        restarts.sort_by_key(Restart::rank);
        if watch.has_best() || !watch.goes_on(0) {
            break;
        }
    }
    let last = restarts.drain(..1).collect();
    restarts = turn(last, &rounds[2]);
    let best = restarts.swap_remove(0);
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

/// Give every restart its turn in a round, in order, on so many threads; returns them from best to worst.
fn run<'a>(
    mut restarts: Vec<Restart<'a>>,
    round: &Round,
    n_threads: usize,
    watch: &Watch,
    keep_going: KeepGoing,
) -> Vec<Restart<'a>> {
    let n = restarts.len();
    for (place, restart) in restarts.iter_mut().enumerate() {
        restart.place = place;
    }
    let waiting: Vec<Mutex<Option<Restart>>> = restarts.into_iter().map(|restart| Mutex::new(Some(restart))).collect();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        for _ in 0..n_threads.clamp(1, n) {
            let (sender, waiting, next) = (sender.clone(), &waiting, &next);
            scope.spawn(move || {
                while let Some(slot) = waiting.get(next.fetch_add(1, Ordering::Relaxed)) {
                    // Nobody else asks for this place, and the receiver outlives every sender.
                    let Some(mut restart) = slot.lock().ok().and_then(|mut slot| slot.take()) else {
                        continue;
                    };
                    restart.run(round);
                    let _ = sender.send(restart);
                }
            });
        }
        drop(sender);
        let mut done = Vec::with_capacity(n);
        watch.supervision.wait(&receiver, POLL, |restart| done.push(restart), || watch.look(&mut *keep_going));
        done.sort_by_key(Restart::rank);
        done
    })
}

//! Supervision of a search: clock, limits, the caller's wish to stop, and the flag that workers read.
//!
//! The calling thread waits for the workers and polls meanwhile; the workers read one atomic flag. What a search counts
//! as nodes and bytes, and where it compares bound and objective, it passes in.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use crate::control::{KeepGoing, Limits, Progress, Stop};

/// Time between two polls.
pub const POLL: Duration = Duration::from_millis(20);

/// A running search: when it began, its limits, and why it is to stop.
#[derive(Debug)]
pub struct Supervision {
    started: Instant,
    limits: Limits,
    flag: Arc<AtomicBool>,
    reason: OnceLock<Stop>,
}

impl Supervision {
    /// A search that begins now; without any time it is stopped before a worker begins, however fast that one is.
    pub fn new(limits: Limits) -> Self {
        let begun = Self { started: Instant::now(), limits, flag: Arc::default(), reason: OnceLock::new() };
        if limits.seconds <= 0.0 {
            begun.stop(Stop::Time);
        }
        begun
    }

    /// When to stop early.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// The flag that workers read: once it is set, what they return proves nothing.
    pub fn flag(&self) -> &Arc<AtomicBool> {
        &self.flag
    }

    /// Whether the flag is set.
    pub fn is_stopped(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// Why the search is to stop, if it is; the first reason stays.
    pub fn reason(&self) -> Option<Stop> {
        self.reason.get().copied()
    }

    /// Stop the workers for a reason.
    pub fn stop(&self, reason: Stop) {
        self.reason.get_or_init(|| reason);
        self.halt();
    }

    /// Set the flag without a reason: the work that is left is of no use.
    pub fn halt(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Stop when time is out; whether it is.
    pub fn check_time(&self) -> bool {
        let is_out = self.seconds() >= self.limits.seconds;
        if is_out {
            self.stop(Stop::Time);
        }
        is_out
    }

    /// Report progress to the caller, who may wish to stop, and look at the clock; the seconds of `state` are set here.
    pub fn poll(&self, keep_going: KeepGoing<'_>, state: Progress) {
        if !keep_going(Progress { seconds: self.seconds(), ..state }) {
            self.stop(Stop::Interrupted);
        }
        self.check_time();
    }

    /// The gap that was asked for, if `objective` is so near to the bound (`difference` above it).
    pub fn gap_reached(&self, difference: f64, objective: f64) -> Option<Stop> {
        let gap = difference / objective.abs().max(1e-300);
        (self.limits.gap > 0.0 && gap <= self.limits.gap).then_some(Stop::Gap)
    }

    /// The limit of nodes or memory that is reached, if one is.
    pub fn spent(&self, n_nodes: u64, bytes: f64) -> Option<Stop> {
        if n_nodes as f64 >= self.limits.nodes {
            Some(Stop::Nodes)
        } else {
            (bytes > self.limits.memory).then_some(Stop::Memory)
        }
    }

    /// Wait until every sender of `workers` is gone: take what they send, and poll after each message or `every`.
    pub fn wait<T>(&self, workers: &Receiver<T>, every: Duration, mut take: impl FnMut(T), mut poll: impl FnMut()) {
        loop {
            let left = self.limits.seconds - self.seconds();
            let until = if self.is_stopped() { every.as_secs_f64() } else { left.clamp(0.0, every.as_secs_f64()) };
            match workers.recv_timeout(Duration::from_secs_f64(until)) {
                Ok(message) => take(message),
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            poll();
        }
    }

    /// Do the same work in several threads and poll until all have ended.
    pub fn run_all(&self, n_threads: usize, work: impl Fn() + Sync, poll: impl FnMut()) {
        std::thread::scope(|scope| {
            let (sender, workers) = channel::<()>();
            for _ in 0..n_threads {
                let (sender, work) = (sender.clone(), &work);
                scope.spawn(move || {
                    let _sender = sender;
                    work();
                });
            }
            drop(sender);
            self.wait(&workers, POLL, |()| (), poll);
        });
    }

    /// Do one piece of work in another thread and poll until it has ended.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send, poll: impl FnMut()) -> T {
        std::thread::scope(|scope| {
            let (sender, workers) = channel::<()>();
            let worker = scope.spawn(move || {
                let _sender = sender;
                work()
            });
            self.wait(&workers, POLL, |()| (), poll);
            worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATE: Progress = Progress { seconds: 0.0, objective: 10, bound: 9, n_nodes: 7 };

    #[test]
    fn the_first_reason_stays_and_sets_the_flag() {
        let supervision = Supervision::new(Limits { seconds: 1e-9, ..Limits::default() });
        assert!(!supervision.is_stopped());
        supervision.poll(&mut |_| false, STATE);
        assert!(supervision.check_time());
        assert!(supervision.is_stopped());
        assert_eq!(supervision.reason(), Some(Stop::Interrupted));
    }

    #[test]
    fn without_time_it_is_stopped_before_it_begins() {
        let supervision = Supervision::new(Limits { seconds: 0.0, ..Limits::default() });
        assert!(supervision.is_stopped());
        assert_eq!(supervision.reason(), Some(Stop::Time));
    }

    #[test]
    fn limits_are_reached_at_their_values_and_memory_above_it() {
        let supervision = Supervision::new(Limits { gap: 0.1, nodes: 7.0, memory: 100.0, ..Limits::default() });
        assert_eq!([0.9, 1.0, 1.1].map(|above| supervision.gap_reached(above, 10.0).is_some()), [true, true, false]);
        assert_eq!([6, 7].map(|n| supervision.spent(n, 0.0)), [None, Some(Stop::Nodes)]);
        assert_eq!([100.0, 101.0].map(|bytes| supervision.spent(0, bytes)), [None, Some(Stop::Memory)]);
        assert_eq!(Supervision::new(Limits::default()).gap_reached(0.0, 0.0), None);
    }

    #[test]
    fn work_is_polled_until_it_ends_and_its_result_is_returned() {
        let supervision = Supervision::new(Limits::default());
        let mut n_polls = 0;
        let flag = supervision.flag();
        let work = || {
            while !flag.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
            42
        };
        let result = supervision.run(work, || {
            n_polls += 1;
            supervision.poll(&mut |_| false, STATE);
        });
        assert_eq!((result, n_polls > 0), (42, true));
        supervision.run_all(3, || assert!(flag.load(Ordering::Relaxed)), || ());
    }
}

//! Limits and Ctrl-C: the calling thread watches the clock and the caller while workers search.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use crate::control::{KeepGoing, Limits, Progress, Stop};

/// How often the calling thread looks up.
pub const LOOK: Duration = Duration::from_millis(20);

/// A stop flag that workers read, and why it was set.
#[derive(Debug)]
pub struct Watch {
    begin: Instant,
    /// When to stop.
    pub limits: Limits,
    stop: AtomicBool,
    out_of_time: AtomicBool,
}

impl Watch {
    /// Start the clock.
    pub fn new(limits: Limits) -> Self {
        Self { begin: Instant::now(), limits, stop: AtomicBool::new(false), out_of_time: AtomicBool::new(false) }
    }

    /// The flag that workers read.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// Whether the work was cut short.
    pub fn was_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Why the work was cut short.
    pub fn reason(&self) -> Option<Stop> {
        self.was_stopped().then(
            || {
                if self.out_of_time.load(Ordering::Relaxed) { Stop::Time } else { Stop::Interrupted }
            },
        )
    }

    /// Look at the clock and ask the caller.
    pub fn look(&self, keep_going: &mut dyn FnMut(Progress) -> bool, state: Progress) {
        let seconds = self.begin.elapsed().as_secs_f64();
        if seconds >= self.limits.seconds {
            self.out_of_time.store(true, Ordering::Relaxed);
            self.stop.store(true, Ordering::Relaxed);
        } else if !keep_going(Progress { seconds, ..state }) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Do one piece of work in another thread and watch over it.
    pub fn over<T: Send>(&self, keep_going: KeepGoing, objective: i64, work: impl FnOnce() -> T + Send) -> T {
        let state = Progress { seconds: 0.0, objective, bound: 0, n_nodes: 0 };
        std::thread::scope(|scope| {
            let (sender, receiver) = channel::<()>();
            let worker = scope.spawn(move || {
                let result = work();
                drop(sender);
                result
            });
            while let Err(std::sync::mpsc::RecvTimeoutError::Timeout) = receiver.recv_timeout(LOOK) {
                self.look(&mut *keep_going, state);
            }
            worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }
}

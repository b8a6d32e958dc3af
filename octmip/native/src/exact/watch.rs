//! Looking after a search: its limits, the caller's wish to stop, and handing out what is known.

use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use crate::control::{KeepGoing, Limits, Progress, Stop};
use crate::exact::effort::Control;
use crate::exact::known::{Known, Saver};

/// Who is given what is known, and when that was last so.
pub struct Due<'s, 'a> {
    /// Takes it.
    pub saver: Option<&'s mut Saver<'a>>,
    /// When it did last.
    pub saved: &'s mut Instant,
}

impl Due<'_, '_> {
    /// Hand out what is known, now or if it is time; whether to go on.
    pub fn save(&mut self, now: bool, known: &dyn Fn() -> Known) -> bool {
        let Some(saver) = &mut self.saver else { return true };
        if !now && self.saved.elapsed().as_secs_f64() < saver.every {
            return true;
        }
        let goes_on = (saver.save)(&known());
        *self.saved = Instant::now();
        goes_on
    }
}

/// Wait for the workers, looking at the limits and asking the caller meanwhile; why they were stopped, if they were.
/// `progress` says objective, bound and bytes taken.
pub fn watch(
    started: Instant,
    limits: &Limits,
    control: &Control,
    workers: &std::sync::mpsc::Receiver<()>,
    keep_going: KeepGoing<'_>,
    progress: impl Fn() -> (i64, i64, f64),
    save: &mut dyn FnMut() -> bool,
) -> Option<Stop> {
    let mut stop = None;
    loop {
        let left = limits.seconds - started.elapsed().as_secs_f64();
        let wait = Duration::from_secs_f64(left.clamp(0.0, 0.02));
        if workers.recv_timeout(wait) == Err(RecvTimeoutError::Disconnected) {
            return stop;
        }
        let (objective, bound, bytes) = progress();
        let n_nodes = control.n_evaluated();
        let seconds = started.elapsed().as_secs_f64();
        let has_gap = limits.gap > 0.0 && (objective - bound) as f64 <= limits.gap * objective as f64;
        let reason = if !keep_going(Progress { seconds, objective, bound, n_nodes }) || !save() {
            Some(Stop::Interrupted)
        } else if seconds >= limits.seconds {
            Some(Stop::Time)
        } else if n_nodes as f64 >= limits.nodes {
            Some(Stop::Nodes)
        } else if bytes > limits.memory {
            Some(Stop::Memory)
        } else if has_gap {
            Some(Stop::Gap)
        } else {
            None
        };
        if let Some(reason) = reason {
            stop = stop.or(Some(reason));
            control.stop();
        }
    }
}

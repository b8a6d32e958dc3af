//! Independent parts of a proof, checked on several threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::refusal::{Checked, Refusal};

/// Stack of each thread, for nodes within nodes and bands within bands.
const STACK_BYTES: usize = 1 << 26;

/// Check `n_parts` parts by their number; of those that are refused, the first one is returned.
///
/// Parts are taken in order, and none is taken after a refusal: all parts before the first bad one are checked, so the
/// answer is the same for any number of threads. Where no thread can be had, the log is refused in `last_line`.
pub(crate) fn check_parts(
    n_parts: usize,
    n_threads: usize,
    last_line: usize,
    check: impl Fn(usize) -> Checked<()> + Sync,
) -> Checked<()> {
    let (next, refusals) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let refuse = |part: usize, refusal: Refusal| {
        refusals.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push((part, refusal));
        next.store(n_parts, Ordering::Relaxed);
    };
    let work = || {
        loop {
            let part = next.fetch_add(1, Ordering::Relaxed);
            if part >= n_parts {
                return;
            }
            check(part).unwrap_or_else(|refusal| refuse(part, refusal));
        }
    };
    std::thread::scope(|scope| {
        for number in 0..n_threads.clamp(1, n_parts.max(1)) {
            let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work);
            match thread {
                Err(error) if number == 0 => {
                    refuse(n_parts, Refusal { line: last_line, reason: format!("no thread to check on ({error})") });
                }
                _ => (), // fewer threads check all parts as well
            }
        }
    });
    let found = refusals.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    found.into_iter().min_by_key(|(part, _)| *part).map_or(Ok(()), |(_, refusal)| Err(refusal))
}

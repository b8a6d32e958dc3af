//! What the threads of a search share: the word to stop, and how much was done.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// See the module.
#[derive(Debug, Default)]
pub struct Control {
    stop: AtomicBool,
    n_evaluated: AtomicU64,
}

impl Control {
    /// Nobody has said stop.
    pub fn new() -> Self {
        Self::default()
    }

    /// Say stop: every search that looks here returns soon, without a proof.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether someone said stop.
    #[inline]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Count evaluated cuts.
    pub fn add(&self, n: u64) {
        self.n_evaluated.fetch_add(n, Ordering::Relaxed);
    }

    /// Evaluated cuts so far.
    pub fn n_evaluated(&self) -> u64 {
        self.n_evaluated.load(Ordering::Relaxed)
    }
}

//! What the threads of a search share: the word to stop, and how much was done.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// See the module.
#[derive(Debug)]
pub struct Control {
    stop: Arc<AtomicBool>,
    n_evaluated: AtomicU64,
    /// Evaluated cuts after which the search stops by itself.
    most: u64,
    is_spent: AtomicBool,
}

impl Default for Control {
    fn default() -> Self {
        Self::new()
    }
}

impl Control {
    /// Nobody has said stop.
    pub fn new() -> Self {
        Self::reading(&Arc::default())
    }

    /// One that is stopped by a flag, as a search's supervision has it.
    pub fn reading(flag: &Arc<AtomicBool>) -> Self {
        Self::sharing(flag.clone(), u64::MAX)
    }

    /// One that hears the same word to stop and, besides, stops after so many evaluated cuts.
    pub fn limited(&self, most: u64) -> Self {
        Self::sharing(self.stop.clone(), most)
    }

    fn sharing(stop: Arc<AtomicBool>, most: u64) -> Self {
        Self { stop, n_evaluated: AtomicU64::new(0), most, is_spent: AtomicBool::new(false) }
    }

    /// Say stop: every search that looks here returns soon, without a proof.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether someone said stop, or the evaluated cuts are spent.
    #[inline]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.is_spent.load(Ordering::Relaxed)
    }

    /// Count evaluated cuts.
    pub fn add(&self, n: u64) {
        if self.n_evaluated.fetch_add(n, Ordering::Relaxed) + n >= self.most {
            self.is_spent.store(true, Ordering::Relaxed);
        }
    }

    /// Evaluated cuts so far.
    pub fn n_evaluated(&self) -> u64 {
        self.n_evaluated.load(Ordering::Relaxed)
    }
}

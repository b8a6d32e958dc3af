//! Stop flag and effort of a search, shared by its threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Stop flag, evaluated cuts and a limit of them.
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
    /// A flag that nobody sets, no limit.
    pub fn new() -> Self {
        Self::reading(&Arc::default())
    }

    /// The same with the flag of a search's supervision.
    pub fn reading(flag: &Arc<AtomicBool>) -> Self {
        Self::sharing(flag.clone(), u64::MAX)
    }

    /// The same flag, with a count of its own that stops after so many evaluated cuts.
    pub fn limited(&self, most: u64) -> Self {
        Self::sharing(self.stop.clone(), most)
    }

    fn sharing(stop: Arc<AtomicBool>, most: u64) -> Self {
        Self { stop, n_evaluated: AtomicU64::new(0), most, is_spent: AtomicBool::new(false) }
    }

    /// Whether the flag is set or the evaluated cuts are spent.
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

//! The options of a local search.

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

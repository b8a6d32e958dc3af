//! The options of a local search.

/// The effort of a search.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Number of restarts.
    pub n_restarts: usize,
    /// Perturbations in a row without a better tree that end a restart.
    pub n_perturbations: usize,
    /// Seed of the random choices.
    pub seed: u64,
    /// Number of threads.
    pub n_threads: usize,
}

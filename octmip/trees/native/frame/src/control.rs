//! Limits, progress and what a solver returns.

use crate::tree::Tree;

/// Why a solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The bound meets the objective.
    Optimal,
    /// A heuristic did all it had set out to do.
    Finished,
    /// The gap asked for is reached.
    Gap,
    /// Out of time.
    Time,
    /// Out of nodes.
    Nodes,
    /// Out of memory.
    Memory,
    /// The caller said stop.
    Interrupted,
}

/// When to stop early.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Wall time in seconds.
    pub seconds: f64,
    /// Relative gap.
    pub gap: f64,
    /// Search nodes.
    pub nodes: f64,
    /// Bytes of the solver's own tables.
    pub memory: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { seconds: f64::INFINITY, gap: 0.0, nodes: f64::INFINITY, memory: f64::INFINITY }
    }
}

/// A solver's state while it runs.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Since the start.
    pub seconds: f64,
    /// Best objective; `i64::MAX` without a tree.
    pub objective: i64,
    /// Proven bound.
    pub bound: i64,
    /// Nodes searched.
    pub n_nodes: u64,
}

/// Called every few hundredths of a second from the calling thread; `false` means stop now.
pub type KeepGoing<'a> = &'a mut dyn FnMut(Progress) -> bool;

/// Result of a solver.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The best tree.
    pub tree: Tree,
    /// Its objective.
    pub objective: i64,
    /// No tree of the problem is below it.
    pub bound: i64,
    /// Why it stopped.
    pub stop: Stop,
    /// Nodes searched.
    pub n_nodes: u64,
}

//! Turns of restarts, taken by other processes: what goes out and what comes back.
//!
//! A turn depends on the restart's number and what it had after the turn before (`Turn`) alone. So it may be taken
//! anywhere, and again where it is lost with its process, and the tree is that of one machine.

use octmip_frame::control::Limits;
use octmip_frame::tree::Tree;

/// A restart after a turn: all that its next turn begins from.
#[derive(Debug, Clone, PartialEq)]
pub struct Turn {
    /// The restart's number.
    pub number: usize,
    /// State of its random stream.
    pub stream: u64,
    /// Perturbations after which deep blocks have helped, and after which they were tried.
    pub deep_tries: [u32; 2],
    /// Whether nothing beats its tree.
    pub is_best: bool,
    /// Its tree.
    pub tree: Tree,
}

/// A turn that is asked for.
#[derive(Debug, Clone, Copy)]
pub struct TurnTask<'a> {
    /// Number of the round.
    pub round: usize,
    /// Number of the restart.
    pub number: usize,
    /// The turn before; None where the restart has not begun.
    pub before: Option<&'a Turn>,
    /// What is left of the seconds and nodes.
    pub limits: Limits,
}

/// A turn that was taken.
#[derive(Debug, Clone)]
pub struct FinishedTurn {
    /// The turn.
    pub turn: Turn,
    /// Nodes visited in it.
    pub n_visits: u64,
    /// Whether no limit has ended it.
    pub is_whole: bool,
}

/// Asks for a turn and waits for it as long as `waits` says; None when it was given up.
pub(crate) type Ask<'a> = dyn Fn(TurnTask, &dyn Fn() -> bool) -> Option<FinishedTurn> + Sync + 'a;

/// Other processes that take turns.
pub struct OtherProcesses<'a> {
    /// Asks one of them, and waits.
    pub ask: &'a Ask<'a>,
    /// Turns that are asked for at once.
    pub n_at_once: usize,
}

//! Turns of restarts, taken by other processes: what goes out and what comes back.
//!
//! A turn depends on the restart's number and what it had after the turn before (`Turn`) alone. So it may be taken
//! anywhere, and again where it is lost with its process, and the tree is that of one machine.

use crate::control::Limits;
use crate::tree::Tree;

/// A restart after a turn: all that its next turn begins from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Turn {
    /// The restart's number.
    pub(crate) number: usize,
    /// State of its random stream.
    pub(crate) stream: u64,
    /// Perturbations after which deep blocks have helped, and after which they were tried.
    pub(crate) deep_tries: [u32; 2],
    /// Whether nothing beats its tree.
    pub(crate) is_best: bool,
    /// Its tree.
    pub(crate) tree: Tree,
}

/// A turn that is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnTask<'a> {
    /// Number of the round.
    pub(crate) round: usize,
    /// Number of the restart.
    pub(crate) number: usize,
    /// The turn before; None where the restart has not begun.
    pub(crate) before: Option<&'a Turn>,
    /// What is left of the seconds and nodes.
    pub(crate) limits: Limits,
}

/// A turn that was taken.
#[derive(Debug, Clone)]
pub(crate) struct FinishedTurn {
    /// The turn.
    pub(crate) turn: Turn,
    /// Nodes visited in it.
    pub(crate) n_visits: u64,
    /// Whether no limit has ended it.
    pub(crate) is_whole: bool,
}

/// Asks for a turn and waits for it as long as `waits` says; None when it was given up.
pub(crate) type Ask<'a> = dyn Fn(TurnTask, &dyn Fn() -> bool) -> Option<FinishedTurn> + Sync + 'a;

/// Other processes that take turns.
pub(crate) struct OtherProcesses<'a> {
    /// Asks one of them, and waits.
    pub(crate) ask: &'a Ask<'a>,
    /// Turns that are asked for at once.
    pub(crate) n_at_once: usize,
}

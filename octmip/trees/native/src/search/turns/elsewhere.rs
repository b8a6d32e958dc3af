//! Turns of restarts taken by other processes: what goes out and what comes back.
//!
//! A turn depends on the restart's number and what it had after the turn before (`Turn`) alone, as in a search that
//! goes on from a checkpoint. So it may be taken anywhere, and again where it is lost with its process, and the tree is
//! that of one machine.

use crate::control::Limits;
use crate::search::turns::known::Turn;

/// A turn that is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted<'a> {
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
pub(crate) struct Taken {
    /// The turn.
    pub(crate) turn: Turn,
    /// Nodes visited in it.
    pub(crate) n_visits: u64,
    /// Whether no limit has ended it.
    pub(crate) is_whole: bool,
}

/// Asks for a turn and waits for it as long as `waits` says; None when it was given up.
pub(crate) type Ask<'a> = dyn Fn(Wanted, &dyn Fn() -> bool) -> Option<Taken> + Sync + 'a;

/// Takers of turns in other processes.
pub(crate) struct Elsewhere<'a> {
    /// Asks one of them, and waits.
    pub(crate) ask: &'a Ask<'a>,
    /// Turns that are asked for at once.
    pub(crate) n_at_once: usize,
}

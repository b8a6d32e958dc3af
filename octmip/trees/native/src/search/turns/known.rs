//! What a search has finished, small enough to be kept: turns of restarts. A later search takes it up and ends with the
//! tree that this one would have ended with.
//!
//! A restart begins each turn from its tree, random stream and counts of deep blocks alone (`Restart::take_up`),
//! whether it had the turn before in this process or in an earlier one. Turns that were under way are done again.

use std::time::Instant;

use crate::tree::Tree;

/// A restart after a turn.
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

/// The finished turns of a search.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Known {
    /// Number of the first restart of the group in work.
    pub(crate) first: usize,
    /// Finished turns of the group's rounds, of beginning and of going on, and of the last round of all.
    pub(crate) rounds: [Vec<Turn>; 3],
    /// The best restart of the groups before.
    pub(crate) best: Option<Turn>,
    /// Nodes visited.
    pub(crate) n_visits: u64,
}

/// Taker of what is known, every so often.
pub(crate) struct Saver<'a> {
    /// Seconds between two times.
    pub(crate) every: f64,
    /// Takes it; `false` means stop now.
    pub(crate) save: &'a mut dyn FnMut(&Known) -> bool,
}

/// What is known, and a saver that was last given it.
pub(crate) struct Kept<'a> {
    /// What is known.
    pub(crate) known: Known,
    saver: Option<Saver<'a>>,
    saved: Instant,
    is_saved: bool,
}

impl<'a> Kept<'a> {
    /// From what an earlier search has finished, if there was one.
    pub(crate) fn new(known: Option<Known>, saver: Option<Saver<'a>>) -> Self {
        Self { known: known.unwrap_or_default(), saver, saved: Instant::now(), is_saved: false }
    }

    /// A turn of a round is finished.
    pub(crate) fn finish(&mut self, round: usize, turn: Turn) {
        self.known.rounds[round].push(turn);
        self.is_saved = false;
    }

    /// A group is finished: only its best restart, or that of the groups before, is wanted.
    pub(crate) fn next_group(&mut self, first: usize, best: Turn) {
        let n_visits = self.known.n_visits;
        self.known = Known { first, best: Some(best), n_visits, ..Known::default() };
        self.is_saved = false;
    }

    /// Hand out what is known, now or if there is something new and it is time; whether to go on.
    pub(crate) fn save(&mut self, now: bool, n_visits: u64) -> bool {
        let Some(saver) = self.saver.as_mut().filter(|_| now || !self.is_saved) else { return true };
        if !now && self.saved.elapsed().as_secs_f64() < saver.every {
            return true;
        }
        self.known.n_visits = n_visits;
        self.is_saved = true;
        let goes_on = (saver.save)(&self.known);
        self.saved = Instant::now();
        goes_on
    }
}

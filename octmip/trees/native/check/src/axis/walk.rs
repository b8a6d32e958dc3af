//! The walk through a log: its records are read, those of deep nodes checked, and those to be counted set aside.

use std::sync::Arc;

use super::checker::{Bounds, Checker, Claim, Cut, Orders, Place};
use crate::log::cursor::Cursor;
use crate::log::decisions::Decisions;
use crate::refusal::{Checked, ensure};

/// Levels of the trees of a node whose sides the checker counts by itself.
const COUNTED_LEVELS: usize = 2;

/// A node whose sides are counted, and the place in the log where its record begins.
pub(super) struct Counted<'a> {
    pub(super) place: Arc<Place>,
    pub(super) depth: usize,
    /// Least size of leaves that is asked for.
    pub(super) leaf: usize,
    pub(super) cursor: Cursor<'a>,
}

/// A place in a log, and what was set aside before it.
///
/// A record is checked from what its inner records claim. A log is accepted when all of its records are, so it does not
/// matter which is checked first.
pub(super) struct Walk<'a> {
    checker: &'a Checker<'a>,
    cursor: Cursor<'a>,
    counted: Vec<Counted<'a>>,
}

impl<'a> Walk<'a> {
    /// A walk from the beginning of the body of a log.
    pub(super) fn new(checker: &'a Checker<'a>, cursor: Cursor<'a>) -> Self {
        Self { checker, cursor, counted: Vec::new() }
    }

    /// Read the proofs of all cases of sensors read; returns the nodes that are still to be counted, and the number of
    /// the last line.
    pub(super) fn cases(mut self, claim: i64) -> Checked<(Vec<Counted<'a>>, usize)> {
        let q = self.checker.q;
        let mut decisions = Decisions::new(q.sensor_cost.len());
        loop {
            decisions.read(&mut self.cursor)?;
            let line = self.cursor.line() + 1;
            let root = Place::Root(decisions.may_read(&q.sensor_cost, q.sensor_limit, usize::MAX));
            let Claim { bound, .. } = self.node(Arc::new(root), q.depth, q.leaf_size)?;
            ensure!(bound >= claim, line, "this proves {bound}, not {claim}");
            if !decisions.go_on() {
                self.cursor.expect_end()?;
                return Ok((self.counted, self.cursor.line()));
            }
        }
    }

    /// Read a record that every tree of `depth` levels, with leaves of `leaf` samples or of any size, costs the bound
    /// that it names on the samples of a place; check it, or set it aside.
    fn node(&mut self, place: Arc<Place>, depth: usize, leaf: usize) -> Checked<Claim> {
        let begin = self.cursor;
        let claim = self.checker.claim(&mut self.cursor, depth, leaf)?;
        if depth <= COUNTED_LEVELS {
            while self.cursor.take("F").is_some() {}
            self.cursor.expect::<0>("E")?;
            self.counted.push(Counted { place, depth, leaf, cursor: begin });
            return Ok(claim);
        }
        let orders = self.checker.orders(&place);
        let (end, cuts) = self.solved_cuts(&place, &orders, (depth, claim.leaf))?;
        self.cursor.expect::<0>("E")?;
        self.checker.check_node(&orders, depth, (end, &cuts), claim)?;
        Ok(claim)
    }

    /// Read the solved cuts of a deep node. Returns what is proven of the trees of one level less on all the samples,
    /// and the cuts.
    fn solved_cuts(
        &mut self,
        place: &Arc<Place>,
        orders: &Orders,
        (depth, leaf): (usize, usize),
    ) -> Checked<(Bounds, Vec<Cut>)> {
        let (mut end, mut cuts) = (Bounds::default(), Vec::new());
        if self.cursor.take("B").is_some() {
            let claim = self.node(place.clone(), depth - 1, leaf)?;
            end.raise(claim.leaf, claim.bound);
        }
        while let Some(numbers) = self.cursor.take("K") {
            for (feature, cut) in self.checker.cuts_of(&numbers, orders, self.cursor.line())? {
                let mut sides = [Bounds::default(); 2];
                for (side, tag) in sides.iter_mut().zip(["L", "R"]) {
                    while self.cursor.take(tag).is_some() {
                        let part = Place::Side { whole: place.clone(), feature, cut, is_left: tag == "L" };
                        let claim = self.node(Arc::new(part), depth - 1, leaf)?;
                        side.raise(claim.leaf, claim.bound);
                    }
                }
                cuts.push((feature, cut, sides));
            }
        }
        Ok((end, cuts))
    }
}

//! The nodes of a proof: every tree of some depth on some samples costs what the node claims.

use crate::log::cursor::Cursor;
use crate::log::decisions::Decisions;
use crate::refusal::{Checked, ensure};
use crate::regression::cuts::{Cuts, Known};
use crate::regression::grid::Samples;
use crate::regression::stumps::Stump;

/// Samples in every order.
type Orders = Vec<Vec<u32>>;

/// The samples and the log that is read.
pub(super) struct Checker<'a> {
    pub(super) q: &'a Samples,
    pub(super) cursor: Cursor<'a>,
}

impl Checker<'_> {
    /// Read the proofs of all cases of sensors read.
    pub(super) fn cases(&mut self, claim: i64) -> Checked<()> {
        let q = self.q;
        let mut decisions = Decisions::new(q.sensor_cost.len());
        loop {
            decisions.read(&mut self.cursor)?;
            let line = self.cursor.line() + 1;
            let may_read = decisions.may_read(&q.sensor_cost, q.sensor_limit, usize::MAX);
            let bound = self.node(&q.orders(&may_read), q.depth)?;
            ensure!(bound >= claim, line, "this proves {bound}, not {claim}");
            if !decisions.go_on() {
                return Ok(());
            }
        }
    }

    /// Read a record and check it: every tree of `depth` levels on these samples costs the bound that it names, which
    /// is returned.
    fn node(&mut self, orders: &Orders, depth: usize) -> Checked<i64> {
        let (q, line, set) = (self.q, self.cursor.line() + 1, &orders[self.q.p]);
        let [levels, size, bound] = self.cursor.expect("N")?;
        let leaf = q.leaf_size;
        ensure!((levels, size) == (depth as i64, leaf as i64), line, "expected depth {depth}, leaves of {leaf}");
        let end = self.shallower(orders, depth)?;
        let mut solved = vec![Vec::new(); q.p];
        while let Some(numbers) = self.cursor.take(if depth <= 2 { "F" } else { "K" }) {
            self.cuts(orders, depth, &numbers, &mut solved)?;
        }
        self.cursor.expect::<0>("E")?;
        let best = if depth == 1 { end.strict } else { q.leaf(set) };
        ensure!(best >= bound, line, "a tree costs {best}, not {bound}");
        if depth == 1 || q.clusters(set, 1 << depth.min(20)) >= bound {
            return Ok(bound);
        }
        for (f, known) in solved.iter_mut().enumerate().filter(|(f, _)| !orders[*f].is_empty()) {
            let cuts = Cuts::new(q, f, &orders[f], set, depth - 1);
            known.extend(cuts.ends(end.strict, end.relaxed));
            known.sort_by_key(|known: &Known| known.k);
            for cut in known.iter().filter(|cut| q.is_cut(f, &orders[f], cut.k)) {
                let (k, cost) = (cut.k, cut.strict[0] + cut.strict[1] + q.penalty);
                ensure!(cost >= bound, line, "cut {k} of feature {f}: {cost}, not {bound}");
            }
            for pair in known.windows(2) {
                let open = cuts.open((&pair[0], &pair[1]), bound - q.penalty, false);
                ensure!(open.is_none(), line, "cut {} of feature {f} may cost less than {bound}", open.unwrap_or(0));
            }
        }
        Ok(bound)
    }

    /// What all the samples cost in trees of one level less: counted, or proven by a record.
    fn shallower(&mut self, orders: &Orders, depth: usize) -> Checked<Stump> {
        if depth <= 2 {
            return Ok(self.q.stump(orders));
        }
        let strict = if self.cursor.take("B").is_some() { self.node(orders, depth - 1)? } else { 0 };
        Ok(Stump { strict, relaxed: self.relaxed(strict), feature: None })
    }

    /// What a bound of trees is worth where leaves may be of any size.
    fn relaxed(&self, strict: i64) -> i64 {
        if self.q.leaf_size == 1 { strict } else { 0 }
    }

    /// Read the solved cuts of a line and check what is said of their sides, or count it.
    fn cuts(&mut self, orders: &Orders, depth: usize, numbers: &[i64], solved: &mut [Vec<Known>]) -> Checked<()> {
        let (q, line) = (self.q, self.cursor.line());
        let f = numbers.first().map_or(q.p, |&f| f as usize);
        let mut k = 0usize;
        for step in numbers.iter().skip(1) {
            k = k.saturating_add(*step as usize);
            let is_between = f < q.p && k > 0 && k < orders[f].len();
            ensure!(is_between, line, "feature {f} has no cut {k} here");
            let mut known = Known { k, strict: [0; 2], relaxed: [0; 2] };
            for (side, tag) in ["L", "R"].into_iter().enumerate() {
                let part = q.part(orders, &orders[f][..k], tag == "L");
                if depth <= 2 {
                    let stump = q.stump(&part);
                    (known.strict[side], known.relaxed[side]) = (stump.strict, stump.relaxed);
                } else if self.cursor.take(tag).is_some() {
                    known.strict[side] = self.node(&part, depth - 1)?;
                    known.relaxed[side] = self.relaxed(known.strict[side]);
                }
            }
            solved[f].push(known);
        }
        Ok(())
    }
}

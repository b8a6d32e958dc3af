//! The nodes of a proof: every tree of some depth on some samples costs what the node claims.

use super::checker::{Checker, Cut, Orders};
use crate::log::decisions::Decisions;
use crate::refusal::{Checked, ensure};

impl Checker<'_> {
    /// Read the proofs of all cases of sensors read.
    pub(super) fn cases(&mut self, claim: i64) -> Checked<()> {
        let mut decisions = Decisions::new(self.q.sensor_cost.len());
        loop {
            decisions.read(&mut self.cursor)?;
            let line = self.cursor.line() + 1;
            let orders = self.orders(&decisions.may_read(&self.q.sensor_cost, self.q.sensor_limit, usize::MAX));
            let bound = self.node(&orders, self.q.depth)?;
            ensure!(bound >= claim, line, "this proves {bound}, not {claim}");
            if !decisions.go_on() {
                return Ok(());
            }
        }
    }

    /// Read a record and check it: every tree of `depth` levels on these samples costs the bound that it names, which
    /// is returned.
    fn node(&mut self, orders: &Orders, depth: usize) -> Checked<i64> {
        let (q, line, leaf) = (self.q, self.cursor.line() + 1, self.q.leaf_size);
        let [levels, size, bound] = self.cursor.expect("N")?;
        ensure!((levels, size) == (depth as i64, leaf as i64), line, "expected depth {depth}, leaves of {leaf}");
        let (end, cuts) = self.cuts(orders, depth)?;
        self.cursor.expect::<0>("E")?;
        let mut classes = vec![0; q.n_classes];
        orders[q.p].iter().for_each(|&i| self.join(&mut classes, i));
        let paid = |k| (0..classes.len()).map(|c| classes[c] * q.cost(c, k)).sum();
        let one_leaf = (0..classes.len()).map(paid).min().unwrap_or(0);
        let best = if depth == 1 { end } else { one_leaf };
        ensure!(best >= bound, line, "a tree costs {best}, not {bound}");
        for (f, order) in orders[..q.p].iter().enumerate().filter(|_| depth > 1) {
            let n = order.len();
            let mut known = [0, 1].map(|_| vec![0; n + 1]);
            for (_, k, sides) in cuts.iter().filter(|cut| cut.0 == f) {
                (known[0][*k], known[1][n - k]) = (sides[0], sides[1]);
            }
            let backwards: Vec<u32> = order.iter().rev().copied().collect();
            let left = self.side(order, &mut known[0], end, depth - 1);
            let right = self.side(&backwards, &mut known[1], end, depth - 1);
            for k in leaf..(n + 1).saturating_sub(leaf) {
                let cost = left[k] + right[n - k] + q.penalty;
                let holds = cost >= bound || !self.is_between(f, order, k);
                ensure!(holds, line, "cut {k} of feature {f}: {cost}, not {bound}");
            }
        }
        Ok(bound)
    }

    /// Read the solved cuts of a node and check what is said of their sides, or count it. Returns a bound of the trees
    /// of one level less on all the samples, and the cuts.
    fn cuts(&mut self, orders: &Orders, depth: usize) -> Checked<(i64, Vec<Cut>)> {
        let (all, is_counted) = (self.q.p, depth <= 2);
        let (mut end, mut cuts): (i64, Vec<Cut>) = (0, Vec::new());
        if !is_counted && self.cursor.take("B").is_some() {
            end = self.node(orders, depth - 1)?;
        }
        while let Some(numbers) = self.cursor.take(if is_counted { "F" } else { "K" }) {
            let (line, f) = (self.cursor.line(), numbers.first().map_or(all, |&f| f as usize));
            let mut k = 0;
            for step in numbers.iter().skip(1) {
                k += *step as usize;
                ensure!(f < all && self.is_between(f, &orders[f], k), line, "feature {f} has no cut {k} here");
                let mut sides = [0; 2];
                for (side, tag) in sides.iter_mut().zip(["L", "R"]).filter(|_| !is_counted) {
                    while self.cursor.take(tag).is_some() {
                        let part = self.part(orders, &orders[f][..k], tag == "L");
                        *side = self.node(&part, depth - 1)?.max(*side);
                    }
                }
                cuts.push((f, k, sides));
            }
        }
        if is_counted {
            let sides = |&(f, k, _): &Cut| [&orders[f][..k], &orders[f][k..]];
            let mut parts: Vec<&[u32]> = cuts.iter().flat_map(sides).collect();
            parts.push(&orders[all]);
            let costs = self.stumps(orders, &parts);
            for (cut, sides) in cuts.iter_mut().zip(costs.chunks(2)) {
                cut.2 = [sides[0], sides[1]];
            }
            end = costs[parts.len() - 1];
        }
        Ok((end, cuts))
    }
}

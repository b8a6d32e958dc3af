//! The checker of logs of axis-aligned trees.
//!
//! Format and proofs: docs/theory/proof.md. With `e(S)` the cost of the best tree of some depth on the samples S,
//! penalties included, what is used is, for disjoint S and M:
//!
//! * Growing: `e(S + M) >= e(S) + spread(M)`. A tree on S + M, empty leaves removed, is one on S (if leaves may have
//!   any size; S is empty else); besides, M costs it at least `spread(M)`, which counts classes and no penalties.
//! * Shrinking: `e(S) >= e(S + M) - most(M)`, what M costs at most: a tree on S is one on S + M.

mod stumps;

use crate::cursor::Cursor;
use crate::problem::Problem;
use crate::refusal::{Checked, ensure};
use crate::sensors::Decisions;

/// Samples in the order of each feature (empty unless it is in play), and last all of them anyhow.
type Orders = Vec<Vec<u32>>;
/// A solved cut: feature, number of samples to the left, bounds of the two sides.
type Cut = (usize, usize, [i64; 2]);

struct Checker<'a> {
    q: &'a Problem,
    /// What each sample costs when it is answered worst.
    worst: Vec<i64>,
    /// Answers to each sample, and what they save of that.
    savings: Vec<Vec<(usize, i64)>>,
    /// No sum is larger.
    most: i64,
    cursor: Cursor<'a>,
}

/// Check that the rest of a log proves that every tree costs `claim` or more.
pub(crate) fn check(q: &Problem, cursor: Cursor<'_>, claim: i64) -> Checked<()> {
    let cost = |i: usize, k| q.weights[i] * q.cost(q.labels[i] as usize, k);
    let worst = |i| (0..q.n_classes).map(|k| cost(i, k)).max().unwrap_or(0);
    let saving = |i, k| Some((k, worst(i) - cost(i, k))).filter(|saving| saving.1 > 0);
    let savings = |i| (0..q.n_classes).filter_map(|k| saving(i, k)).collect();
    let mut checker = Checker {
        q,
        most: (0..q.n).map(worst).sum::<i64>().max(2 * q.n as i64 + 1),
        worst: (0..q.n).map(worst).collect(),
        savings: (0..q.n).map(savings).collect(),
        cursor,
    };
    checker.cases(claim)?;
    checker.cursor.expect_end()
}

impl Checker<'_> {
    /// Read the proofs of all cases of sensors read.
    fn cases(&mut self, claim: i64) -> Checked<()> {
        let mut decisions = Decisions::new(self.q.sensor_cost.len());
        loop {
            decisions.read(&mut self.cursor)?;
            let line = self.cursor.line() + 1;
            let orders = self.orders(&decisions.may_read(self.q, usize::MAX));
            let bound = self.node(&orders, self.q.depth)?;
            ensure!(bound >= claim, line, "this proves {bound}, not {claim}");
            if !decisions.go_on() {
                return Ok(());
            }
        }
    }

    fn orders(&self, may_read: &[bool]) -> Orders {
        let q = self.q;
        let order = |f: usize| {
            let in_play = q.allowed[f] && may_read[q.sensor_of_feature[f] as usize];
            let mut order: Vec<u32> = (0..if in_play { q.n as u32 } else { 0 }).collect();
            order.sort_by_key(|&i| q.feature(f)[i as usize]);
            order
        };
        let mut orders: Orders = (0..q.p).map(order).collect();
        orders.push((0..q.n as u32).collect());
        orders
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

    fn part(&self, orders: &Orders, left: &[u32], is_left: bool) -> Orders {
        let mut kept = vec![!is_left; self.q.n];
        left.iter().for_each(|&i| kept[i as usize] = is_left);
        orders.iter().map(|order| order.iter().copied().filter(|&i| kept[i as usize]).collect()).collect()
    }

    /// Whether the first `cut` samples, not none and not all, lie below the others.
    fn is_between(&self, feature: usize, order: &[u32], cut: usize) -> bool {
        let rank = |k: usize| self.q.feature(feature)[order[k] as usize];
        0 < cut && cut < order.len() && rank(cut - 1) != rank(cut)
    }

    fn join(&self, classes: &mut [i64], sample: u32) {
        classes[self.q.labels[sample as usize] as usize] += self.q.weights[sample as usize];
    }

    /// What trees of `depth` levels cost at least, without penalties, by class weights: they give at most 2^depth
    /// answers, and a class that is none of them pays for its cheapest wrong answer.
    fn spread(&self, classes: &[i64], depth: usize) -> i64 {
        let (q, mut sure, mut more) = (self.q, 0, Vec::with_capacity(classes.len()));
        for (c, &weight) in classes.iter().enumerate() {
            let wrong = (0..q.n_classes).filter(|&k| k != c).map(|k| q.cost(c, k));
            let wrong = wrong.min().unwrap_or(0);
            sure += weight * wrong.min(q.cost(c, c));
            more.push(weight * (wrong - wrong.min(q.cost(c, c))));
        }
        more.sort_unstable();
        sure + more.iter().rev().skip(1 << depth.min(31)).sum::<i64>()
    }

    /// Bounds of one side of a feature's cuts, by its number of samples, which join in this order: from what is known
    /// of solved cuts and of all the samples, first growing, then shrinking.
    fn side(&self, order: &[u32], known: &mut [i64], end: i64, depth: usize) -> Vec<i64> {
        let (mut before, mut joined, mut bounds) = (0, vec![0; self.q.n_classes], vec![0]);
        known[order.len()] = end;
        for (&sample, bound) in order.iter().zip(&known[1..]) {
            self.join(&mut joined, sample);
            let grown = before + self.spread(&joined, depth);
            if self.q.leaf_size == 1 && *bound > grown {
                before = *bound;
                joined.fill(0);
            }
            bounds.push(grown.max(*bound));
        }
        for (k, &sample) in order.iter().enumerate().rev() {
            bounds[k] = bounds[k].max(bounds[k + 1] - self.worst[sample as usize]);
        }
        bounds
    }
}

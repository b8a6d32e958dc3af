//! The nodes of a proof: every tree of some depth on some samples costs what the node claims.

use super::checker::{Bounds, Checker, Claim, Cut, Orders};
use super::walk::Counted;
use crate::log::cursor::Cursor;
use crate::refusal::{Checked, ensure};

impl Checker<'_> {
    /// Read the line of a node: what is claimed of trees of `depth` levels whose leaves hold `leaf` samples or more, or
    /// any number.
    pub(super) fn claim(&self, cursor: &mut Cursor<'_>, depth: usize, leaf: usize) -> Checked<Claim> {
        let line = cursor.line() + 1;
        let [levels, size, bound] = cursor.expect("N")?;
        let is_asked = levels == depth as i64 && (size == 1 || size == leaf as i64);
        let or_any = if leaf > 1 { " or 1" } else { "" };
        ensure!(is_asked, line, "expected depth {depth}, leaves of {leaf}{or_any}");
        Ok(Claim { line, leaf: size as usize, bound })
    }

    /// Check a node of two levels or one: its record names cuts, whose sides are counted.
    pub(super) fn counted_node(&self, node: &Counted<'_>) -> Checked<()> {
        let (mut cursor, orders) = (node.cursor, self.orders(&node.place));
        let claim = self.claim(&mut cursor, node.depth, node.leaf)?;
        let mut cuts = Vec::new();
        while let Some(numbers) = cursor.take("F") {
            cuts.extend(self.cuts_of(&numbers, &orders, cursor.line())?);
        }
        // Nothing is inside the last set, and all samples are outside.
        let sets: Vec<&[u32]> = cuts.iter().map(|&(f, k)| &orders[f][..k]).chain([&[][..]]).collect();
        let mut costs = vec![[Bounds::default(); 2]; sets.len()];
        for leaf in if claim.leaf == 1 { vec![1] } else { vec![1, claim.leaf] } {
            for (costs, sides) in costs.iter_mut().zip(self.stumps(&orders, &sets, leaf)) {
                costs.iter_mut().zip(sides).for_each(|(cost, side)| cost.raise(leaf, side));
            }
        }
        let cuts: Vec<Cut> = cuts.iter().zip(&costs).map(|(&(f, k), &sides)| (f, k, sides)).collect();
        self.check_node(&orders, node.depth, (costs[cuts.len()][1], &cuts), claim)
    }

    /// The cuts that a line names, feature and samples to the left: a feature, rows left of the first cut and steps to
    /// the others.
    pub(super) fn cuts_of(&self, numbers: &[i64], orders: &Orders, line: usize) -> Checked<Vec<(usize, usize)>> {
        let f = numbers.first().map_or(self.q.p, |&f| f as usize);
        let order: &[u32] = if f < self.q.p { &orders[f] } else { &[] };
        let (mut rows, mut passed, mut k, mut cuts) = (0usize, 0, 0, Vec::new());
        for &step in numbers.iter().skip(1) {
            rows = rows.saturating_add(step as usize);
            while passed < rows && k < order.len() {
                passed += self.rows_of(order[k]);
                k += 1;
            }
            let is_cut = passed == rows && self.is_between(f, order, k);
            ensure!(is_cut, line, "feature {f} has no cut {rows} here");
            cuts.push((f, k));
        }
        Ok(cuts)
    }

    /// Check that every tree of `depth` levels on these samples costs `bound`: one leaf, and each cut of each feature.
    ///
    /// Known are a bound `end` of the trees of one level less on all the samples, and bounds of the sides of some cuts.
    pub(super) fn check_node(
        &self,
        orders: &Orders,
        depth: usize,
        (end, cuts): (Bounds, &[Cut]),
        claim: Claim,
    ) -> Checked<()> {
        let Claim { line, bound, .. } = claim;
        // A tree of one level is counted, and so is its leaf.
        let best = if depth == 1 { end.own } else { self.one_leaf(&orders[self.q.p]) };
        ensure!(best >= bound, line, "a tree costs {best}, not {bound}");
        for f in (0..self.q.p).filter(|_| depth > 1) {
            let own = cuts.iter().filter(|cut| cut.0 == f);
            self.check_feature(f, &orders[f], depth, (end, own), claim)?;
        }
        Ok(())
    }

    /// Check that every tree whose root is a cut of this feature costs `bound`.
    fn check_feature<'c>(
        &self,
        f: usize,
        order: &[u32],
        depth: usize,
        (end, cuts): (Bounds, impl Iterator<Item = &'c Cut>),
        Claim { line, leaf, bound }: Claim,
    ) -> Checked<()> {
        let n = order.len();
        let mut known = [0, 1].map(|_| vec![Bounds::default(); n + 1]);
        for (_, k, sides) in cuts {
            (known[0][*k], known[1][n - k]) = (sides[0], sides[1]);
        }
        let backwards: Vec<u32> = order.iter().rev().copied().collect();
        known.iter_mut().for_each(|known| known[n] = end);
        let left = self.side(order, &known[0], depth - 1);
        let right = self.side(&backwards, &known[1], depth - 1);
        for k in leaf..(n + 1).saturating_sub(leaf) {
            let cost = left[k] + right[n - k] + self.q.penalty;
            let holds = cost >= bound || !self.is_between(f, order, k);
            ensure!(holds, line, "cut {k} of feature {f}: {cost}, not {bound}");
        }
        Ok(())
    }

    /// Cost of the best leaf of some samples.
    fn one_leaf(&self, samples: &[u32]) -> i64 {
        let q = self.q;
        let mut classes = vec![0; q.n_classes];
        samples.iter().for_each(|&i| classes[q.labels[i as usize] as usize] += q.weights[i as usize]);
        let paid = |k| (0..classes.len()).map(|c| classes[c] * q.cost(c, k)).sum();
        (0..classes.len()).map(paid).min().unwrap_or(0)
    }
}

//! Bounds of samples from bounds of fewer and of more samples.
//!
//! With `e(S)` the cost of the best tree of some depth on the samples S, penalties included, what is used is, for
//! disjoint S and M:
//!
//! * Growing: `e(S + M) >= e(S) + spread(M)`. A tree on S + M, empty leaves removed, is one on S (if leaves may have
//!   any size; S is empty else); besides, M costs it at least `spread(M)`, which counts classes and no penalties.
//! * Shrinking: `e(S) >= e(S + M) - most(M)`, what M costs at most: a tree on S is one on S + M.

use super::checker::Checker;

impl Checker<'_> {
    /// A bound of trees of `depth` levels, without penalties, by class weights: they give at most 2^depth
    /// answers, and a class that is none of them pays for its cheapest wrong answer.
    pub(super) fn spread(&self, classes: &[i64], depth: usize) -> i64 {
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
    pub(super) fn side(&self, order: &[u32], known: &mut [i64], end: i64, depth: usize) -> Vec<i64> {
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

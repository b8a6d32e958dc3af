//! Bounds of samples from bounds of fewer and of more samples.
//!
//! With `e(S)` the cost of the best tree of some depth on the samples S, penalties included, what is used is, for
//! disjoint S and M:
//!
//! * Growing: `e(S + M) >= e(S) + spread(M)`. A tree on S + M, empty leaves removed, is one on S (if leaves may have
//!   any size; S is empty else); besides, M costs it at least `spread(M)`, which counts labels and no penalties.
//! * Shrinking: `e(S) >= e(S + M) - most(M)`, what M costs at most: a tree on S is one on S + M.

use super::checker::Checker;

impl Checker<'_> {
    /// Bounds of one side of a feature's cuts, by its number of samples, which join in this order: from what is known
    /// of solved cuts and of all the samples, first growing, then shrinking.
    pub(super) fn side(&self, order: &[u32], known: &mut [i64], end: i64, depth: usize) -> Vec<i64> {
        let (q, sets) = (self.q, &self.label_sets[depth]);
        let (mut before, mut joined, mut bounds) = (0, sets.none(), Vec::with_capacity(known.len()));
        bounds.push(0);
        known[order.len()] = end;
        for (&sample, &bound) in order.iter().zip(&known[1..]) {
            let i = sample as usize;
            let grown = before + sets.join(&mut joined, q.labels[i] as usize, q.weights[i]);
            if q.leaf_size == 1 && bound > grown {
                before = bound;
                joined.clear();
            }
            bounds.push(grown.max(bound));
        }
        for (k, &sample) in order.iter().enumerate().rev() {
            bounds[k] = bounds[k].max(bounds[k + 1] - self.worst[sample as usize]);
        }
        bounds
    }
}

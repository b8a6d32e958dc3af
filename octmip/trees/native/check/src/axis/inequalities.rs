//! Bounds of samples from bounds of fewer and of more samples.
//!
//! With `e(S)` the cost of the best tree of some depth on the samples S, penalties included, and `e_m(S)` the same
//! where leaves hold m samples or more, what is used is, for disjoint S and M:
//!
//! * Growing: `e(S + M) >= e(S) + spread(M)`. A tree on S + M, empty leaves removed, is one on S (S is empty where no
//!   bound of it is known); besides, M costs it at least `spread(M)`, which counts labels and no penalties.
//! * Shrinking: `e_m(S) >= e_m(S + M) - most(M)`, what M costs at most: a tree on S is one on S + M.
//! * Any size: `e_m(S) >= e(S)`.

use super::checker::{Bounds, Checker};

impl Checker<'_> {
    /// Bounds of one side of a feature's cuts, by its number of samples, which join in this order: from what is `known`
    /// of solved cuts and, last, of all the samples. First growing, with leaves of any size, then shrinking.
    pub(super) fn side(&self, order: &[u32], known: &[Bounds], depth: usize) -> Vec<i64> {
        let (q, sets) = (self.q, &self.label_sets[depth]);
        let (mut before, mut joined, mut bounds) = (0, sets.none(), Vec::with_capacity(known.len()));
        bounds.push(0);
        for (&sample, known) in order.iter().zip(&known[1..]) {
            let i = sample as usize;
            let grown = before + sets.join(&mut joined, q.labels[i] as usize, q.weights[i]);
            if known.free > grown {
                before = known.free;
                joined.clear();
            }
            bounds.push(grown.max(known.free).max(known.own));
        }
        for (k, &sample) in order.iter().enumerate().rev() {
            bounds[k] = bounds[k].max(bounds[k + 1] - self.worst[sample as usize]);
        }
        bounds
    }
}

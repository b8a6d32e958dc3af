//! Costs of samples in leaves, and the label-count bound of two children.

use super::checker::{Checker, DualPlane, NO_TREE, Tally};

impl Checker<'_> {
    /// Class weights and number of some samples.
    pub(super) fn tally(&self, ids: &[u32]) -> Tally {
        let mut tally = vec![0; self.q.n_classes + 1];
        ids.iter().for_each(|&i| self.join(&mut tally, i));
        tally
    }

    /// Count one sample.
    pub(super) fn join(&self, tally: &mut [i64], i: u32) {
        tally[self.q.labels[i as usize] as usize] += self.q.weights[i as usize];
        tally[self.q.n_classes] += 1;
    }

    /// Fewest samples in a leaf.
    pub(super) fn need(&self) -> i64 {
        self.q.leaf_size as i64
    }

    /// Price of a split in a dual plane.
    pub(super) fn price(&self, dual_plane: DualPlane) -> i64 {
        self.q.penalty * if dual_plane.1 == self.q.p { 1 } else { 2 }
    }

    /// Cost of samples that each have the cheapest of some labels.
    pub(super) fn choosing(&self, tally: &[i64], labels: &[usize]) -> i64 {
        let cheapest = |c| labels.iter().map(|&k| self.q.cost(c, k)).min().unwrap_or(0);
        (0..self.q.n_classes).map(|c| tally[c] * cheapest(c)).sum()
    }

    /// Cost of samples in one leaf.
    pub(super) fn leaf(&self, tally: &[i64]) -> i64 {
        let labels = 0..self.q.n_classes;
        labels.map(|k| self.choosing(tally, &[k])).min().unwrap_or(0)
    }

    /// The most that samples can cost.
    pub(super) fn most(&self, tally: &[i64]) -> i64 {
        let highest = |c| (0..self.q.n_classes).map(|k| self.q.cost(c, k)).max().unwrap_or(0);
        (0..self.q.n_classes).map(|c| tally[c] * highest(c)).sum()
    }

    /// Label-count bound of two children and the samples between them: a child gives two labels at most, costs what is
    /// known and what its samples cost with these; a sample between has the cheapest of all four.
    pub(super) fn label_count_bound(&self, costs: [i64; 2], sides: &[Tally; 2], open: &Tally) -> i64 {
        let k = self.q.n_classes;
        let pairs = || (0..k).flat_map(move |a| (a..k).map(move |b| [a, b]));
        let with = |s: usize| {
            let choices = pairs().map(|pair| (costs[s].max(self.choosing(&sides[s], &pair)), pair));
            let mut choices: Vec<_> = choices.collect();
            choices.sort_unstable();
            choices
        };
        let (left, right, mut best) = (with(0), with(1), NO_TREE);
        for (one, a) in left {
            for (other, b) in &right {
                if one + other >= best {
                    break;
                }
                let labels = [a[0], a[1], b[0], b[1]];
                best = best.min(one + other + self.choosing(open, &labels));
            }
        }
        best
    }
}

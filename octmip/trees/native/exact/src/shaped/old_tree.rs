//! What an old tree costs on the samples of a node, its splits kept and its leaves anew.

use crate::samples::Samples;
use crate::shaped::rules::Rules;
use crate::view::View;

/// The old tree below one of its places, or below one that it has not: a leaf.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    /// Of each sample, where it ends.
    leaf: Vec<u32>,
    pub(super) n_leaves: usize,
    /// Price of its splits.
    price: i64,
}

impl Kept {
    /// Of each row of the old tree, a leaf last; None where a split of it is none of these samples.
    pub(super) fn of_all(samples: &Samples, rules: &Rules) -> Option<Vec<Self>> {
        let leaf = Self { leaf: vec![0; samples.n], n_leaves: 1, price: 0 };
        let mut all: Vec<Self> = vec![leaf; rules.old.len() + 1];
        for (row, named) in rules.old.iter().enumerate().rev() {
            let &[(column, Some(cut))] = named.splits.as_slice() else {
                if named.splits.is_empty() {
                    continue;
                }
                return None;
            };
            let f = samples.features.iter().position(|&usable| usable == column)?;
            let [left, right] = named.sides.map(|side| &all[side.unwrap_or(rules.old.len())]);
            let is_left = samples.ranks_of(f).iter().map(|&rank| rank <= cut);
            let leaves = is_left
                .enumerate()
                .map(|(i, is_left)| if is_left { left.leaf[i] } else { left.n_leaves as u32 + right.leaf[i] });
            let (leaf, n_leaves) = (leaves.collect(), left.n_leaves + right.n_leaves);
            all[row] = Self { leaf, n_leaves, price: left.price + right.price + samples.penalty };
        }
        Some(all)
    }

    /// Its cost on all samples of a node.
    pub(super) fn cost(&self, samples: &Samples, view: &View) -> i64 {
        let mut counts = Counts::new(samples, self);
        view.ids(samples).for_each(|i| counts.add(i));
        counts.cost()
    }

    /// Its cost on one side of each cut of a feature.
    pub(super) fn costs(
        &self,
        samples: &Samples,
        view: &View,
        f: usize,
        (positions, side): (&[u32], usize),
    ) -> Vec<i64> {
        let (list, mut counts, mut from) = (view.list(f), Counts::new(samples, self), 0);
        let mut costs = vec![0; positions.len()];
        if side == 0 {
            for (cost, &to) in costs.iter_mut().zip(positions) {
                list[from..to as usize].iter().for_each(|&i| counts.add(i));
                (*cost, from) = (counts.cost(), to as usize);
            }
        } else {
            let mut to = list.len();
            for (cost, &from) in costs.iter_mut().zip(positions).rev() {
                list[from as usize..to].iter().for_each(|&i| counts.add(i));
                (*cost, to) = (counts.cost(), from as usize);
            }
        }
        costs
    }
}

/// Gains of each label at each leaf of a kept tree.
struct Counts<'a> {
    samples: &'a Samples,
    kept: &'a Kept,
    gains: Vec<i64>,
    best: Vec<i64>,
    range: i64,
    saved: i64,
}

impl<'a> Counts<'a> {
    fn new(samples: &'a Samples, kept: &'a Kept) -> Self {
        let gains = vec![0; kept.n_leaves * samples.n_labels];
        Self { samples, kept, gains, best: vec![0; kept.n_leaves], range: 0, saved: 0 }
    }

    fn add(&mut self, i: u32) {
        let (leaf, n_labels) = (self.kept.leaf[i as usize] as usize, self.samples.n_labels);
        let gains = &mut self.gains[leaf * n_labels..(leaf + 1) * n_labels];
        self.samples.count(i, 1, gains);
        let best = gains.iter().copied().max().unwrap_or(0);
        self.range += self.samples.ranges[i as usize];
        self.saved += best - self.best[leaf];
        self.best[leaf] = best;
    }

    fn cost(&self) -> i64 {
        self.range - self.saved + self.kept.price
    }
}

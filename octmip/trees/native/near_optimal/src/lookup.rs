//! The tree of a number: among those of one cost and one set of sensors, in a fixed order.
//!
//! Leaves come first, by label, then cuts in the order in which the core finds them; of a cut the pairs of children by
//! cost and sensors, those of one pair of costs by the number of the left child, then of the right one.

use crate::cost::Cost;
use crate::counter::Counter;
use crate::instance::{Instance, Totals};
use crate::spectrum::{Counts, Entry, Spectrum};
use crate::stumps::{self, Side};
use octmip_exact::{Solved, View};
use octmip_frame::tree::Tree;

/// Cost and sensors of the tree that is looked for, and its number among those.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<T> {
    /// What it costs.
    pub cost: T,
    /// A bit for each sensor that it reads.
    pub mask: u128,
    /// From 0.
    pub number: u128,
}

impl<T: Cost> Counter<'_, T> {
    /// The tree of a number of a node; None if there are fewer.
    pub fn tree(&mut self, view: &View, depth: usize, mut wanted: Wanted<T>) -> Option<Tree> {
        let totals = self.instance.totals_of(view);
        if wanted.mask == 0 {
            for label in (0..totals.gains.len()).filter(|&label| totals.leaf(label) == wanted.cost) {
                if wanted.number == 0 {
                    return Some(Tree::leaf(label as u32));
                }
                wanted.number -= 1;
            }
        }
        match depth {
            0 => None,
            1 => self.stump(view, totals, wanted),
            _ => self.all_cuts(view, depth, wanted.cost).into_iter().find_map(|cut| {
                let mut counts = Counts::new();
                self.count_cut(view, depth, &cut, wanted.cost, &mut counts);
                let count = counts.get(&(wanted.cost, wanted.mask)).copied().unwrap_or(0);
                if wanted.number < count {
                    return self.tree_of_cut(view, depth, &cut, wanted);
                }
                wanted.number -= count;
                None
            }),
        }
    }

    fn stump(&self, view: &View, totals: Totals<T>, mut wanted: Wanted<T>) -> Option<Tree> {
        let instance = self.instance;
        let sides = [Side { totals, len: view.len, limit: wanted.cost }, Side::empty(instance)];
        let mut found = None;
        for f in (0..instance.samples.p).filter(|&f| instance.masks[f] == wanted.mask && instance.fits(wanted.mask)) {
            stumps::walk(
                instance,
                f,
                view.list(f),
                |_| 0,
                &sides,
                |_, cut, labels, cost| {
                    if cost == wanted.cost && found.is_none() {
                        match wanted.number {
                            0 => found = Some(leaves(instance.samples.features[f], cut, labels)),
                            _ => wanted.number -= 1,
                        }
                    }
                },
            );
        }
        found
    }

    /// The tree of a number among those of one cut.
    pub fn tree_of_cut(&mut self, view: &View, depth: usize, cut: &Solved, mut wanted: Wanted<T>) -> Option<Tree> {
        let sides = self.sides(view, depth, cut, wanted.cost)?;
        let mask = self.instance.masks[cut.feature];
        let views = self.split(view, cut);
        for (l, r) in pairs(self.instance, &sides, wanted.cost - self.instance.penalty) {
            if mask | l.mask | r.mask != wanted.mask {
                continue;
            }
            let excluded = same_labels(&sides, &l, &r);
            let count = l.count * r.count - excluded.len() as u128;
            if wanted.number < count {
                let number = excluded.iter().fold(wanted.number, |number, &(i, j)| {
                    number + u128::from(number >= i * r.count + j) // ascending: each moves what follows by one
                });
                let child = |from: &Entry<T>, number| Wanted { cost: from.cost, mask: from.mask, number };
                let left = self.tree(&views[0], depth - 1, child(&l, number / r.count))?;
                let right = self.tree(&views[1], depth - 1, child(&r, number % r.count))?;
                return Some(Tree::join(self.feature(cut), self.rank(view, cut), &left, &right));
            }
            wanted.number -= count;
        }
        None
    }

    /// The problem's feature of a cut.
    pub(crate) fn feature(&self, cut: &Solved) -> u32 {
        self.instance.samples.features[cut.feature]
    }

    /// Largest rank that goes left.
    pub(crate) fn rank(&self, view: &View, cut: &Solved) -> u32 {
        self.instance.samples.ranks_of(cut.feature)[view.list(cut.feature)[cut.position - 1] as usize]
    }
}

fn leaves(feature: u32, cut: u32, labels: [usize; 2]) -> Tree {
    let [left, right] = labels.map(|label| Tree::leaf(label as u32));
    Tree::join(feature, cut, &left, &right)
}

/// Pairs of children that cost `rest` together.
fn pairs<T: Cost>(instance: &Instance<T>, sides: &[Spectrum<T>; 2], rest: T) -> Vec<(Entry<T>, Entry<T>)> {
    let [left, right] = sides;
    let mut found = Vec::new();
    for l in &left.entries {
        let from = right.entries.partition_point(|r| l.cost + r.cost < rest);
        let equal = right.entries[from..].iter().take_while(|r| l.cost + r.cost == rest);
        found.extend(equal.filter(|r| instance.fits(l.mask | r.mask)).map(|r| (*l, *r)));
    }
    found
}

/// Numbers of left and right child where both are leaves of one label, ascending.
fn same_labels<T: Cost>(sides: &[Spectrum<T>; 2], l: &Entry<T>, r: &Entry<T>) -> Vec<(u128, u128)> {
    if l.mask != 0 || r.mask != 0 {
        return Vec::new();
    }
    let number = |side: usize, label: usize| {
        let leaves = &sides[side].leaves;
        leaves[..label].iter().filter(|cost| **cost == leaves[label]).count() as u128
    };
    let both = |&label: &usize| sides[0].leaves[label] == l.cost && sides[1].leaves[label] == r.cost;
    (0..sides[0].leaves.len()).filter(both).map(|label| (number(0, label), number(1, label))).collect()
}

//! A tree of any depth, measured and changed: its nodes by place, the children of `k` at `2 k + 1` and `2 k + 2`.

use crate::tree::{Node, Tree};
use crate::worst_case::instance::{Instance, TRUE, distinct, subsets};

/// What is at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spot {
    /// Nothing.
    Empty,
    /// A label.
    Leaf(usize),
    /// A usable feature and the largest rank that goes left.
    Split(usize, u32),
}

/// Worst case, then cost without reading errors: smaller is better.
pub(crate) type Cost = (i64, i64);

/// The tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Draft {
    /// Its places, to the depth of the problem.
    pub(crate) spots: Vec<Spot>,
}

impl Draft {
    /// A leaf.
    pub(crate) fn leaf(instance: &Instance, label: usize) -> Self {
        let mut spots = vec![Spot::Empty; (2 << instance.depth) - 1];
        spots[0] = Spot::Leaf(label);
        Self { spots }
    }

    /// A tree of the problem; none where it reads a feature that no split may read.
    pub(crate) fn of(instance: &Instance, tree: &Tree) -> Option<Self> {
        let mut draft = Self::leaf(instance, 0);
        let mut stack = vec![(0, 0)];
        while let Some((node, place)) = stack.pop() {
            match tree.nodes.get(node)? {
                Node::Leaf { label } => *draft.spots.get_mut(place)? = Spot::Leaf(*label as usize),
                Node::Split { feature, cut, left, right } => {
                    let usable = instance.features.iter().position(|own| own.index == *feature)?;
                    *draft.spots.get_mut(place)? = Spot::Split(usable, *cut);
                    stack.push((*left as usize, 2 * place + 1));
                    stack.push((*right as usize, 2 * place + 2));
                }
                Node::Hyperplane { .. } => return None,
            }
        }
        Some(draft)
    }

    /// The tree as a table of nodes.
    pub(crate) fn to_tree(&self, instance: &Instance) -> Tree {
        self.subtree(instance, 0)
    }

    fn subtree(&self, instance: &Instance, place: usize) -> Tree {
        match self.spots[place] {
            Spot::Split(feature, cut) => {
                let sides = [2 * place + 1, 2 * place + 2].map(|side| self.subtree(instance, side));
                Tree::join(instance.features[feature].index, cut, &sides[0], &sides[1])
            }
            Spot::Leaf(label) => Tree::leaf(label as u32),
            Spot::Empty => Tree::leaf(0),
        }
    }

    /// Places of all splits.
    pub(crate) fn splits(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.spots.len()).filter(|&place| matches!(self.spots[place], Spot::Split(..)))
    }

    /// The sensors that splits read, but for the one at a place.
    pub(crate) fn sensors(&self, instance: &Instance, but: Option<usize>) -> Vec<usize> {
        let others = self.splits().filter(|&place| Some(place) != but);
        distinct(others.filter_map(|place| match self.spots[place] {
            Spot::Split(feature, _) => Some(instance.features[feature].sensor),
            _ => None,
        }))
    }

    /// Empty everything below a place.
    pub(crate) fn clear_below(&mut self, place: usize) {
        for side in [2 * place + 1, 2 * place + 2] {
            if self.spots.get(side).is_some_and(|spot| *spot != Spot::Empty) {
                self.clear_below(side);
                self.spots[side] = Spot::Empty;
            }
        }
    }

    /// Most that a sample pays at the leaves below a place that it may reach, those below `but` left out.
    pub(crate) fn most(
        &self,
        instance: &Instance,
        sample: usize,
        place: usize,
        off: &[usize],
        but: usize,
    ) -> Option<i64> {
        if place == but {
            return None;
        }
        match self.spots[place] {
            Spot::Empty => None,
            Spot::Leaf(label) => Some(instance.paid(sample, label)),
            Spot::Split(feature, cut) => {
                let own = &instance.features[feature];
                let (left, right) = own.ways(sample, cut, off.contains(&own.sensor));
                let side = |may: bool, at: usize| may.then(|| self.most(instance, sample, at, off, but)).flatten();
                side(left, 2 * place + 1).max(side(right, 2 * place + 2))
            }
        }
    }

    /// Whether a sample may reach a place.
    pub(crate) fn may_reach(&self, instance: &Instance, sample: usize, place: usize, off: &[usize]) -> bool {
        let mut at = place;
        while at > 0 {
            let above = (at - 1) / 2;
            let Spot::Split(feature, cut) = self.spots[above] else { return false };
            let own = &instance.features[feature];
            let (left, right) = own.ways(sample, cut, off.contains(&own.sensor));
            if !(if at % 2 == 1 { left } else { right }) {
                return false;
            }
            at = above;
        }
        true
    }

    /// Worst case and cost without reading errors; none where a leaf is too small or the sensors are too expensive.
    pub(crate) fn cost(&self, instance: &Instance) -> Option<Cost> {
        let sensors = self.sensors(instance, None);
        if !instance.fits(&sensors) || !self.has_full_leaves(instance) {
            return None;
        }
        let penalty = instance.penalty * self.splits().count() as i64;
        let nowhere = self.spots.len();
        let sum = |off: &[usize]| {
            let paid = |i: usize| self.most(instance, i, 0, off, nowhere).unwrap_or(0);
            (0..instance.n).map(paid).sum::<i64>() + penalty
        };
        let worst = subsets(&sensors, instance.n_off).iter().map(|off| sum(off)).max()?;
        Some((worst, sum(&[])))
    }

    fn has_full_leaves(&self, instance: &Instance) -> bool {
        let mut sizes = vec![0; self.spots.len()];
        for i in 0..instance.n {
            let mut place = 0;
            while let Spot::Split(feature, cut) = self.spots[place] {
                place = 2 * place + if instance.features[feature].ranks[TRUE][i] <= cut { 1 } else { 2 };
            }
            sizes[place] += 1;
        }
        let is_full = |place: usize| !matches!(self.spots[place], Spot::Leaf(_)) || sizes[place] >= instance.leaf_size;
        (0..self.spots.len()).all(is_full)
    }
}

//! Boxes of trees: for the root and each child the cuts of an interval, the labels of all leaves given.

use crate::worst_case::draft::{Draft, Spot};
use crate::worst_case::instance::{HIGH, Instance, LOW, TRUE, distinct, subsets};

/// Cuts `lo` to `hi` of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Cuts {
    /// Index of the usable feature.
    pub(crate) feature: usize,
    /// The lowest cut.
    pub(crate) lo: u32,
    /// The highest cut.
    pub(crate) hi: u32,
}

impl Cuts {
    /// The number of cuts.
    pub(crate) fn width(self) -> u32 {
        self.hi - self.lo + 1
    }

    /// Both halves.
    pub(crate) fn halves(self) -> [Self; 2] {
        let middle = self.lo + (self.hi - self.lo) / 2;
        [Self { hi: middle, ..self }, Self { lo: middle + 1, ..self }]
    }

    /// Whether a sample may go left at every cut, and right at every cut.
    pub(crate) fn sure_ways(self, instance: &Instance, sample: usize, is_off: bool) -> (bool, bool) {
        let ranks = &instance.features[self.feature].ranks;
        let (low, high) = if is_off { (LOW, HIGH) } else { (TRUE, TRUE) };
        (ranks[low][sample] <= self.lo, ranks[high][sample] > self.hi)
    }
}

/// A leaf, or splits with two leaves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Child {
    /// None for a leaf.
    pub(crate) cuts: Option<Cuts>,
    /// Labels left and right; equal for a leaf.
    pub(crate) labels: [usize; 2],
}

impl Child {
    /// The sensor that it reads.
    pub(crate) fn sensor(&self, instance: &Instance) -> Option<usize> {
        self.cuts.map(|cuts| instance.features[cuts.feature].sensor)
    }

    /// What a sample pays at least, at every cut.
    fn least(&self, instance: &Instance, sample: usize, is_off: bool) -> i64 {
        let [left, right] = self.labels.map(|label| instance.paid(sample, label));
        match self.cuts.map(|cuts| cuts.sure_ways(instance, sample, is_off)) {
            None | Some((true, false)) => left,
            Some((true, true)) => left.max(right),
            Some((false, true)) => right,
            Some((false, false)) => left.min(right),
        }
    }
}

/// Which of root, left and right child are off.
pub(crate) type Scenario = [bool; 3];

/// The scenarios of largest sets of sensors, given those that root, left and right child read.
pub(crate) fn scenarios(sensors: [Option<usize>; 3], n_off: usize) -> Vec<Scenario> {
    let sets = subsets(&distinct(sensors.into_iter().flatten()), n_off);
    sets.iter().map(|off| sensors.map(|sensor| sensor.is_some_and(|own| off.contains(&own)))).collect()
}

/// Trees with a root and two children.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trees {
    /// Cuts of the root.
    pub(crate) root: Cuts,
    /// The children.
    pub(crate) children: [Child; 2],
}

impl Trees {
    /// The sensors of root, left and right child.
    pub(crate) fn sensors(&self, instance: &Instance) -> [Option<usize>; 3] {
        let [left, right] = self.children.map(|child| child.sensor(instance));
        [Some(instance.features[self.root.feature].sensor), left, right]
    }

    /// A number that no worst case of these trees is below; the worst case itself of one tree.
    pub(crate) fn bound(&self, instance: &Instance) -> i64 {
        let n_splits = 1 + self.children.iter().filter(|child| child.cuts.is_some()).count() as i64;
        let all = scenarios(self.sensors(instance), instance.n_off);
        let sum = |off: &Scenario| (0..instance.n).map(|i| self.least(instance, i, *off)).sum::<i64>();
        instance.penalty * n_splits + all.iter().map(sum).max().unwrap_or(0)
    }

    fn least(&self, instance: &Instance, sample: usize, off: Scenario) -> i64 {
        let paid = |side: usize| self.children[side].least(instance, sample, off[side + 1]);
        match self.root.sure_ways(instance, sample, off[0]) {
            (true, true) => paid(0).max(paid(1)),
            (true, false) => paid(0),
            (false, true) => paid(1),
            (false, false) => paid(0).min(paid(1)),
        }
    }

    /// The widest part in two; none for a single tree.
    pub(crate) fn halves(&self) -> Option<[Self; 2]> {
        let width = |cuts: Option<Cuts>| cuts.map_or(1, Cuts::width);
        let [root, left, right] = [Some(self.root), self.children[0].cuts, self.children[1].cuts].map(width);
        if root.max(left).max(right) == 1 {
            return None;
        }
        if root >= left.max(right) {
            return Some(self.root.halves().map(|root| Self { root, ..*self }));
        }
        let side = usize::from(right > left);
        self.children[side].cuts.map(|cuts| {
            cuts.halves().map(|half| {
                let mut part = *self;
                part.children[side].cuts = Some(half);
                part
            })
        })
    }

    /// The tree of the lowest cuts.
    pub(crate) fn draft(&self, instance: &Instance) -> Draft {
        let mut draft = Draft::leaf(instance, 0);
        draft.spots[0] = Spot::Split(self.root.feature, self.root.lo);
        for (side, child) in self.children.iter().enumerate() {
            match child.cuts {
                None => draft.spots[1 + side] = Spot::Leaf(child.labels[0]),
                Some(cuts) => {
                    draft.spots[1 + side] = Spot::Split(cuts.feature, cuts.lo);
                    draft.spots[3 + 2 * side] = Spot::Leaf(child.labels[0]);
                    draft.spots[4 + 2 * side] = Spot::Leaf(child.labels[1]);
                }
            }
        }
        draft
    }
}

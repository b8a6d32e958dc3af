//! Two children joined: the worst case itself, for all pairs at a cut of the root that may beat the best tree.

use crate::drift::candidates::{Child, Measured, children};
use crate::drift::cut::RootCut;
use crate::drift::instance::{Instance, distinct, subsets};
use crate::drift::label_sets::scaled;
use crate::drift::zones::{BAND_LEFT, BAND_RIGHT};
use crate::tree::{Node, Tree};

/// Look at every tree of a cut that may cost less than `best`; cheaper ones are handed on, each better than the last.
///
/// `costs` are the least mixed costs of both children. False where the search was stopped.
pub(crate) fn close(
    root: &RootCut<'_>,
    costs: [&[i64]; 2],
    best: &dyn Fn() -> i64,
    is_stopped: &dyn Fn() -> bool,
    take: &mut dyn FnMut(i64, Tree),
) -> bool {
    let prepared = root.prepared;
    let band = root.band();
    for same in [[false, false], [false, true], [true, false], [true, true]] {
        let of = |k: usize| {
            let mixture = &prepared.mixtures[k];
            let fixed = scaled(root.sets.base + prepared.instance.penalty) + mixture.root_share() * band;
            (fixed, costs[0][k], costs[1][k])
        };
        let mut usable: Vec<usize> =
            (0..prepared.mixtures.len()).filter(|&k| prepared.mixtures[k].same == same).collect();
        usable.sort_by_key(|&k| -(of(k).0 + of(k).1 + of(k).2));
        let Some(&strongest) = usable.first() else { continue };
        let (fixed, least_left, least_right) = of(strongest);
        let target = scaled(best() - 1);
        if fixed + least_left + least_right > target {
            continue;
        }
        let left: Vec<(usize, i64)> = usable.iter().map(|&k| (k, target - of(k).0 - of(k).2)).collect();
        let right: Vec<(usize, i64)> = usable.iter().map(|&k| (k, target - of(k).0 - of(k).1)).collect();
        let (left, right) = (children(root, 0, same[0], &left), children(root, 1, same[1], &right));
        if !join(root, fixed, left, right, best, is_stopped, take) {
            return false;
        }
    }
    true
}

fn join(
    root: &RootCut<'_>,
    fixed: i64,
    left: Vec<Child>,
    right: Vec<Child>,
    best: &dyn Fn() -> i64,
    is_stopped: &dyn Fn() -> bool,
    take: &mut dyn FnMut(i64, Tree),
) -> bool {
    let instance = root.prepared.instance;
    let is_band = |&i: &usize| matches!(root.zones.zone(instance.n_rows, i), BAND_LEFT | BAND_RIGHT);
    let band: Vec<usize> = (0..instance.n).filter(is_band).collect();
    let mut right: Vec<(Child, Option<Option<Measured>>)> = right.into_iter().map(|child| (child, None)).collect();
    for child in left {
        let limit = scaled(best() - 1) - fixed;
        if is_stopped() {
            return false;
        }
        if right.first().is_none_or(|(other, _)| child.value + other.value > limit) {
            break;
        }
        let Some(mut ours) = Measured::new(root, 0, child) else { continue };
        for (other, theirs) in &mut right {
            if child.value + other.value > limit {
                break;
            }
            let Some(theirs) = theirs.get_or_insert_with(|| Measured::new(root, 1, *other)) else { continue };
            let splits = 1 + [&child, other].iter().filter(|side| side.split.is_some()).count() as i64;
            let limit = best() - splits * instance.penalty;
            let mut pair = Pair { root, band: &band, sides: [&mut ours, theirs] };
            if let Some(cost) = pair.worst(limit) {
                take(cost + splits * instance.penalty, tree(root, [&child, other]));
            }
        }
    }
    true
}

struct Pair<'a> {
    root: &'a RootCut<'a>,
    band: &'a [usize],
    sides: [&'a mut Measured; 2],
}

impl Pair<'_> {
    /// The worst case, penalty aside, if it is below a limit and the sensors are within the budget.
    fn worst(&mut self, limit: i64) -> Option<i64> {
        let [left, right] = [&*self.sides[0], &*self.sides[1]];
        let one_off = (left.still[1] + right.still[0]).max(left.still[0] + right.still[1]);
        let root_off = left.sure[0] + right.sure[0] + left.band[0].max(right.band[0]);
        if one_off.max(root_off) >= limit {
            return None;
        }
        let instance = self.root.prepared.instance;
        let own = instance.features[self.root.feature].sensor;
        let sensors = distinct([Some(own), left.sensor, right.sensor].into_iter().flatten());
        if !instance.fits(&sensors) {
            return None;
        }
        let mut worst = 0;
        for off in subsets(&sensors, instance.n_off) {
            worst = worst.max(self.cost(&off, own));
            if worst >= limit {
                return None;
            }
        }
        Some(worst)
    }

    /// What the tree costs while some sensors are off.
    fn cost(&mut self, off: &[usize], own: usize) -> i64 {
        let is_off = |sensor: usize| off.contains(&sensor);
        let states = [0, 1].map(|side| usize::from(self.sides[side].sensor.is_some_and(is_off)));
        if !is_off(own) {
            return self.sides[0].still[states[0]] + self.sides[1].still[states[1]];
        }
        for (side, state) in self.sides.iter_mut().zip(states) {
            side.list(self.root.prepared.instance, self.band, state);
        }
        let pairs = self.sides[0].each(states[0]).iter().zip(self.sides[1].each(states[1]));
        let band: i64 = pairs.map(|(left, right)| *left.max(right)).sum();
        self.sides[0].sure[states[0]] + self.sides[1].sure[states[1]] + band
    }
}

fn tree(root: &RootCut<'_>, sides: [&Child; 2]) -> Tree {
    let instance = root.prepared.instance;
    let [left, right] = sides.map(|side| subtree(instance, side));
    Tree::join(instance.features[root.feature].index, root.cut, &left, &right)
}

fn subtree(instance: &Instance, child: &Child) -> Tree {
    let leaf = |label: usize| Node::Leaf { label: label as u32 };
    match child.split {
        None => Tree { nodes: vec![leaf(child.labels[0])] },
        Some((feature, cut)) => {
            let feature = instance.features[feature].index;
            let split = Node::Split { feature, cut, left: 1, right: 2 };
            Tree { nodes: vec![split, leaf(child.labels[0]), leaf(child.labels[1])] }
        }
    }
}

//! Children that may belong to a better tree, and what they cost in every scenario.

use crate::drift::cut::RootCut;
use crate::drift::instance::Instance;
use crate::drift::label_sets::{LANES, scaled};
use crate::drift::scan::{start, walk};
use crate::drift::zones::{BAND_LEFT, BAND_RIGHT, LEFT, RIGHT};

/// A leaf, or a split with two leaves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Child {
    /// The feature and the largest rank that goes left; none for a leaf.
    pub(crate) split: Option<(usize, u32)>,
    /// Labels left and right; equal for a leaf.
    pub(crate) labels: [usize; 2],
    /// Its mixed cost, `WHOLE` times over.
    pub(crate) value: i64,
}

impl Child {
    /// Most that a sample pays at the leaves that it may reach.
    pub(crate) fn paid(&self, instance: &Instance, sample: usize, is_off: bool) -> i64 {
        let Some((feature, cut)) = self.split else { return instance.paid(sample, self.labels[0]) };
        match instance.features[feature].ways(sample, cut, is_off) {
            (true, true) => instance.paid(sample, self.labels[0]).max(instance.paid(sample, self.labels[1])),
            (is_left, _) => instance.paid(sample, self.labels[usize::from(!is_left)]),
        }
    }

    /// The sensor that it reads.
    pub(crate) fn sensor(&self, instance: &Instance) -> Option<usize> {
        self.split.map(|(feature, _)| instance.features[feature].sensor)
    }
}

/// All children of one side and type whose cost is at most a limit in every mixture, the cheapest in the first first.
pub(crate) fn children(root: &RootCut<'_>, side: usize, same: bool, limits: &[(usize, i64)]) -> Vec<Child> {
    let instance = root.prepared.instance;
    let chosen: Vec<usize> = limits.iter().map(|&(mixture, _)| mixture).collect();
    let table = root.table(side, &chosen);
    let may_belong = |lanes: &[i64; LANES], order: usize, more: i64| {
        limits.iter().enumerate().all(|(k, (_, limit))| lanes[2 * k + order] + more <= *limit)
    };
    let leaves = start(&table, root.zones);
    let labels = root.sets.labels[side];
    let mut found = Vec::new();
    if !same {
        let leaf = |order: usize| Child { split: None, labels: [labels[1 - order]; 2], value: leaves[order] };
        found.extend([0, 1].into_iter().filter(|&order| may_belong(&leaves, order, 0)).map(leaf));
    }
    let n_rows = instance.n_rows as u32;
    let dead = if side == 0 { 3 * n_rows..4 * n_rows } else { 0..n_rows };
    let is_member = |i: usize| root.zones.is_member(instance.n_rows, i, side);
    for f in root.features(same) {
        let Some((lowest, highest)) = instance.features[f].window(instance.leaf_size, is_member) else { continue };
        let mut take = |first: u32, last: u32, value: &[i64; LANES]| {
            let cut = first.max(lowest);
            if cut > last.min(highest) {
                return;
            }
            let penalty = scaled(instance.penalty);
            for order in (0..2).filter(|&order| may_belong(value, order, penalty)) {
                let labels = [labels[order], labels[1 - order]];
                found.push(Child { split: Some((f, cut)), labels, value: value[order] + penalty });
            }
        };
        walk(
            root.prepared.events(root.pairs[side], f),
            &table,
            root.zones,
            &instance.weights,
            leaves,
            &dead,
            &mut take,
        );
    }
    found.sort_by_key(|child| child.value);
    found
}

/// A child with its costs: of true readings, and with its own sensor off.
#[derive(Debug)]
pub(crate) struct Measured {
    /// The child.
    pub(crate) child: Child,
    /// Its sensor.
    pub(crate) sensor: Option<usize>,
    /// Cost of the samples that go to it by the root's true reading.
    pub(crate) still: [i64; 2],
    /// Cost of the samples that surely go to it.
    pub(crate) sure: [i64; 2],
    /// Cost of all samples in the root's band.
    pub(crate) band: [i64; 2],
    /// The same, sample by sample; empty until asked for.
    each: [Vec<i64>; 2],
}

impl Measured {
    /// Measure a child at a cut of the root; none for a split that some leaf is no worse than for any sample.
    ///
    /// The leaf reads no sensor and costs no penalty, so with it the tree is no worse in any scenario.
    pub(crate) fn new(root: &RootCut<'_>, side: usize, child: Child) -> Option<Self> {
        let instance = root.prepared.instance;
        let mut leaves: Vec<usize> = if child.split.is_some() { (0..instance.n_labels).collect() } else { Vec::new() };
        let is_split = !leaves.is_empty();
        let (own, own_band) = if side == 0 { (LEFT, BAND_LEFT) } else { (RIGHT, BAND_RIGHT) };
        let (mut still, mut sure, mut band) = ([0; 2], [0; 2], [0; 2]);
        for i in 0..instance.n {
            let zone = root.zones.zone(instance.n_rows, i);
            if zone + own == LEFT + RIGHT {
                continue; // surely on the other side
            }
            for off in 0..2 {
                let paid = child.paid(instance, i, off == 1);
                if off == 0 && !leaves.is_empty() {
                    leaves.retain(|&label| instance.paid(i, label) <= paid);
                }
                if zone == own {
                    sure[off] += paid;
                } else {
                    band[off] += paid;
                }
                if zone == own || zone == own_band {
                    still[off] += paid;
                }
            }
        }
        let is_needed = !is_split || leaves.is_empty();
        let sensor = child.sensor(instance);
        is_needed.then_some(Self { child, sensor, still, sure, band, each: Default::default() })
    }

    /// Prepare the costs of single samples in the band.
    pub(crate) fn list(&mut self, instance: &Instance, band: &[usize], off: usize) {
        if self.each[off].is_empty() {
            self.each[off] = band.iter().map(|&i| self.child.paid(instance, i, off == 1)).collect();
        }
    }

    /// Costs of single samples in the band, once they are listed.
    pub(crate) fn each(&self, off: usize) -> &[i64] {
        &self.each[off]
    }
}

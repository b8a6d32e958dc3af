//! One cut of the root: a bound of all trees that have it, from the least mixed costs of both children.
//!
//! A child never gets cheaper when samples are added to it (leaf sizes left aside): what the left child costs at a cut
//! bounds what it costs at higher cuts, what the right child costs bounds lower ones. So bounds of both ends of an
//! interval of cuts bound every tree between them.

use crate::worst_case::instance::{Event, HIGH, Instance, LOW, TRUE};
use crate::worst_case::label_sets::{LabelSets, Lanes, Table, label_pairs, scaled};
use crate::worst_case::scan::{Weights, least, start};
use crate::worst_case::shares::{Mixture, mixtures};
use crate::worst_case::zones::Zones;

/// No child of that type.
pub(crate) const NONE: i64 = i64::MAX / 8;
/// Events that may be stored again for single pairs of labels.
const MOST_EVENTS: usize = 50_000_000;
/// Weights by row and rank that may be stored.
const MOST_WEIGHTS: usize = 20_000_000;

/// What all cuts share.
#[derive(Debug)]
pub(crate) struct Prepared<'a> {
    /// The problem.
    pub(crate) instance: &'a Instance,
    /// The mixtures.
    pub(crate) mixtures: Vec<Mixture>,
    /// Pairs of labels of one child.
    pub(crate) pairs: Vec<[usize; 2]>,
    /// Whether all weights are 1.
    are_units: bool,
    /// For each pair of labels and feature the events of rows that tell them apart; empty where all are used.
    events: Vec<Vec<Vec<Event>>>,
    /// For each feature, by rank and row: weight up to it by lowest, true and highest readings.
    weights: Vec<[Vec<i64>; 3]>,
}

impl<'a> Prepared<'a> {
    /// Everything that does not depend on a cut.
    pub(crate) fn new(instance: &'a Instance) -> Self {
        let pairs = label_pairs(instance.n_labels);
        let n_events: usize = instance.features.iter().map(|feature| feature.events.len()).sum();
        let told = |pair: [usize; 2], event: &Event| {
            let row = instance.rows[event.sample()] as usize;
            instance.cost(row, pair[0]) != instance.cost(row, pair[1])
        };
        let of_pair = |&pair: &[usize; 2]| -> Vec<Vec<Event>> {
            let some = |events: &Vec<Event>| events.iter().copied().filter(|event| told(pair, event)).collect();
            instance.features.iter().map(|feature| some(&feature.events)).collect()
        };
        let is_small = pairs.len() * n_events <= MOST_EVENTS;
        Self {
            events: if is_small { pairs.iter().map(of_pair).collect() } else { Vec::new() },
            are_units: instance.weights.iter().all(|&weight| weight == 1),
            mixtures: mixtures(instance.n_off),
            weights: cumulated(instance),
            instance,
            pairs,
        }
    }

    /// The events of a feature that matter to a pair of labels.
    pub(crate) fn events(&self, pair: usize, feature: usize) -> &[Event] {
        self.events.get(pair).map_or(&self.instance.features[feature].events, |of_pair| &of_pair[feature])
    }

    /// Weights of the samples.
    pub(crate) fn sample_weights(&self) -> Weights<'_> {
        Weights { each: &self.instance.weights, are_units: self.are_units }
    }

    /// What the band of a root that is off pays at least, at every cut of an interval, above the floors.
    pub(crate) fn band(&self, sets: &LabelSets, feature: usize, lo: u32, hi: u32) -> i64 {
        let n_rows = self.instance.n_rows;
        let Some([low, _, high]) = self.weights.get(feature) else { return 0 };
        let of_row = |row: usize| (low[lo as usize * n_rows + row] - high[hi as usize * n_rows + row]).max(0);
        (0..n_rows).map(|row| sets.band[row] * of_row(row)).sum()
    }

    /// Weights by row that pass a cut with their lowest, true and highest readings when it moves from `lo` to `hi`.
    pub(crate) fn moved(&self, feature: usize, lo: u32, hi: u32) -> Option<[Vec<i64>; 3]> {
        let n_rows = self.instance.n_rows;
        let of = |sums: &Vec<i64>| -> Vec<i64> {
            (0..n_rows).map(|row| sums[hi as usize * n_rows + row] - sums[lo as usize * n_rows + row]).collect()
        };
        self.weights.get(feature).map(|kinds| [LOW, TRUE, HIGH].map(|kind| of(&kinds[kind])))
    }

    /// Whether a child of a root of this feature may read another feature, and whether it is one of the same sensor.
    pub(crate) fn child(&self, root: usize, feature: usize) -> Option<bool> {
        let [own, other] = [root, feature].map(|f| self.instance.features[f].sensor);
        let may = self.instance.depth > 1 && (own == other || self.instance.fits(&[own, other]));
        may.then_some(own == other)
    }

    /// A bound, `WHOLE` times over, from what both children cost in every mixture; `NONE` where there is no tree.
    pub(crate) fn bound(&self, sets: &LabelSets, band: i64, children: [&[i64]; 2], same: [bool; 2]) -> i64 {
        let fixed = scaled(sets.base + self.instance.penalty);
        let of =
            |(k, mixture): (usize, &Mixture)| fixed + mixture.root_share() * band + children[0][k] + children[1][k];
        let usable = self.mixtures.iter().enumerate().filter(|(_, mixture)| mixture.same == same);
        usable.map(of).max().unwrap_or(NONE).min(NONE)
    }

    /// The least bound over all types of children.
    pub(crate) fn least_bound(&self, sets: &LabelSets, band: i64, children: [&[i64]; 2]) -> i64 {
        let types = [[false, false], [false, true], [true, false], [true, true]];
        types.map(|same| self.bound(sets, band, children, same)).into_iter().min().unwrap_or(NONE)
    }
}

fn cumulated(instance: &Instance) -> Vec<[Vec<i64>; 3]> {
    let n_ranks: usize = instance.features.iter().map(|feature| feature.n_ranks).sum();
    if n_ranks * instance.n_rows > MOST_WEIGHTS {
        return Vec::new();
    }
    let of = |ranks: &[u32], n_ranks: usize| {
        let mut sums = vec![0; n_ranks * instance.n_rows];
        for (i, &rank) in ranks.iter().enumerate() {
            sums[rank as usize * instance.n_rows + instance.rows[i] as usize] += instance.weights[i];
        }
        for k in instance.n_rows..sums.len() {
            sums[k] += sums[k - instance.n_rows];
        }
        sums
    };
    instance
        .features
        .iter()
        .map(|feature| [LOW, TRUE, HIGH].map(|kind| of(&feature.ranks[kind], feature.n_ranks)))
        .collect()
}

/// A cut of the root with both children's tables.
#[derive(Debug)]
pub(crate) struct RootCut<'a> {
    /// What all cuts share.
    pub(crate) prepared: &'a Prepared<'a>,
    /// Labels of the children.
    pub(crate) sets: &'a LabelSets,
    /// Numbers of their pairs.
    pub(crate) pairs: [usize; 2],
    /// Feature of the root.
    pub(crate) feature: usize,
    /// Its cut.
    pub(crate) cut: u32,
    /// The samples.
    pub(crate) zones: &'a Zones,
}

impl RootCut<'_> {
    /// Numbers of the mixtures in which one child is of a type.
    pub(crate) fn mixtures_of(&self, side: usize, same: bool) -> Vec<usize> {
        let of_type = |&k: &usize| self.prepared.mixtures[k].same[side] == same;
        (0..self.prepared.mixtures.len()).filter(of_type).collect()
    }

    /// The table of one child of a type.
    pub(crate) fn table(&self, side: usize, chosen: &[usize]) -> Table {
        let mixtures: Vec<&Mixture> = chosen.iter().map(|&k| &self.prepared.mixtures[k]).collect();
        self.sets.table(self.prepared.instance, &mixtures, side)
    }

    /// The features that one type of child may read.
    pub(crate) fn features(&self, same: bool) -> impl Iterator<Item = usize> + '_ {
        let all = 0..self.prepared.instance.features.len();
        all.filter(move |&f| self.prepared.child(self.feature, f) == Some(same))
    }

    /// The least cost of one child in every mixture, its splits paid for.
    pub(crate) fn child(&self, side: usize) -> Vec<i64> {
        let mut found = vec![NONE; self.prepared.mixtures.len()];
        for same in [false, true] {
            let chosen = self.mixtures_of(side, same);
            let table = self.table(side, &chosen);
            let leaf = start(&table, self.zones);
            let mut lanes: Lanes = if same { [NONE; _] } else { leaf };
            for f in self.features(same) {
                let events = self.prepared.events(self.pairs[side], f);
                let stump = least(events, &table, self.zones, self.prepared.sample_weights(), leaf);
                for (lane, value) in lanes.iter_mut().zip(stump) {
                    *lane = (*lane).min(value + scaled(self.prepared.instance.penalty));
                }
            }
            for (at, &k) in chosen.iter().enumerate() {
                found[k] = lanes[2 * at].min(lanes[2 * at + 1]);
            }
        }
        found
    }

    /// What the band pays at this cut, above the floors.
    pub(crate) fn band(&self) -> i64 {
        let n_rows = self.prepared.instance.n_rows;
        let rows = n_rows..3 * n_rows;
        rows.map(|slot| self.zones.totals[slot] * self.sets.band[slot % n_rows]).sum()
    }
}

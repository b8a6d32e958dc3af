//! The labels that both children may predict, and what every move of a sample costs.
//!
//! The left child predicts labels of a set A = {a, b}, the right child of C. A row k then pays at least
//! `floor = min over A and C of its costs` wherever it goes, and in the band of a root that is off at least
//! `band = max(min over A, min over C)`, as it may go either way. What is above, is shared: for any numbers x, y
//! `max(x, y) >= band + (x - band)^+ / 2 + (y - band)^+ / 2` where `max(x, y) >= band`.

use crate::worst_case::instance::{HIGH, Instance, LOW, TRUE};
use crate::worst_case::shares::{MOST, Mixture, WHOLE};
use crate::worst_case::zones::{BAND_LEFT, BAND_RIGHT, LEFT, N_ZONES, RIGHT};

/// Both orders of the two labels, for each mixture.
pub(crate) const LANES: usize = 2 * MOST;
/// One number for each mixture and order.
pub(crate) type Lanes = [i64; LANES];

/// The mixed costs of one child, by zone and row: of all samples right, and of the moves of `LOW`, `TRUE`, `HIGH`.
#[derive(Debug)]
pub(crate) struct Table {
    /// Cost right of a cut (`N_ZONES * n_rows`).
    pub(crate) start: Vec<Lanes>,
    /// Change by an event (`N_ZONES * n_rows`).
    pub(crate) moves: Vec<[Lanes; 3]>,
}

/// Two labels for each child.
#[derive(Debug)]
pub(crate) struct LabelSets {
    /// Labels of the left and the right child, ascending.
    pub(crate) labels: [[usize; 2]; 2],
    /// Least cost of each row.
    pub(crate) floor: Vec<i64>,
    /// What each row pays in the root's band, above its floor.
    pub(crate) band: Vec<i64>,
    /// Sum of the floors of all samples.
    pub(crate) base: i64,
}

impl LabelSets {
    /// The sets with these labels.
    pub(crate) fn new(instance: &Instance, labels: [[usize; 2]; 2]) -> Self {
        let least = |row: usize, side: usize| labels[side].map(|label| instance.cost(row, label)).into_iter().min();
        let both = |row: usize| [least(row, 0).unwrap_or(0), least(row, 1).unwrap_or(0)];
        let rows = 0..instance.n_rows;
        let floor: Vec<i64> = rows.clone().map(|row| both(row)[0].min(both(row)[1])).collect();
        let band = rows.map(|row| both(row)[0].max(both(row)[1]) - floor[row]).collect();
        let base = (0..instance.n).map(|i| instance.weights[i] * floor[instance.rows[i] as usize]).sum();
        Self { labels, floor, band, base }
    }

    /// The tables of one child for features that give the root's sensor, or another one.
    pub(crate) fn table(&self, instance: &Instance, mixtures: &[&Mixture], side: usize) -> Table {
        let slots = (0..N_ZONES).flat_map(|zone| (0..instance.n_rows).map(move |row| (zone, row)));
        let (start, moves) = slots.map(|(zone, row)| self.slot(instance, mixtures, side, zone, row)).unzip();
        Table { start, moves }
    }

    fn slot(
        &self,
        instance: &Instance,
        mixtures: &[&Mixture],
        side: usize,
        zone: usize,
        row: usize,
    ) -> (Lanes, [Lanes; 3]) {
        let (mut start, mut moves) = ([0; LANES], [[0; LANES]; 3]);
        for (k, mixture) in mixtures.iter().enumerate() {
            for order in 0..2 {
                let lane = 2 * k + order;
                let costs = [order, 1 - order].map(|at| instance.cost(row, self.labels[side][at]));
                for (scenario, share) in &mixture.parts {
                    let paid = |cost: i64| share * self.mixed(scenario.root, side, zone, row, cost) / 2;
                    let [left, right, both] = [costs[0], costs[1], costs[0].max(costs[1])].map(paid);
                    start[lane] += right;
                    if scenario.children[side] {
                        moves[LOW][lane] += both - right;
                        moves[HIGH][lane] += left - both;
                    } else {
                        moves[TRUE][lane] += left - right;
                    }
                }
            }
        }
        (start, moves)
    }

    /// Twice the change of what a child pays when a sample moves between zones of the root.
    pub(crate) fn moved(&self, is_root_off: bool, side: usize, row: usize, zones: (usize, usize), cost: i64) -> i64 {
        let at = |zone: usize| self.mixed(is_root_off, side, zone, row, cost);
        at(zones.1) - at(zones.0)
    }

    /// Twice what a child pays above the floor, in a zone of the root.
    fn mixed(&self, is_root_off: bool, side: usize, zone: usize, row: usize, cost: i64) -> i64 {
        let above = cost - self.floor[row];
        let (own, own_band) = if side == 0 { (LEFT, BAND_LEFT) } else { (RIGHT, BAND_RIGHT) };
        if zone == own || (zone == own_band && !is_root_off) {
            2 * above
        } else if is_root_off && (zone == BAND_LEFT || zone == BAND_RIGHT) {
            (above - self.band[row]).max(0)
        } else {
            0
        }
    }
}

/// All pairs of labels; the one label twice where there is only one.
pub(crate) fn label_pairs(n_labels: usize) -> Vec<[usize; 2]> {
    if n_labels == 1 {
        return vec![[0, 0]];
    }
    (0..n_labels).flat_map(|a| (a + 1..n_labels).map(move |b| [a, b])).collect()
}

/// The cost `WHOLE` times over.
pub(crate) fn scaled(cost: i64) -> i64 {
    WHOLE * cost
}

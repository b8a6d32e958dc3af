//! The samples at a cut of the root: surely left, in its band on either side of the cut, surely right.

use crate::worst_case::instance::{HIGH, Instance, LOW, TRUE};

/// Surely left.
pub(crate) const LEFT: usize = 0;
/// In the band, left by its true reading.
pub(crate) const BAND_LEFT: usize = 1;
/// In the band, right by its true reading.
pub(crate) const BAND_RIGHT: usize = 2;
/// Surely right.
pub(crate) const RIGHT: usize = 3;
/// Number of zones.
pub(crate) const N_ZONES: usize = 4;

/// Zones of all samples at one cut.
#[derive(Debug, Default)]
pub(crate) struct Zones {
    /// `zone * n_rows + row` of each sample.
    pub(crate) slots: Vec<u32>,
    /// Weight in each slot.
    pub(crate) totals: Vec<i64>,
}

impl Zones {
    /// Take the zones of a cut of a feature.
    pub(crate) fn set(&mut self, instance: &Instance, feature: usize, cut: u32) {
        let ranks = &instance.features[feature].ranks;
        self.slots.clear();
        self.totals.clear();
        self.totals.resize(N_ZONES * instance.n_rows, 0);
        for (i, &row) in instance.rows.iter().enumerate() {
            let zone = if ranks[HIGH][i] <= cut {
                LEFT
            } else if ranks[LOW][i] > cut {
                RIGHT
            } else if ranks[TRUE][i] <= cut {
                BAND_LEFT
            } else {
                BAND_RIGHT
            };
            let slot = zone * instance.n_rows + row as usize;
            self.slots.push(slot as u32);
            self.totals[slot] += instance.weights[i];
        }
    }
}

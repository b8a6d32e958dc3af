//! Cuts near a solved one: no tree of theirs is better either, while too few samples have moved.
//!
//! When the cut of the root moves, a sample passes from `RIGHT` through `BAND_RIGHT` and `BAND_LEFT` to `LEFT`, at its
//! lowest, true and highest rank. Whatever the children are, the mixed cost of both and of the band changes then by no
//! less than the sum, over children, of the least change over their labels. What a move can lose so is summed over
//! the samples that have moved; gains are not counted, so that the sum grows with the distance.

use crate::worst_case::cut::{Prepared, RootCut};
use crate::worst_case::instance::Instance;
use crate::worst_case::label_sets::{LabelSets, scaled};
use crate::worst_case::shares::Mixture;
use crate::worst_case::zones::{BAND_LEFT, BAND_RIGHT, LEFT, RIGHT};

/// The zones of a sample, from before its lowest rank to after its highest.
const PATH: [usize; 4] = [RIGHT, BAND_RIGHT, BAND_LEFT, LEFT];
/// All types of children.
const TYPES: [[bool; 2]; 4] = [[false, false], [false, true], [true, false], [true, true]];

/// What moves of one unit of weight may lose: by mixture, for `LOW`, `TRUE`, `HIGH`, by row.
#[derive(Debug)]
pub(crate) struct Losses(Vec<[Vec<i64>; 3]>);

impl Losses {
    /// For samples that pass a cut of the root as it moves up or down.
    pub(crate) fn new(prepared: &Prepared<'_>, sets: &LabelSets, is_up: bool) -> Self {
        let instance = prepared.instance;
        let of = |mixture: &Mixture, kind: usize, row: usize| {
            let (from, to) = if is_up { (kind, kind + 1) } else { (kind + 1, kind) };
            (-sets.least_change(instance, mixture, row, PATH[from], PATH[to])).max(0)
        };
        let rows = 0..instance.n_rows;
        let each = |mixture: &Mixture| [0, 1, 2].map(|kind| rows.clone().map(|row| of(mixture, kind, row)).collect());
        Self(prepared.mixtures.iter().map(each).collect())
    }
}

impl LabelSets {
    /// The least change of what both children and the band pay for a unit of weight that moves from zone to zone.
    fn least_change(&self, instance: &Instance, mixture: &Mixture, row: usize, from: usize, to: usize) -> i64 {
        let band = |zone: usize| if zone == BAND_LEFT || zone == BAND_RIGHT { self.band[row] } else { 0 };
        let mut least = mixture.root_share() * (band(to) - band(from));
        for side in 0..2 {
            for is_off in [false, true] {
                let change = |label: usize| -> i64 {
                    let cost = instance.cost(row, label);
                    let parts = mixture.parts.iter().filter(|(scenario, _)| scenario.children[side] == is_off);
                    parts.map(|(s, share)| share * self.moved(s.root, side, row, (from, to), cost) / 2).sum()
                };
                least += change(self.labels[side][0]).min(change(self.labels[side][1]));
            }
        }
        least
    }
}

/// The lowest and the highest cut, within an interval, up to which a solved cut closes all others.
///
/// `target` is what a bound, `WHOLE` times over, must exceed; `losses` are those of moves down and up.
pub(crate) fn reach(
    root: &RootCut<'_>,
    losses: &[Losses; 2],
    costs: [&[i64]; 2],
    target: i64,
    (lo, hi): (u32, u32),
) -> (u32, u32) {
    let fixed = scaled(root.sets.base + root.prepared.instance.penalty);
    let band = root.band();
    let mixtures = root.prepared.mixtures.iter().enumerate();
    let bounds: Vec<i64> =
        mixtures.map(|(k, mixture)| fixed + mixture.root_share() * band + costs[0][k] + costs[1][k]).collect();
    let furthest = |is_up: bool| {
        let losses = &losses[usize::from(is_up)];
        let (mut sure, mut open) = (0, if is_up { hi - root.cut } else { root.cut - lo } + 1);
        while open - sure > 1 {
            let middle = sure + (open - sure) / 2;
            let end = if is_up { root.cut + middle } else { root.cut - middle };
            if is_closed(root, &bounds, losses, target, end) { sure = middle } else { open = middle }
        }
        if is_up { root.cut + sure } else { root.cut - sure }
    };
    (furthest(false), furthest(true))
}

/// Whether all cuts from the solved one to `end` are closed.
fn is_closed(root: &RootCut<'_>, bounds: &[i64], losses: &Losses, target: i64, end: u32) -> bool {
    let Some(moved) = root.prepared.moved(root.feature, root.cut.min(end), root.cut.max(end)) else { return false };
    let lost = |k: usize| -> i64 {
        let pairs = losses.0[k].iter().zip(&moved);
        pairs.map(|(losses, weights)| losses.iter().zip(weights).map(|(loss, weight)| loss * weight).sum::<i64>()).sum()
    };
    let mixtures = &root.prepared.mixtures;
    TYPES.iter().all(|same| (0..mixtures.len()).any(|k| mixtures[k].same == *same && bounds[k] - lost(k) > target))
}

//! A new pair of features for a plane: all angles about one sample.

use crate::planes::plane_search::PlaneSearch;
use crate::tree::allowance::Allowance;
use crate::tree::view::NodeView;

/// One new pair in so many keeps none of the features that are read now.
const FRESH_ONE_IN: u32 = 3;

impl PlaneSearch<'_> {
    /// Try the best line over a pair of features through a random sample, and its offset; keep it when it is no worse.
    ///
    /// The lines `z_f + d z_g = const` through the sample, over all d, are all angles but one.
    pub(crate) fn try_pair(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) {
        let Some([f, g]) = self.random_pair(allowance, rng) else {
            return;
        };
        let scale = [f, g].map(|f| 1.0 / self.prepared.deviations[f]);
        let anchor = self.prepared.values.row(view.samples[rng.usize(..view.samples.len())]);
        let (floor, before) = (self.gain(), (self.plane.clone(), self.tally.clone()));
        self.set(&[(f as u32, scale[0])], scale[0] * anchor[f]);
        self.place(view);
        let patience = std::mem::replace(&mut self.patience, i64::MAX / 2);
        self.turn_about(view, &[(g as u32, scale[1])], scale[1] * anchor[g], rng);
        self.patience = patience;
        self.shift(view, rng);
        if !self.tally.is_large_enough() || self.gain() < floor {
            (self.plane, self.tally) = before;
        }
    }

    /// Two features that may be read together, one of them mostly read now.
    pub(crate) fn random_pair(&self, allowance: &Allowance, rng: &mut fastrand::Rng) -> Option<[usize; 2]> {
        let p = self.prepared.problem.p;
        let support = self.support();
        let f = match rng.u32(..FRESH_ONE_IN) {
            0 => rng.usize(..p),
            _ => support.get(rng.usize(..support.len().max(1))).map_or(0, |&f| f as usize),
        };
        let g = rng.usize(..p);
        let pair = [f.min(g) as u32, f.max(g) as u32];
        (f != g && allowance.admits(&pair)).then_some([f, g])
    }
}

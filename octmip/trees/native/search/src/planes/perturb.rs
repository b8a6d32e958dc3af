//! The perturbation of a plane at random.

use crate::planes::plane_search::PlaneSearch;
use crate::planes::random::normal;
use crate::tree::view::NodeView;

impl PlaneSearch<'_> {
    /// Perturb normal and offset by a random share of their own size; whether leaves stay large enough.
    pub(crate) fn perturb(&mut self, view: &NodeView, rng: &mut fastrand::Rng) -> bool {
        let terms = self.terms();
        let deviations = &self.prepared.deviations;
        let size = terms.iter().map(|&(f, c)| (c * deviations[f as usize]).powi(2)).sum::<f64>();
        let scale = (size / terms.len().max(1) as f64).sqrt() * 10_f64.powf(rng.f64() * 2.0 - 2.0);
        let anchor = view.samples[rng.usize(..view.samples.len())];
        let perturbed: Vec<(u32, f64)> =
            terms.iter().map(|&(f, c)| (f, c + scale * normal(rng) / deviations[f as usize])).collect();
        let values = &self.prepared.values;
        let offset = self.plane.offset + values.project(&perturbed, anchor) - values.project(&terms, anchor);
        self.set(&perturbed, offset + scale * normal(rng));
        self.place(view);
        self.tally.is_large_enough()
    }
}

//! Logistic fits: a plane fitted to the sides that the samples prefer.

use crate::logistic::regression::{PreferredSide, fit};
use crate::planes::plane_search::PlaneSearch;
use crate::tree::allowance::Allowance;
use crate::tree::view::NodeView;

/// Samples that a logistic fit looks at.
const MOST_FITTED_SAMPLES: usize = 600;
/// Weight of the ridge, in units of the mean loss; the least ones part few samples without an error.
pub(crate) const RIDGES: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-6, 1e-8];

impl PlaneSearch<'_> {
    /// Fit a logistic regression to the sides that the samples prefer, and search between it and the present plane.
    pub(crate) fn fit_logistic(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) {
        let sides = self.preferred_sides(view, rng);
        let features = self.some_features(allowance, rng);
        let ridge = RIDGES[rng.usize(..RIDGES.len())];
        let supervisor = self.supervisor;
        let fitted = fit(&self.prepared.values, &sides, &features, ridge, &|| supervisor.goes_on());
        let Some((normal, offset)) = fitted else {
            return;
        };
        let terms: Vec<(u32, f64)> = features.iter().copied().zip(normal).filter(|term| term.1 != 0.0).collect();
        // some_features holds the present support, so that the planes between the two read no more than it.
        self.turn_about(view, &terms, offset, rng);
        self.try_plane(view, &terms, offset, rng);
    }

    /// The samples that exactly one side serves best, with the leaves' present classes.
    pub(crate) fn preferred_sides(&self, view: &NodeView, rng: &mut fastrand::Rng) -> Vec<PreferredSide> {
        let labels: Vec<u32> = (0..view.n_slots() as u32).map(|slot| self.tally.label(slot)).collect();
        let class = |side: usize, j: usize| labels[view.members[j].slots[side] as usize] as usize;
        let prices = &self.prepared.prices;
        let of_sample = |(j, &sample): (usize, &u32)| {
            let left_is_better = prices.gain_of(sample, class(0, j)) - prices.gain_of(sample, class(1, j));
            let weight = left_is_better.abs() as f64;
            (weight > 0.0).then_some(PreferredSide { sample, goes_right: left_is_better < 0, weight })
        };
        let mut sides: Vec<PreferredSide> = view.samples.iter().enumerate().filter_map(of_sample).collect();
        if sides.len() > MOST_FITTED_SAMPLES {
            rng.shuffle(&mut sides);
            sides.truncate(MOST_FITTED_SAMPLES);
        }
        sides
    }
}

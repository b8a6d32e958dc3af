//! Leaning on logistic regression: a plane fitted to where each sample would rather go.

use crate::search::logistic::regression::{Pull, fit};
use crate::search::planes::plane_search::PlaneAtWork;
use crate::search::tree::allowance::Room;
use crate::search::tree::view::View;

/// Samples that a logistic fit looks at.
const MOST_PULLS: usize = 600;
/// Weight of the ridge, in units of the mean loss; the least ones part few samples without an error.
pub(crate) const RIDGES: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-6, 1e-8];

impl PlaneAtWork<'_> {
    /// Fit a logistic regression to what every sample would rather do, and search between it and the present plane.
    pub(crate) fn lean_on_logistic(&mut self, view: &View, room: &Room, rng: &mut fastrand::Rng) {
        let pulls = self.pulls(view, rng);
        let features = self.some_features(room, rng);
        let ridge = RIDGES[rng.usize(..RIDGES.len())];
        let supervisor = self.supervisor;
        let fitted = fit(&self.ground.values, &pulls, &features, ridge, &|| supervisor.goes_on());
        let Some((normal, offset)) = fitted else {
            return;
        };
        let terms: Vec<(u32, f64)> = features.iter().copied().zip(normal).filter(|term| term.1 != 0.0).collect();
        // some_features holds the present support, so that the planes between the two read no more than it.
        self.turn_about(view, &terms, offset, rng);
        self.try_plane(view, &terms, offset, rng);
    }

    /// The samples that exactly one side serves best, with the leaves' present classes.
    pub(crate) fn pulls(&self, view: &View, rng: &mut fastrand::Rng) -> Vec<Pull> {
        let labels: Vec<u32> = (0..view.n_slots() as u32).map(|slot| self.tally.label(slot)).collect();
        let class = |side: usize, j: usize| labels[view.members[j].slots[side] as usize] as usize;
        let prices = &self.ground.prices;
        let of_sample = |(j, &sample): (usize, &u32)| {
            let left_is_better = prices.gain_of(sample, class(0, j)) - prices.gain_of(sample, class(1, j));
            let weight = left_is_better.abs() as f64;
            (weight > 0.0).then_some(Pull { sample, goes_right: left_is_better < 0, weight })
        };
        let mut pulls: Vec<Pull> = view.samples.iter().enumerate().filter_map(of_sample).collect();
        if pulls.len() > MOST_PULLS {
            rng.shuffle(&mut pulls);
            pulls.truncate(MOST_PULLS);
        }
        pulls
    }
}

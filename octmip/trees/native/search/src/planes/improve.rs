//! One round of moves on the plane of a node: lines of many kinds in turn.

use crate::planes::plane_search::PlaneSearch;
use crate::tree::allowance::Allowance;
use crate::tree::view::NodeView;

/// Random directions that one visit tries.
const RANDOM_DIRECTIONS: usize = 4;
/// Features that one visit tries one by one.
const MOST_FEATURES: usize = 24;
/// Pairs of features that one visit tries.
const MOST_PAIRS: usize = 6;

impl PlaneSearch<'_> {
    /// Try lines of many kinds in turn; the gain never falls.
    pub(crate) fn improve(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) {
        if rng.bool() {
            self.fit_logistic(view, allowance, rng);
        }
        self.shift(view, rng);
        let mut features: Vec<u32> = (0..self.prepared.problem.p as u32).collect();
        rng.shuffle(&mut features);
        features.truncate(MOST_FEATURES);
        for &f in &features {
            if !self.supervisor.goes_on() {
                return;
            }
            if allowance.admits(&self.support_with(f)) {
                self.turn(view, &[(f, 1.0)], rng);
            }
        }
        for _ in 0..RANDOM_DIRECTIONS {
            if !self.supervisor.goes_on() {
                return;
            }
            let direction = self.random_direction(allowance, rng);
            self.turn(view, &direction, rng);
        }
        if features.iter().any(|&f| !allowance.admits(&self.support_with(f))) {
            self.swap_features(view, allowance, rng);
        }
        if self.prepared.split_size() == 2 && self.supervisor.goes_on() {
            (0..MOST_PAIRS).for_each(|_| self.try_pair(view, allowance, rng));
        }
    }
}

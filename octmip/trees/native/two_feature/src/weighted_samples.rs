//! The samples of a problem with labels, weights and costs.

use crate::geometry::line::Line;
use crate::geometry::plane::Plane;
use crate::loss::{INFEASIBLE, Loss};
use crate::switches::Switches;

/// The samples of a problem with labels and weights, which may be others than the problem's.
#[derive(Debug, Clone, Copy)]
pub struct WeightedSamples<'a> {
    /// Coordinates.
    pub plane: &'a Plane,
    /// Class of each sample.
    pub labels: &'a [u32],
    /// Weight of each sample.
    pub weights: &'a [i64],
    /// Costs and prices.
    pub loss: &'a Loss,
    /// Prunes and bounds that are on.
    pub switches: Switches,
}

impl WeightedSamples<'_> {
    /// Class weights and number of some samples.
    pub(crate) fn tally(&self, ids: &[u32]) -> Vec<i64> {
        let mut tally = vec![0; self.loss.lanes()];
        for &i in ids {
            self.add(&mut tally, i);
        }
        tally
    }

    /// Count one sample.
    #[inline]
    pub(crate) fn add(&self, tally: &mut [i64], i: u32) {
        tally[self.labels[i as usize] as usize] += self.weights[i as usize];
        tally[self.loss.k] += 1;
    }

    /// Price of a split over these features.
    pub(crate) fn price(&self, features: (usize, usize)) -> i64 {
        self.loss.prices[usize::from(features.1 != self.plane.p)]
    }

    /// Cost of a line with the best label on both sides.
    pub(crate) fn cost_of(&self, line: &Line, ids: &[u32], total: &[i64], need: i64) -> i64 {
        let mut left = vec![0; self.loss.lanes()];
        for &i in ids {
            if line.sends_left(self.plane, i) {
                self.add(&mut left, i);
            }
        }
        let right = difference(total, &left);
        let cost = self.loss.sides(&left, &right, need);
        (cost + self.price(line.features)).min(INFEASIBLE)
    }
}

/// The difference of two tallies.
pub(crate) fn difference(a: &[i64], b: &[i64]) -> Vec<i64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

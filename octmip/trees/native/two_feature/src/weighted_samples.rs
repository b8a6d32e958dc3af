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
        self.cost_of_left(line.features, &self.left_of(line, ids), total, need)
    }

    /// Class weights and number of the samples that a line sends left.
    pub(crate) fn left_of(&self, line: &Line, ids: &[u32]) -> Vec<i64> {
        let (x, y) = (self.plane.column(line.features.0), self.plane.column(line.features.1));
        let mut left = vec![0; self.loss.lanes()];
        for &i in ids {
            // `sends_left`, without a branch: a good line sends about half of the samples left.
            let goes_left = i64::from(x[i as usize] + line.t * y[i as usize] <= line.r);
            left[self.labels[i as usize] as usize] += goes_left * self.weights[i as usize];
            left[self.loss.k] += goes_left;
        }
        left
    }

    /// Cost of a split over these features with the best label on both sides, by what goes left.
    pub(crate) fn cost_of_left(&self, features: (usize, usize), left: &[i64], total: &[i64], need: i64) -> i64 {
        let right = difference(total, left);
        let cost = self.loss.sides(left, &right, need);
        (cost + self.price(features)).min(INFEASIBLE)
    }
}

/// The sum of two tallies.
pub(crate) fn sum(a: &[i64], b: &[i64]) -> Vec<i64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// The difference of two tallies.
pub(crate) fn difference(a: &[i64], b: &[i64]) -> Vec<i64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

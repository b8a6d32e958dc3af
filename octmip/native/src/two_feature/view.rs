//! Lines, and the samples as a search for lines sees them.

use super::cell::EPS;
use super::loss::{INFEASIBLE, Loss};
use super::plane::Plane;
use super::switches::Switches;

/// The line `x_f + t x_g = r` in scaled coordinates; samples at or below it go left.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Line {
    pub features: (usize, usize),
    pub t: f64,
    pub r: f64,
}

impl Line {
    /// Whether a sample goes left.
    #[inline]
    pub fn sends_left(&self, plane: &Plane, i: u32) -> bool {
        let (f, g) = self.features;
        plane.column(f)[i as usize] + self.t * plane.column(g)[i as usize] <= self.r
    }

    /// Whether the line keeps clear of some samples by more than rounding can matter.
    pub fn is_clear_of(&self, plane: &Plane, ids: &[u32]) -> bool {
        let (x, y) = (plane.column(self.features.0), plane.column(self.features.1));
        let distance = |i: u32| (x[i as usize] + self.t * y[i as usize] - self.r).abs();
        ids.iter().all(|&i| distance(i) > EPS)
    }
}

/// The samples of a problem as a stump sees them: labels and weights may be others than the problem's.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Coordinates.
    pub plane: &'a Plane,
    /// Class of each sample.
    pub labels: &'a [u32],
    /// Weight of each sample.
    pub weights: &'a [i64],
    /// Costs and prices.
    pub loss: &'a Loss,
    /// What to do without.
    pub switches: Switches,
}

impl View<'_> {
    /// Class weights and number of some samples.
    pub fn tally(&self, ids: &[u32]) -> Vec<i64> {
        let mut tally = vec![0; self.loss.lanes()];
        for &i in ids {
            self.add(&mut tally, i);
        }
        tally
    }

    /// Count one sample.
    #[inline]
    pub fn add(&self, tally: &mut [i64], i: u32) {
        tally[self.labels[i as usize] as usize] += self.weights[i as usize];
        tally[self.loss.k] += 1;
    }

    /// Price of a split over these features.
    pub fn price(&self, features: (usize, usize)) -> i64 {
        self.loss.prices[usize::from(features.1 != self.plane.p)]
    }

    /// What a line costs with the best label on both sides.
    pub fn cost_of(&self, line: &Line, ids: &[u32], total: &[i64], need: i64) -> i64 {
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

pub(super) fn difference(a: &[i64], b: &[i64]) -> Vec<i64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

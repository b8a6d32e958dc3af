//! The samples of a problem as points, and those on either side of a region.

use super::feature::Feature;
use super::plane::Plane;
use super::region::{EPS, Region};
use crate::problem::Problem;

/// The samples of a problem, by feature; last comes a column of zeros for axis-aligned splits.
pub struct Points {
    features: Vec<Feature>,
}

impl Points {
    /// The samples of a problem; without hyperplane splits in it, ranks serve as values.
    pub fn new(q: &Problem) -> Self {
        let ranks = || q.ranks.iter().map(|&rank| f64::from(rank)).collect();
        let values: Vec<f64> = q.values_by_feature().unwrap_or_else(ranks);
        let mut features: Vec<Feature> = values.chunks_exact(q.n).map(Feature::new).collect();
        features.push(Feature::new(&vec![0.0; q.n]));
        Self { features }
    }

    /// The coordinates of a feature, by sample.
    pub(super) fn coordinates(&self, f: usize) -> &[f64] {
        &self.features[f].coordinates
    }

    /// The plane of two features.
    pub fn plane(&self, (f, g): (usize, usize)) -> Plane<'_> {
        Plane { x: &self.features[f], y: &self.features[g] }
    }

    /// The samples left of all lines of a region, those between, and those right of all of them.
    pub fn sorted(&self, (f, g): (usize, usize), region: &Region) -> [Vec<u32>; 3] {
        let mut sorted = [const { Vec::new() }; 3];
        for (i, (x, y)) in self.coordinates(f).iter().zip(self.coordinates(g)).enumerate() {
            let value = region.t.map(|t| x + t * y);
            let is_left = (0..2).all(|e| value[e] <= region.low[e] - EPS);
            let is_right = (0..2).all(|e| value[e] >= region.high[e] + EPS);
            sorted[if is_left { 0 } else { 1 + usize::from(is_right) }].push(i as u32);
        }
        sorted
    }
}

#[cfg(test)]
mod tests {
    use super::super::dichotomies::MOST_ON_LINE;
    use super::*;
    use std::cmp::Ordering;

    fn points(x: &[f64], y: &[f64]) -> Points {
        Points { features: vec![Feature::new(x), Feature::new(y)] }
    }

    #[test]
    fn the_dichotomies_of_three_points_are_those_of_their_orders() {
        let general = points(&[0.0, 0.5, 0.25], &[0.0, 0.0, 0.5]);
        // In coordinates: order 0 2 1 up to t = .5, where 2 passes 1: four prefixes, and one more beyond.
        assert_eq!(general.plane((0, 1)).dichotomies(&[0, 1, 2], -0.25, 0.25).len(), 4);
        assert_eq!(general.plane((0, 1)).dichotomies(&[0, 1, 2], -0.25, 1.0).len(), 5);
        // On one line at t = -1/2: before it 2 1 0 in order of value, after it 0 1 2.
        let line = points(&[0.0, 0.25, 0.5], &[0.0, 0.25, 0.5]);
        assert_eq!(line.plane((0, 1)).dichotomies(&[0, 1, 2], -1.5, 1.0).len(), 6);
    }

    #[test]
    fn order_and_turn_are_exact_over_the_whole_range_of_numbers() {
        let far = points(&[1e300, 1.0, 2.0, 3.0, -5e-324], &[0.0, 5e-324, 1e-323, 1.5e-323, -1e300]);
        let plane = far.plane((0, 1));
        assert!(!plane.has_exact_coordinates());
        assert_eq!(plane.turn(1, 2, 3), Ordering::Equal);
        assert_ne!(plane.turn(4, 2, 3), Ordering::Equal);
        assert_eq!(plane.order_at(0.0, 1, 2), Ordering::Less);
        assert_eq!(plane.order_at(0.0, 4, 1), Ordering::Less);
        // The second feature in its unit of 2^997 is much smaller than the first in the same unit.
        assert_eq!(plane.order_at(-1.0, 2, 3), Ordering::Less);
    }

    #[test]
    fn the_least_numbers_have_coordinates_like_all_others() {
        let tiny = points(&[5e-324, 1e-323, 1.5e-323], &[-5e-324, 0.0, 0.0]);
        assert_eq!(tiny.coordinates(0), [0.0, 0.25, 0.5]);
        assert_eq!(tiny.coordinates(1), [-0.5, 0.0, 0.0]);
        assert_eq!((tiny.features[0].exponent, tiny.features[1].exponent), (-1072, -1073));
    }

    #[test]
    fn many_points_on_one_line_come_apart_in_their_order() {
        let numbers: Vec<f64> = (0..100).map(f64::from).collect();
        let line = points(&numbers, &numbers);
        let ids: Vec<u32> = (0..100).collect();
        let plane = line.plane((0, 1));
        assert_eq!(plane.end_points(&ids, 48).map(|points| points.len()), Some(100));
        assert_eq!(plane.dichotomies(&ids, -2.0, 1.0).len(), 200);
    }

    #[test]
    fn more_points_on_one_line_than_memory_has_room_for_are_not_parted() {
        let n = MOST_ON_LINE as u32 + 1;
        let numbers: Vec<f64> = (0..n).map(f64::from).collect();
        let line = points(&numbers, &numbers);
        let ids: Vec<u32> = (0..n).collect();
        assert_eq!(line.plane((0, 1)).end_points(&ids[1..], 48).map(|points| points.len()), Some(MOST_ON_LINE));
        assert_eq!(line.plane((0, 1)).end_points(&ids, 48), None);
    }
}

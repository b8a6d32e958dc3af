//! Where the samples lie: coordinates for cells, and exact answers about the values as given.

use std::cmp::Ordering;

use super::signs::{exact_sign, quick_sign};
use super::{Cell, EPS};
use crate::problem::Problem;

/// Numbers below this (other than 0) could underflow in a product of two and its rounding.
const LEAST: f64 = 1e-135;
/// So many points on one line are parted in every way: each way is a list of as many entries, in all half a gigabyte.
const MOST_ON_LINE: usize = 1 << 14;
/// A sum of products of coordinates beyond this has the sign that it shows: rounding is below 1e-13.
const CERTAIN: f64 = 1e-12;

/// The samples of a problem, by feature; last comes a column of zeros for axis-aligned splits.
pub struct Points {
    features: Vec<Feature>,
}

/// The values of one feature, and their coordinates.
///
/// The feature is moved by a constant and divided by a power of two, which keeps the lines. The difference of a value
/// and the constant is rounded at most once and no larger than the value, so a coordinate is wrong by 2^-53 at most.
pub(super) struct Feature {
    values: Vec<f64>,
    /// All within -1 and 1.
    pub(super) coordinates: Vec<f64>,
    /// A coordinate is the value, moved, divided by 2 to this power.
    exponent: i32,
    /// No coordinate is rounded, and none is so small that a product of two underflows.
    is_exact: bool,
}

impl Feature {
    fn new(values: &[f64]) -> Self {
        let least = values.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let most = values.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        // Between zero and all the values, in units of the last place of the largest.
        let (near, far) = if least > 0.0 { (least, most) } else { (most.min(0.0), least) };
        // None is finer than the least number: there a unit would underflow to 0.
        let unit = (binade(far) * f64::EPSILON).max(f64::from_bits(1));
        let origin = if near == 0.0 { 0.0 } else { (near / unit).trunc() * unit };
        let moved: Vec<f64> = values.iter().map(|v| v - origin).collect();
        let half = binade(moved.iter().fold(0.0, |a: f64, b| a.max(b.abs())));
        let coordinates: Vec<f64> = moved.iter().map(|d| d / half / 2.0).collect();
        let is_kept = |((v, d), u): ((&f64, &f64), &f64)| {
            let back = d - v;
            (v - (d - back)) + (-origin - back) == 0.0
                && u * 2.0 * half == *d
                && (*u == 0.0 || (LEAST..1.0).contains(&u.abs()))
        };
        let is_exact = values.iter().zip(&moved).zip(&coordinates).all(is_kept);
        Self { values: values.to_vec(), coordinates, exponent: exponent_of(half) + 1, is_exact }
    }
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

    pub(super) fn coordinates(&self, f: usize) -> &[f64] {
        &self.features[f].coordinates
    }

    /// The plane of two features.
    pub fn plane(&self, (f, g): (usize, usize)) -> Plane<'_> {
        Plane { x: &self.features[f], y: &self.features[g] }
    }

    /// The samples left of all lines of a cell, those between, and those right of all of them.
    pub fn sorted(&self, (f, g): (usize, usize), cell: &Cell) -> [Vec<u32>; 3] {
        let mut sorted = [const { Vec::new() }; 3];
        for (i, (x, y)) in self.coordinates(f).iter().zip(self.coordinates(g)).enumerate() {
            let value = cell.t.map(|t| x + t * y);
            let is_left = (0..2).all(|e| value[e] <= cell.low[e] - EPS);
            let is_right = (0..2).all(|e| value[e] >= cell.high[e] + EPS);
            sorted[if is_left { 0 } else { 1 + usize::from(is_right) }].push(i as u32);
        }
        sorted
    }
}

/// Two features; what it says of points and lines is exact, whatever the values.
#[derive(Clone, Copy)]
pub struct Plane<'a> {
    x: &'a Feature,
    y: &'a Feature,
}

impl Plane<'_> {
    fn has_exact_coordinates(&self) -> bool {
        self.x.is_exact && self.y.is_exact
    }

    pub(super) fn is_same(&self, i: u32, j: u32) -> bool {
        let (i, j) = (i as usize, j as usize);
        self.x.values[i] == self.x.values[j] && self.y.values[i] == self.y.values[j]
    }

    /// The order by the first feature, then by the second: along a line that is the order on it.
    pub(super) fn along(&self, i: u32, j: u32) -> Ordering {
        by_value(self.x, i, j).then(self.upward(i, j))
    }

    /// The order by the second feature.
    pub(super) fn upward(&self, i: u32, j: u32) -> Ordering {
        by_value(self.y, i, j)
    }

    /// The order of two samples by their values x + t y, in coordinates.
    pub(super) fn order_at(&self, t: f64, i: u32, j: u32) -> Ordering {
        let (x, y) = (&self.x.coordinates, &self.y.coordinates);
        let (i, j) = (i as usize, j as usize);
        let rounded = (x[i] - x[j]) + t * (y[i] - y[j]);
        if rounded.abs() > CERTAIN {
            return sign_of(rounded);
        }
        if self.has_exact_coordinates() && (t == 0.0 || t.abs() >= LEAST) {
            return sign_of(quick_sign([(x[i], 1.0), (-x[j], 1.0), (t, y[i]), (-t, y[j])]));
        }
        // Coordinates are values moved and divided by 2^exponent: times both powers, the constants cancel.
        let (x, y) = (self.x, self.y);
        let (one, other) = (y.exponent, x.exponent);
        exact_sign(&[
            (x.values[i], 1.0, one),
            (-x.values[j], 1.0, one),
            (y.values[i], t, other),
            (-y.values[j], t, other),
        ])
    }

    /// On which side of the line from `a` to `b` the point `c` lies: `Greater` is the left hand, `Equal` on it.
    pub(super) fn turn(&self, a: u32, b: u32, c: u32) -> Ordering {
        let six = |x: &[f64], y: &[f64]| {
            let at = |i: u32| (x[i as usize], y[i as usize]);
            let ((xa, ya), (xb, yb), (xc, yc)) = (at(a), at(b), at(c));
            [(xb, yc), (-xb, ya), (-xa, yc), (-yb, xc), (yb, xa), (ya, xc)]
        };
        let products = six(&self.x.coordinates, &self.y.coordinates);
        let rounded: f64 = products.iter().map(|(a, b)| a * b).sum();
        if rounded.abs() > CERTAIN {
            sign_of(rounded)
        } else if self.has_exact_coordinates() {
            sign_of(quick_sign(products))
        } else {
            exact_sign(&six(&self.x.values, &self.y.values).map(|(a, b)| (a, b, 0)))
        }
    }

    /// Whether two samples change places, or meet, somewhere in t0 <= t <= t1; `b` is above `a`.
    fn is_crossing(&self, a: u32, b: u32, t0: f64, t1: f64) -> bool {
        if self.has_exact_coordinates() {
            let (x, y) = (&self.x.coordinates, &self.y.coordinates);
            let t = -(x[b as usize] - x[a as usize]) / (y[b as usize] - y[a as usize]);
            // Rounding moves t by less than 1e-14.
            return t0 - CERTAIN <= t && t <= t1 + CERTAIN;
        }
        let (first, last) = (self.order_at(t0, a, b), self.order_at(t1, a, b));
        first != last || first == Ordering::Equal
    }

    /// Whether all these points lie on one line.
    pub(super) fn is_line(&self, points: &[u32]) -> bool {
        points.len() < 3 || points[2..].iter().all(|&c| self.turn(points[0], points[1], c) == Ordering::Equal)
    }

    /// One sample of each different point, the first; None if these are more than `most`.
    pub(super) fn few_points(&self, ids: &[u32], most: usize) -> Option<Vec<u32>> {
        let mut points: Vec<u32> = Vec::new();
        for &i in ids {
            if !points.iter().any(|&p| self.is_same(p, i)) {
                if points.len() == most {
                    return None;
                }
                points.push(i);
            }
        }
        Some(points)
    }

    /// One sample of each different point, the first, if a line through them can be turned in few ways: not more than
    /// `most` points, or all of them on one line and no more than `MOST_ON_LINE`.
    pub fn end_points(&self, ids: &[u32], most: usize) -> Option<Vec<u32>> {
        let mut points = ids.to_vec();
        points.sort_by(|&i, &j| self.along(i, j).then(i.cmp(&j)));
        points.dedup_by(|i, j| self.is_same(*i, *j));
        points.sort_unstable();
        let is_line = || points.len() <= MOST_ON_LINE && self.is_line(&points);
        (points.len() <= most || is_line()).then_some(points)
    }

    /// For each sample the place of its point.
    pub fn places(&self, points: &[u32], ids: &[u32]) -> Vec<usize> {
        ids.iter().map(|&i| points.iter().position(|&p| self.is_same(p, i)).unwrap_or(0)).collect()
    }

    /// All ways in which a line x + t y = r with t0 <= t <= t1 can part different points: true = at or below it.
    ///
    /// Take a way and the values of t that allow it, an interval. If t0 is in it, the way is a prefix of the points in
    /// their order at t0. If not, it begins where a point below and one above meet in value: there the line runs
    /// through both, the points off it go where they lie, and those on it come apart just after by y, the smaller
    /// below. Points on one line all meet at one t: their order at t1 is the other one.
    pub fn ways(&self, points: &[u32], t0: f64, t1: f64) -> Vec<Vec<bool>> {
        let m = points.len();
        let order_at = |t: f64| {
            let mut order: Vec<usize> = (0..m).collect();
            order.sort_by(|&i, &j| {
                self.order_at(t, points[i], points[j]).then_with(|| self.upward(points[i], points[j]))
            });
            order
        };
        let mut found: Vec<Vec<bool>> = Vec::new();
        let mut add_prefixes = |way: &[bool], order: &[usize]| {
            let mut way = way.to_vec();
            found.push(way.clone());
            for &k in order {
                way[k] = true;
                found.push(way.clone());
            }
        };
        add_prefixes(&vec![false; m], &order_at(t0));
        if self.is_line(points) {
            add_prefixes(&vec![false; m], &order_at(t1));
        } else {
            for (a, b) in (0..m).flat_map(|a| (0..m).map(move |b| (a, b))) {
                let is_upward = self.upward(points[a], points[b]) == Ordering::Less;
                if is_upward && self.is_crossing(points[a], points[b], t0, t1) {
                    let turns: Vec<_> = points.iter().map(|&c| self.turn(points[a], points[b], c)).collect();
                    let mut on: Vec<usize> = (0..m).filter(|&k| turns[k] == Ordering::Equal).collect();
                    on.sort_by(|&i, &j| self.upward(points[i], points[j]));
                    let below: Vec<bool> = turns.iter().map(|&turn| turn == Ordering::Greater).collect();
                    add_prefixes(&below, &on);
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn by_value(feature: &Feature, i: u32, j: u32) -> Ordering {
    feature.values[i as usize].partial_cmp(&feature.values[j as usize]).unwrap_or(Ordering::Equal)
}

fn sign_of(number: f64) -> Ordering {
    number.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

/// The largest power of two up to the size of a number (1 for 0).
fn binade(number: f64) -> f64 {
    let bits = number.abs().to_bits();
    match bits {
        0 => 1.0,
        denormal if denormal < 1 << 52 => f64::from_bits(1 << denormal.ilog2()),
        _ => f64::from_bits(bits & (0x7ff << 52)),
    }
}

/// The exponent of a power of two.
fn exponent_of(power: f64) -> i32 {
    let bits = power.to_bits();
    if bits < 1 << 52 { bits.ilog2() as i32 - 1074 } else { (bits >> 52) as i32 - 1023 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(x: &[f64], y: &[f64]) -> Points {
        Points { features: vec![Feature::new(x), Feature::new(y)] }
    }

    #[test]
    fn the_ways_of_three_points_are_those_of_their_orders() {
        let general = points(&[0.0, 0.5, 0.25], &[0.0, 0.0, 0.5]);
        // In coordinates: order 0 2 1 up to t = .5, where 2 passes 1: four prefixes, and one more beyond.
        assert_eq!(general.plane((0, 1)).ways(&[0, 1, 2], -0.25, 0.25).len(), 4);
        assert_eq!(general.plane((0, 1)).ways(&[0, 1, 2], -0.25, 1.0).len(), 5);
        // On one line at t = -1/2: before it 2 1 0 in order of value, after it 0 1 2.
        let line = points(&[0.0, 0.25, 0.5], &[0.0, 0.25, 0.5]);
        assert_eq!(line.plane((0, 1)).ways(&[0, 1, 2], -1.5, 1.0).len(), 6);
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
        assert_eq!(plane.ways(&ids, -2.0, 1.0).len(), 200);
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

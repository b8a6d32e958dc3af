//! Exact answers about points and lines of two features.

use std::cmp::Ordering;

use super::feature::{Feature, LEAST};
use crate::numbers::signs::{exact_sign, quick_sign};

/// A sum of products of coordinates beyond this has the sign that it shows: rounding is below 1e-13.
const CERTAIN: f64 = 1e-12;

/// The plane of two features: exact answers about points and lines, whatever the values.
#[derive(Clone, Copy)]
pub struct Plane<'a> {
    pub(super) x: &'a Feature,
    pub(super) y: &'a Feature,
}

impl Plane<'_> {
    /// Whether coordinates stand for the values without rounding.
    pub(super) fn has_exact_coordinates(&self) -> bool {
        self.x.is_exact && self.y.is_exact
    }

    /// Whether two samples are one point.
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

    /// The side of the line from `a` to `b` on which the point `c` lies: `Greater` is the left hand, `Equal` on it.
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
    pub(super) fn is_crossing(&self, a: u32, b: u32, t0: f64, t1: f64) -> bool {
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
}

fn by_value(feature: &Feature, i: u32, j: u32) -> Ordering {
    feature.values[i as usize].partial_cmp(&feature.values[j as usize]).unwrap_or(Ordering::Equal)
}

fn sign_of(number: f64) -> Ordering {
    number.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

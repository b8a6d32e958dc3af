//! Feature values as coordinates: moved and scaled without rounding for the search, as whole numbers for signs.
//!
//! A coordinate is `(value - origin) / span`, the span a power of two and origin a value of so few digits that nothing
//! is rounded (see `frame`). So regions speak of the values as given, and a proof log's regions mean to its checker
//! what they meant here.

use std::cmp::Ordering;

use octmip_check::two_feature::exact_sign;

use crate::geometry::wide_products::compare_products;

/// Most bits of a feature's whole-number coordinates: the product of two differences then fits 256 bits.
const MOST_BITS: i32 = 120;
/// A cross product of scaled coordinates beyond this has the sign that it shows: its rounding stays below 2^-49.
const CERTAIN: f64 = 1.0 / (1u64 << 48) as f64;

/// Scaled coordinates of all samples, and the given values for exact questions.
///
/// Column `p` (one past the last feature) is zero throughout: the second feature of an axis-aligned split.
#[derive(Debug, Clone)]
pub struct Plane {
    /// Samples.
    pub(crate) n: usize,
    /// Features.
    pub p: usize,
    scaled: Vec<f64>,
    values: Vec<f64>,
    ranks: Vec<u32>,
    /// Exponent of the unit of each feature's whole-number coordinates; none: they would have too many bits.
    unit: Vec<Option<i32>>,
    /// Half the unit of each feature's coordinates, a power of two.
    pub half_spans: Vec<f64>,
    /// Factors that bring the coordinates of each feature to a range of 1, in which margins are measured.
    pub(crate) stretches: Vec<f64>,
}

impl Plane {
    /// The plane of feature-major `values` and their dense `ranks`, each `(p, n)`.
    pub fn new(n: usize, p: usize, values: &[f64], ranks: &[u32]) -> Self {
        let mut scaled = Vec::with_capacity((p + 1) * n);
        let (mut unit, mut half_spans, mut stretches) = (Vec::new(), Vec::new(), Vec::new());
        for column in values.chunks_exact(n) {
            let (origin, half_span) = frame(column);
            let first = scaled.len();
            scaled.extend(column.iter().map(|&v| (v - origin) / half_span / 2.0));
            let coordinates = scaled[first..].iter();
            let (low, high) = coordinates.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
            stretches.push(if high > low { 1.0 / (high - low) } else { 1.0 });
            half_spans.push(half_span);
            unit.push(common_unit(column));
        }
        scaled.resize((p + 1) * n, 0.0);
        unit.push(Some(0));
        stretches.push(1.0);
        let mut values = values.to_vec();
        values.resize((p + 1) * n, 0.0);
        let mut ranks = ranks.to_vec();
        ranks.resize((p + 1) * n, 0);
        Self { n, p, scaled, values, ranks, unit, half_spans, stretches }
    }

    /// Scaled coordinates of a feature, by sample.
    pub(crate) fn column(&self, f: usize) -> &[f64] {
        &self.scaled[f * self.n..(f + 1) * self.n]
    }

    /// Values of a feature as given, by sample.
    pub(crate) fn values(&self, f: usize) -> &[f64] {
        &self.values[f * self.n..(f + 1) * self.n]
    }

    /// The point of a sample in the plane of two features, as ranks: equal for equal points, in the order of the
    /// values.
    pub(crate) fn point(&self, f: usize, g: usize, i: u32) -> (u32, u32) {
        (self.ranks[f * self.n + i as usize], self.ranks[g * self.n + i as usize])
    }

    /// The side of the line from `a` to `b` on which the point `c` lies, exactly: `Greater` is the left hand, `Equal`
    /// on it.
    pub(crate) fn turn(&self, f: usize, g: usize, a: u32, b: u32, c: u32) -> Ordering {
        let (x, y) = (self.column(f), self.column(g));
        let (ia, ib, ic) = (a as usize, b as usize, c as usize);
        let cross = (x[ib] - x[ia]) * (y[ic] - y[ia]) - (y[ib] - y[ia]) * (x[ic] - x[ia]);
        if cross.abs() > CERTAIN {
            return if cross > 0.0 { Ordering::Greater } else { Ordering::Less };
        }
        self.whole_turn((f, g), [a, b, c]).unwrap_or_else(|| {
            let (x, y) = (self.values(f), self.values(g));
            let products =
                [(x[ib], y[ic]), (-x[ib], y[ia]), (-x[ia], y[ic]), (-y[ib], x[ic]), (y[ib], x[ia]), (y[ia], x[ic])];
            exact_sign(&products.map(|(a, b)| (a, b, 0)))
        })
    }

    /// The turn in whole-number coordinates, where both features have them.
    fn whole_turn(&self, (f, g): (usize, usize), [a, b, c]: [u32; 3]) -> Option<Ordering> {
        let (ax, ay) = (self.whole(f, a)?, self.whole(g, a)?);
        let (bx, by) = (self.whole(f, b)? - ax, self.whole(g, b)? - ay);
        let (cx, cy) = (self.whole(f, c)? - ax, self.whole(g, c)? - ay);
        Some(compare_products(bx, cy, by, cx))
    }

    /// The whole-number coordinate of a sample: its value in the unit of its feature.
    fn whole(&self, f: usize, i: u32) -> Option<i128> {
        let unit = self.unit[f]?;
        let (mantissa, exponent) = decode(self.values[f * self.n + i as usize]);
        Some(if mantissa == 0 { 0 } else { i128::from(mantissa) << (exponent - unit) })
    }
}

/// Origin and half the span of a feature's coordinates: they lie within -1 and 1, and (below 120 bits) nothing is
/// rounded.
///
/// The origin is 0 where there are values on both sides of it. Otherwise it lies between 0 and the value nearest to it,
/// in whole units of the last place of the largest value: a difference of two numbers of one sign, in the units of the
/// one and no larger than it, is a float64 value.
fn frame(column: &[f64]) -> (f64, f64) {
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
    };
    let (low, high) = range(&mut column.iter().copied());
    let (nearest, farthest) = if low > 0.0 {
        (low, high)
    } else if high < 0.0 {
        (high, low)
    } else {
        (0.0, 1.0)
    };
    let last_place = (power_of_two(farthest) * f64::EPSILON).max(f64::from_bits(1));
    let origin = (nearest / last_place).trunc() * last_place;
    let (low, high) = range(&mut column.iter().map(|v| (v - origin).abs()));
    (origin, power_of_two(high.max(low)))
}

/// The largest power of two up to the size of a number (1 for 0).
fn power_of_two(number: f64) -> f64 {
    let bits = number.abs().to_bits();
    match bits {
        0 => 1.0,
        denormal if denormal < 1 << 52 => f64::from_bits(1 << denormal.ilog2()),
        _ => f64::from_bits(bits & (0x7ff << 52)),
    }
}

/// `value == mantissa * 2^exponent`, the mantissa odd or zero.
fn decode(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let (mantissa, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    if mantissa == 0 {
        return (0, 0);
    }
    let zeros = mantissa.trailing_zeros();
    let sign = if value < 0.0 { -1 } else { 1 };
    (sign * (mantissa >> zeros), exponent + zeros as i32)
}

/// The exponent of the largest power of two that divides every value, none if coordinates in it need too many bits.
fn common_unit(column: &[f64]) -> Option<i32> {
    let mut least = i32::MAX;
    let mut most = i32::MIN;
    for &value in column.iter().filter(|&&value| value != 0.0) {
        let (mantissa, exponent) = decode(value);
        least = least.min(exponent);
        most = most.max(exponent + 64 - mantissa.unsigned_abs().leading_zeros() as i32);
    }
    if least == i32::MAX {
        return Some(0);
    }
    (most - least < MOST_BITS - 2).then_some(least)
}

#[cfg(test)]
impl Plane {
    /// The plane of points of two features.
    pub(crate) fn of_points(points: &[(f64, f64)]) -> Self {
        let rank = |values: &[f64]| -> Vec<u32> {
            let mut sorted = values.to_vec();
            sorted.sort_by(f64::total_cmp);
            sorted.dedup();
            values.iter().map(|v| sorted.partition_point(|s| s < v) as u32).collect()
        };
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        let ranks = [rank(&x), rank(&y)].concat();
        Self::new(points.len(), 2, &[x, y].concat(), &ranks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_of_one_unit_in_the_last_place_is_seen() {
        let next = f64::from_bits(1.0f64.to_bits() + 1);
        let values = [0.0, 1.0, 2.0, 1.0, 0.0, next, 2.0, 1.0];
        let plane = Plane::new(4, 2, &values, &[0, 1, 2, 1, 0, 2, 3, 1]);
        assert_eq!(plane.turn(0, 1, 0, 2, 1), Ordering::Greater);
        assert_eq!(plane.turn(0, 1, 2, 0, 1), Ordering::Less);
        assert_eq!(plane.turn(0, 1, 0, 2, 3), Ordering::Equal);
    }

    #[test]
    fn coordinates_are_the_values_moved_and_scaled_without_rounding() {
        let values = [500.1, 3000.7, 1024.0 / 3.0, 2999.999, 341.4, 512.000_000_001];
        for sign in [1.0, -1.0] {
            let column = values.map(|v| v * sign);
            let (origin, half_span) = frame(&column);
            for v in column {
                let u = (v - origin) / half_span / 2.0;
                assert!(u.abs() < 1.0);
                assert_eq!(origin + u * half_span * 2.0, v);
            }
            assert!(origin.abs() > 340.0);
        }
        assert_eq!(frame(&[-1.0, 5.0]), (0.0, 4.0));
        assert_eq!(frame(&[f64::MAX, -f64::MAX]).1, 2f64.powi(1023));
    }

    #[test]
    fn a_range_beyond_the_whole_numbers_is_exact_too() {
        let values = [1e-30, 1e30, 0.0, 2e-30, 1e-30, 1e30, 0.0, 2e-30];
        let plane = Plane::new(4, 2, &values, &[1, 3, 0, 2, 1, 3, 0, 2]);
        assert_eq!(plane.turn(0, 1, 0, 1, 2), Ordering::Equal);
        let values = [1e-30, 1e30, 0.0, 2e-30, 1e-30, 1e30, -5e-324, 2e-30];
        let plane = Plane::new(4, 2, &values, &[1, 3, 0, 2, 1, 3, 0, 2]);
        assert_eq!(plane.turn(0, 1, 0, 1, 2), Ordering::Less);
        assert_eq!(plane.turn(0, 1, 0, 1, 3), Ordering::Equal);
    }
}

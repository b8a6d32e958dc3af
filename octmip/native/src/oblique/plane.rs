//! Feature values as coordinates: scaled to `[0, 1]` for the search, as whole numbers for what must be exact.

use std::cmp::Ordering;

use super::wide::compare_products;

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
    pub n: usize,
    /// Features.
    pub p: usize,
    scaled: Vec<f64>,
    values: Vec<f64>,
    ranks: Vec<u32>,
    /// Exponent of the unit of each feature's whole-number coordinates; none: too wide a range for them.
    unit: Vec<Option<i32>>,
    /// Span of each feature: scaled coordinate = (value - lowest) / span; 1 for a constant feature.
    pub spans: Vec<f64>,
}

impl Plane {
    /// The plane of feature-major `values` and their dense `ranks`, each `(p, n)`.
    pub fn new(n: usize, p: usize, values: &[f64], ranks: &[u32]) -> Self {
        let mut scaled = Vec::with_capacity((p + 1) * n);
        let (mut unit, mut spans) = (Vec::with_capacity(p + 1), Vec::with_capacity(p));
        for column in values.chunks_exact(n) {
            let (low, high) = column
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| {
                    (l.min(v), h.max(v))
                });
            // Halves, so that no difference of finite values overflows.
            let half_span = high / 2.0 - low / 2.0;
            let divisor = if half_span > 0.0 { half_span } else { 1.0 };
            scaled.extend(column.iter().map(|&v| (v / 2.0 - low / 2.0) / divisor));
            unit.push(common_unit(column));
            spans.push(if half_span > 0.0 {
                half_span * 2.0
            } else {
                1.0
            });
        }
        scaled.resize((p + 1) * n, 0.0);
        unit.push(Some(0));
        let mut values = values.to_vec();
        values.resize((p + 1) * n, 0.0);
        let mut ranks = ranks.to_vec();
        ranks.resize((p + 1) * n, 0);
        Self {
            n,
            p,
            scaled,
            values,
            ranks,
            unit,
            spans,
        }
    }

    /// Scaled coordinates of a feature, by sample.
    pub fn column(&self, f: usize) -> &[f64] {
        &self.scaled[f * self.n..(f + 1) * self.n]
    }

    /// Values of a feature as given, by sample.
    pub fn values(&self, f: usize) -> &[f64] {
        &self.values[f * self.n..(f + 1) * self.n]
    }

    /// The point of a sample in the plane of two features, as ranks: equal for equal points, in the order of the values.
    pub fn point(&self, f: usize, g: usize, i: u32) -> (u32, u32) {
        (
            self.ranks[f * self.n + i as usize],
            self.ranks[g * self.n + i as usize],
        )
    }

    /// On which side of the line from `a` to `b` the point `c` lies, exactly: `Greater` is the left hand, `Equal` on it.
    ///
    /// None where a feature's values range too widely (beyond 120 bits) and rounding could decide.
    pub fn turn(&self, f: usize, g: usize, a: u32, b: u32, c: u32) -> Option<Ordering> {
        let (x, y) = (self.column(f), self.column(g));
        let (ia, ib, ic) = (a as usize, b as usize, c as usize);
        let cross = (x[ib] - x[ia]) * (y[ic] - y[ia]) - (y[ib] - y[ia]) * (x[ic] - x[ia]);
        if cross.abs() > CERTAIN {
            return cross.partial_cmp(&0.0);
        }
        let at = |feature: usize, i: u32| self.whole(feature, i);
        let (ax, ay) = (at(f, a)?, at(g, a)?);
        let (bx, by) = (at(f, b)? - ax, at(g, b)? - ay);
        let (cx, cy) = (at(f, c)? - ax, at(g, c)? - ay);
        Some(compare_products(bx, cy, by, cx))
    }

    /// The whole-number coordinate of a sample: its value in the unit of its feature.
    fn whole(&self, f: usize, i: u32) -> Option<i128> {
        let unit = self.unit[f]?;
        let (mantissa, exponent) = decode(self.values[f * self.n + i as usize]);
        Some(if mantissa == 0 {
            0
        } else {
            i128::from(mantissa) << (exponent - unit)
        })
    }
}

/// `value == mantissa * 2^exponent`, the mantissa odd or zero.
fn decode(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let (mantissa, exponent) = if biased == 0 {
        (fraction, -1074)
    } else {
        (fraction | 1 << 52, biased - 1075)
    };
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
mod tests {
    use super::*;

    #[test]
    fn a_turn_of_one_unit_in_the_last_place_is_seen() {
        let next = f64::from_bits(1.0f64.to_bits() + 1);
        let values = [0.0, 1.0, 2.0, 1.0, 0.0, next, 2.0, 1.0];
        let plane = Plane::new(4, 2, &values, &[0, 1, 2, 1, 0, 2, 3, 1]);
        assert_eq!(plane.turn(0, 1, 0, 2, 1), Some(Ordering::Greater));
        assert_eq!(plane.turn(0, 1, 2, 0, 1), Some(Ordering::Less));
        assert_eq!(plane.turn(0, 1, 0, 2, 3), Some(Ordering::Equal));
    }

    #[test]
    fn a_range_beyond_the_whole_numbers_is_owned_up_to() {
        let values = [1e-30, 1e30, 0.0, 1e-30, 1e30, 0.0];
        let plane = Plane::new(3, 2, &values, &[1, 2, 0, 1, 2, 0]);
        assert_eq!(plane.turn(0, 1, 0, 1, 2), None);
    }
}

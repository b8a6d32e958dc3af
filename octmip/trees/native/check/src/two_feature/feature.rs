//! The values of one feature and their coordinates.

/// Numbers below this (other than 0) could underflow in a product of two and its rounding.
pub(super) const LEAST: f64 = 1e-135;
/// The values of one feature, and their coordinates.
///
/// The feature is moved by a constant and divided by a power of two, which keeps the lines. The difference of a value
/// and the constant is rounded at most once and no larger than the value, so a coordinate is wrong by 2^-53 at most.
pub(super) struct Feature {
    pub(super) values: Vec<f64>,
    /// All within -1 and 1.
    pub(super) coordinates: Vec<f64>,
    /// A coordinate is the value, moved, divided by 2 to this power.
    pub(super) exponent: i32,
    /// No coordinate is rounded, and none is so small that a product of two underflows.
    pub(super) is_exact: bool,
}

impl Feature {
    /// The feature with these values.
    pub(super) fn new(values: &[f64]) -> Self {
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

//! Feature values in units of their own, in which nothing that hyperplane moves compute overflows.
//!
//! Feature f is divided by the power of two `2^e_f` that brings its largest value to between a half and 1. Nothing is
//! rounded but what lies 300 orders of magnitude below that largest value: such samples cannot be separated by a
//! hyperplane here, only by the ranks of axis-aligned cuts. A plane over these values,
//!
//! `sum_f c_f x_f / 2^e_f <= b`, is `sum_f (c_f 2^(s - e_f)) x_f <= b 2^s` over the values as given,
//!
//! the shift s being free: as the caller prefers it where that keeps far from the ends of the float64 range, else such
//! that the coefficients lie about its middle. A plane that float64 cannot hold is none.

use crate::tree::rule::Rule;
use octmip_check::problem::Problem;

/// Feature and coefficient of each term of a plane.
pub(crate) type Terms = Vec<(u32, f64)>;

/// Coefficients between 2^-500 and 2^500 are left as they are.
const MODERATE: i32 = 500;
/// Sums of products stay below two to this power, so that samples a thousand times as large do not overflow either.
const LARGEST_SUM: i32 = 1010;
/// Integers up to this are float64 values, all of them.
const MOST_INTEGER: i64 = 1 << 53;

/// The scaled values of a problem's features.
#[derive(Debug, Default)]
pub(crate) struct Values {
    p: usize,
    scaled: Vec<f64>,
    exponents: Vec<i32>,
    /// Largest coefficient where all must be integers.
    most_integer: Option<i64>,
}

impl Values {
    /// The values of a problem; empty without planes.
    pub(crate) fn new(problem: &Problem) -> Self {
        let Some(planes) = &problem.planes else {
            return Self::default();
        };
        let mut largest = vec![0.0_f64; problem.p];
        for row in planes.values.chunks_exact(problem.p) {
            largest.iter_mut().zip(row).for_each(|(most, value)| *most = most.max(value.abs()));
        }
        let exponents: Vec<i32> = largest.into_iter().map(exponent_of).collect();
        let of_row = |row: &[f64]| {
            let values = row.iter().zip(&exponents);
            values.map(|(&value, &e)| times_power(value, -e)).collect::<Vec<f64>>()
        };
        let scaled = planes.values.chunks_exact(problem.p).flat_map(of_row).collect();
        let most_integer = planes.integer_normals.map(|most| most.min(MOST_INTEGER));
        Self { p: problem.p, scaled, exponents, most_integer }
    }

    /// The values of a sample.
    #[inline]
    pub(crate) fn row(&self, sample: u32) -> &[f64] {
        &self.scaled[sample as usize * self.p..][..self.p]
    }

    /// All values, sample by sample.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.scaled.chunks_exact(self.p.max(1))
    }

    /// `terms . x` of a sample.
    #[inline]
    pub(crate) fn project(&self, terms: &[(u32, f64)], sample: u32) -> f64 {
        let row = self.row(sample);
        terms.iter().fold(0.0, |sum, &(f, c)| sum + c * row[f as usize])
    }

    /// Largest coefficient where all must be integers; none: they are real.
    pub(crate) fn most_integer(&self) -> Option<i64> {
        self.most_integer
    }

    /// Exponent of the unit of a feature.
    pub(crate) fn exponent(&self, feature: u32) -> i32 {
        self.exponents[feature as usize]
    }

    /// A plane over the values as given in the units here, its largest coefficient between a half and 1, and its shift;
    /// none where its offset is too far away to be held.
    pub(crate) fn scaled_plane(&self, terms: &[(u32, f64)], offset: f64) -> Option<(Terms, f64, i32)> {
        let top = terms.iter().map(|&(f, c)| exponent_of(c) + self.exponent(f)).max()?;
        let terms = terms.iter().map(|&(f, c)| (f, times_power(c, self.exponent(f) - top)));
        let offset = times_power(offset, -top);
        offset.is_finite().then(|| (terms.filter(|term| term.1 != 0.0).collect(), offset, top))
    }

    /// The rule over the values as given of a plane here, shifted by `shift` where that can be; none where float64
    /// cannot hold it.
    pub(crate) fn rule(&self, terms: &[(u32, f64)], offset: f64, shift: i32) -> Option<Rule> {
        let size = terms.iter().map(|term| exponent_of(term.1)).max()?;
        let of_terms = |terms: &[(u32, f64)]| {
            let exponents = terms.iter().map(|&(f, c)| exponent_of(c) - self.exponent(f));
            exponents.fold((i32::MAX, i32::MIN), |(low, high), e| (low.min(e), high.max(e)))
        };
        let (low, high) = of_terms(terms);
        // So many bits a sum of so many products may add.
        let room = LARGEST_SUM - size - (usize::BITS - terms.len().leading_zeros()) as i32;
        let is_moderate = high + shift <= MODERATE && low + shift >= -MODERATE;
        let shift = match self.most_integer {
            Some(_) => shift,
            None if is_moderate => shift,
            // Small coefficients may lose digits, large ones must be finite.
            None => (-(low + high) / 2).clamp(-LARGEST_SUM - size, room).min(f64::MAX_EXP - high),
        };
        let given = |&(f, c): &(u32, f64)| (f, self.whole(times_power(c, shift - self.exponent(f))));
        let terms: Terms = terms.iter().map(given).filter(|term| term.1 != 0.0).collect();
        let offset = times_power(offset, shift);
        let is_held =
            offset.is_finite() && !terms.is_empty() && shift <= room && terms.iter().all(|t| self.is_held(t.1));
        is_held.then_some(Rule::Plane { terms, offset })
    }

    /// Integers may have lost digits at the small end of the float64 range.
    fn whole(&self, coefficient: f64) -> f64 {
        if self.most_integer.is_some() { coefficient.round() } else { coefficient }
    }

    fn is_held(&self, coefficient: f64) -> bool {
        coefficient.is_finite() && self.most_integer.is_none_or(|most| coefficient.abs() <= most as f64)
    }
}

/// Divide a plane by the power of two that brings its largest coefficient to between a half and 1; return its exponent.
pub(crate) fn normalise(terms: &mut [(u32, f64)], offset: &mut f64) -> i32 {
    let top = terms.iter().map(|term| exponent_of(term.1)).max().unwrap_or(0);
    if top != 0 {
        terms.iter_mut().for_each(|term| term.1 = times_power(term.1, -top));
        *offset = times_power(*offset, -top);
    }
    top
}

/// The k of `2^(k - 1) <= |value| < 2^k`; 0 of 0.
pub(crate) fn exponent_of(value: f64) -> i32 {
    let biased = |value: f64| (value.to_bits() >> 52 & 0x7ff) as i32;
    match biased(value) {
        0 if value == 0.0 => 0,
        0 => biased(value * power(64)) - 1022 - 64,
        exponent => exponent - 1022,
    }
}

/// `value * 2^exponent`, rounded only where it leaves the range of normal float64 numbers.
#[inline]
pub(crate) fn times_power(value: f64, exponent: i32) -> f64 {
    if (-1022..=1023).contains(&exponent) {
        return value * power(exponent);
    }
    let (mut value, mut left) = (value, exponent);
    while left != 0 && value != 0.0 && value.is_finite() {
        let step = left.clamp(-1000, 1000);
        value *= power(step);
        left -= step;
    }
    value
}

/// `2^exponent` of a normal float64 number.
fn power(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use crate::prepared::values::{Values, exponent_of, times_power};
    use crate::tree::rule::Rule;
    use octmip_check::problem::{Planes, Problem};
    use octmip_oracle::problem_of_ranks;

    #[test]
    fn exponents_are_those_of_the_next_power_of_two_for_denormals_too() {
        for (value, exponent) in [(1.0, 1), (0.75, 0), (-8.0, 4), (f64::MAX, 1024), (5e-324, -1073), (0.0, 0)] {
            assert_eq!(exponent_of(value), exponent, "{value}");
        }
    }

    #[test]
    fn powers_of_two_take_a_value_through_the_whole_range_and_back() {
        for value in [1.0, -1.75, 0.1] {
            assert_eq!(times_power(times_power(value, 1000), -1000), value);
            assert_eq!(times_power(times_power(value, -1000), 1000), value);
        }
        assert_eq!(times_power(5e-324, 1074), 1.0);
        assert_eq!(times_power(1.0, -1074), 5e-324);
        assert_eq!(times_power(1.0, 1024), f64::INFINITY);
        assert_eq!(times_power(1.0, -3000), 0.0);
    }

    fn values_of(rows: &[[f64; 2]], integer_normals: Option<i64>) -> Values {
        let planes = Planes { values: rows.concat(), split_size: 2, groups: None, integer_normals };
        let labels = vec![0; rows.len()];
        let problem = Problem { planes: Some(planes), ..problem_of_ranks(&labels.repeat(2), &labels) };
        Values::new(&problem)
    }

    #[test]
    fn a_plane_comes_back_as_it_went_and_parts_the_values_as_given() {
        let rows = [[3.0, -700.0], [5.0, 800.0]];
        let values = values_of(&rows, None);
        let (terms, offset, shift) = values.scaled_plane(&[(0, 0.3), (1, -0.007)], 1.5).unwrap();
        let rule = Rule::Plane { terms: vec![(0, 0.3), (1, -0.007)], offset: 1.5 };
        assert_eq!(values.rule(&terms, offset, shift), Some(rule));
    }

    #[test]
    fn coefficients_of_values_at_both_ends_of_the_range_are_finite_and_no_product_overflows() {
        let values = values_of(&[[f64::MAX, 5e-324], [-1e300, -1e-323]], None);
        let Some(Rule::Plane { terms, .. }) = values.rule(&[(0, 1.0), (1, -1.0)], 0.25, 0) else {
            panic!("no rule");
        };
        assert!(terms.iter().all(|term| term.1.is_finite() && term.1 != 0.0));
        assert!((terms[0].1 * f64::MAX).is_finite() && (terms[1].1 * -1e-323).is_finite());
    }

    #[test]
    fn integers_stay_integers_and_a_sum_that_would_overflow_is_no_plane() {
        let values = values_of(&[[8.0, 1.0], [1.0, 3.0]], Some(5));
        let (terms, offset, shift) = values.scaled_plane(&[(0, 3.0), (1, -5.0)], 1.0).unwrap();
        let rule = Rule::Plane { terms: vec![(0, 3.0), (1, -5.0)], offset: 1.0 };
        assert_eq!(values.rule(&terms, offset, shift), Some(rule));
        let large = values_of(&[[f64::MAX, 1.0], [1.0, 3.0]], Some(5));
        assert_eq!(large.rule(&[(0, 1.0)], 0.5, 1024), None);
    }
}

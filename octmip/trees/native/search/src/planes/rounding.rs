//! The rounding of a plane to integer coefficients.

use crate::gains::tally::Tally;
use crate::planes::line::SampledPlane;
use crate::planes::plane_search::PlaneSearch;
use crate::prepared::values::{exponent_of, times_power};
use crate::tree::view::NodeView;

/// Scales at which a normal is rounded to integers.
const ROUNDINGS: usize = 6;

impl<'a> PlaneSearch<'a> {
    /// Round the coefficients at some scale where they must be integers, the offset refined; whether a plane is left.
    pub(crate) fn round(&mut self, view: &NodeView, rng: &mut fastrand::Rng) -> bool {
        let Some(most) = self.prepared.values.most_integer() else {
            return true;
        };
        let (terms, offset) = (self.terms(), self.plane.offset);
        let mut best: Option<(i64, SampledPlane, Tally<'a>)> = None;
        for _ in 0..ROUNDINGS {
            let size = rng.i64(1..=most) as f64;
            if !self.set_rounded(&terms, offset, size) {
                continue;
            }
            self.place(view);
            self.shift(view, rng);
            if self.tally.is_large_enough() && best.as_ref().is_none_or(|kept| self.gain() > kept.0) {
                best = Some((self.gain(), self.plane.clone(), self.tally.clone()));
            }
        }
        let Some((_, plane, tally)) = best else {
            return false;
        };
        (self.plane, self.tally) = (plane, tally);
        true
    }

    /// Set a plane whose coefficients over the values as given are rounded, the largest of them being `size`; whether
    /// any is left.
    fn set_rounded(&mut self, terms: &[(u32, f64)], offset: f64, size: f64) -> bool {
        let values = &self.prepared.values;
        // Over the values as given, but for a common power of two that brings the largest to between a half and 1.
        let Some(top) = terms.iter().map(|&(f, c)| exponent_of(c) - values.exponent(f)).max() else {
            return false;
        };
        let given = |&(f, c): &(u32, f64)| (f, times_power(c, -values.exponent(f) - top));
        let given: Vec<(u32, f64)> = terms.iter().map(given).collect();
        let largest = given.iter().fold(0.0_f64, |largest, term| largest.max(term.1.abs()));
        let scale = size / largest;
        let rounded = given.into_iter().map(|(f, c)| (f, (c * scale).round()));
        let rounded: Vec<(u32, f64)> = rounded.filter(|term| term.1 != 0.0).collect();
        let Some(unit) = rounded.iter().map(|&(f, _)| values.exponent(f)).max() else {
            return false;
        };
        let own = rounded.iter().map(|&(f, c)| (f, times_power(c, values.exponent(f) - unit)));
        let own: Vec<(u32, f64)> = own.filter(|term| term.1 != 0.0).collect();
        let offset = times_power(offset * scale, -top - unit);
        if !offset.is_finite() {
            return false;
        }
        self.set(&own, offset);
        self.plane.shift += unit;
        true
    }
}

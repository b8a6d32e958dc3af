//! Shaking a plane at random, and rounding it.

use crate::search::line::Plane;
use crate::search::plane::PlaneAtWork;
use crate::search::tally::Tally;
use crate::search::values::{exponent_of, times_power};
use crate::search::view::View;

/// Scales at which a normal is rounded to integers.
const ROUNDINGS: usize = 6;

impl<'a> PlaneAtWork<'a> {
    /// Where coefficients must be integers, round them at some scale, the offset refined; whether a plane is left.
    pub fn round(&mut self, view: &View, rng: &mut fastrand::Rng) -> bool {
        let Some(most) = self.ground.values.most_integer() else {
            return true;
        };
        let (terms, offset) = (self.terms(), self.plane.offset);
        let mut best: Option<(i64, Plane, Tally<'a>)> = None;
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
        let values = &self.ground.values;
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

    /// Disturb normal and offset by a random share of their own size; whether leaves stay large enough.
    pub fn jitter(&mut self, view: &View, rng: &mut fastrand::Rng) -> bool {
        let terms = self.terms();
        let deviations = &self.ground.deviations;
        let size = terms.iter().map(|&(f, c)| (c * deviations[f as usize]).powi(2)).sum::<f64>();
        let scale = (size / terms.len().max(1) as f64).sqrt() * 10_f64.powf(rng.f64() * 2.0 - 2.0);
        let anchor = view.samples[rng.usize(..view.samples.len())];
        let shaken: Vec<(u32, f64)> =
            terms.iter().map(|&(f, c)| (f, c + scale * normal(rng) / deviations[f as usize])).collect();
        let values = &self.ground.values;
        let offset = self.plane.offset + values.project(&shaken, anchor) - values.project(&terms, anchor);
        self.set(&shaken, offset + scale * normal(rng));
        self.place(view);
        self.tally.is_large_enough()
    }
}

/// A draw from the standard normal distribution (Box & Muller, 1958).
pub fn normal(rng: &mut fastrand::Rng) -> f64 {
    let radius = (-2.0 * (1.0 - rng.f64()).ln()).sqrt();
    radius * (std::f64::consts::TAU * rng.f64()).cos()
}

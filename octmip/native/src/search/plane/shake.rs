//! Shaking a plane at random, and rounding it.

use crate::search::line::Plane;
use crate::search::plane::PlaneAtWork;
use crate::search::state::project;
use crate::search::tally::Tally;
use crate::search::view::View;

/// Scales at which a normal is rounded to integers.
const ROUNDINGS: usize = 6;

impl<'a> PlaneAtWork<'a> {
    /// Where coefficients must be integers, round them at some scale, the offset refined; whether a plane is left.
    pub fn round(&mut self, view: &View, rng: &mut fastrand::Rng) -> bool {
        let Some(most) = self.ground.problem.planes.as_ref().and_then(|planes| planes.integer_normals) else {
            return true;
        };
        let (terms, offset) = (self.terms(), self.plane.offset);
        let largest = terms.iter().fold(0.0_f64, |largest, term| largest.max(term.1.abs()));
        let mut best: Option<(i64, Plane, Tally<'a>)> = None;
        for _ in 0..ROUNDINGS {
            let scale = rng.i64(1..=most) as f64 / largest;
            let rounded: Vec<(u32, f64)> = terms.iter().map(|&(f, c)| (f, (c * scale).round())).collect();
            let rounded: Vec<(u32, f64)> = rounded.into_iter().filter(|term| term.1 != 0.0).collect();
            if rounded.is_empty() || !largest.is_finite() {
                continue;
            }
            self.set(&rounded, offset * scale);
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

    /// Disturb normal and offset by a random share of their own size; whether leaves stay large enough.
    pub fn jitter(&mut self, view: &View, rng: &mut fastrand::Rng) -> bool {
        let terms = self.terms();
        let deviations = &self.ground.deviations;
        let size = terms.iter().map(|&(f, c)| (c * deviations[f as usize]).powi(2)).sum::<f64>();
        let scale = (size / terms.len().max(1) as f64).sqrt() * 10_f64.powf(rng.f64() * 2.0 - 2.0);
        let anchor = view.samples[rng.usize(..view.samples.len())];
        let shaken: Vec<(u32, f64)> =
            terms.iter().map(|&(f, c)| (f, c + scale * normal(rng) / deviations[f as usize])).collect();
        let problem = self.ground.problem;
        let offset = self.plane.offset + project(problem, &shaken, anchor) - project(problem, &terms, anchor);
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

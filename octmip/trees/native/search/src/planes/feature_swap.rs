//! Features swapped in a plane that may read no more: proposals, each refined before it is judged.

use crate::gains::tally::Tally;
use crate::logistic::ranking::leading;
use crate::logistic::regression::{MOST_FITTED, fit};
use crate::planes::line::SampledPlane;
use crate::planes::logistic_fit::RIDGES;
use crate::planes::plane_search::PlaneSearch;
use crate::planes::random::normal;
use crate::tree::allowance::Allowance;
use crate::tree::view::NodeView;

/// Proposals of one visit.
const PROPOSALS: usize = 2;
/// Share of the gain that a proposal may lack before it is refined.
const SLACK: f64 = 0.03;
/// Random directions over its own features that refine a proposal.
const OWN_DIRECTIONS: usize = 2;
/// Least share of the features that a logistic regression chooses from.
const LEAST_SHARE: f64 = 0.3;

impl PlaneSearch<'_> {
    /// Propose other features a few times, refine each plane over its own features, keep what gains no less.
    pub(crate) fn swap_features(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) {
        for _ in 0..PROPOSALS {
            if !self.supervisor.goes_on() {
                return;
            }
            let (floor, before) = (self.gain(), (self.plane.clone(), self.tally.clone()));
            let slack = (SLACK * self.tally.total as f64) as i64;
            let is_new = match rng.u32(..3) {
                0 => self.select_by_logistic(view, allowance, rng),
                1 => self.swap_one(view, allowance, rng),
                _ => self.add_and_drop(view, allowance, rng),
            };
            if is_new && self.tally.is_large_enough() && self.gain() >= floor - slack {
                self.refine(view, rng);
            }
            if !is_new || !self.tally.is_large_enough() || self.gain() < floor {
                (self.plane, self.tally) = before;
            }
        }
    }

    /// Lines over the features that are read now.
    fn refine(&mut self, view: &NodeView, rng: &mut fastrand::Rng) {
        let mut features = self.support();
        rng.shuffle(&mut features);
        self.shift(view, rng);
        for &f in &features {
            if !self.supervisor.goes_on() {
                return;
            }
            self.turn(view, &[(f, 1.0)], rng);
        }
        features.sort_unstable();
        for _ in 0..OWN_DIRECTIONS {
            let step = |&f: &u32| (f, normal(rng) / self.prepared.deviations[f as usize]);
            let direction: Vec<(u32, f64)> = features.iter().map(step).collect();
            self.turn(view, &direction, rng);
        }
        self.shift(view, rng);
    }

    /// The features that lead in a logistic regression, over many of them, on the sides that the samples prefer.
    fn select_by_logistic(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) -> bool {
        let (values, supervisor) = (&self.prepared.values, self.supervisor);
        let go_on = &|| supervisor.goes_on();
        let sides = self.preferred_sides(view, rng);
        let mut features: Vec<u32> = (0..self.prepared.problem.p as u32).filter(|&f| allowance.admits(&[f])).collect();
        rng.shuffle(&mut features);
        let share = LEAST_SHARE + (1.0 - LEAST_SHARE) * rng.f64();
        features.truncate(((features.len() as f64 * share) as usize).max(self.prepared.split_size()).min(MOST_FITTED));
        let ridge = RIDGES[rng.usize(..RIDGES.len())];
        let leading = leading(values, &sides, &features, ridge, rng, go_on);
        let chosen =
            leading.map(|order| allowance.first_admitted(&order, self.prepared.split_size())).unwrap_or_default();
        let Some((normal, offset)) = fit(values, &sides, &chosen, ridge, go_on) else {
            return false;
        };
        let terms: Vec<(u32, f64)> = chosen.into_iter().zip(normal).filter(|term| term.1 != 0.0).collect();
        self.set(&terms, offset);
        self.place(view);
        self.shift(view, rng);
        true
    }

    /// Another feature in the place of one that is read now: all its coefficients, about a random sample.
    fn swap_one(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) -> bool {
        let f = rng.u32(..self.prepared.problem.p as u32);
        let support = self.support();
        if support.len() < 2 || support.binary_search(&f).is_ok() {
            return false;
        }
        let dropped = support[rng.usize(..support.len())];
        let anchor = view.samples[rng.usize(..view.samples.len())];
        self.drop_feature(view, dropped, anchor);
        if !allowance.admits(&self.support_with(f)) {
            return false;
        }
        let patience = std::mem::replace(&mut self.patience, i64::MAX / 2);
        self.turn_about(view, &[(f, 1.0)], self.prepared.values.row(anchor)[f as usize], rng);
        self.patience = patience;
        true
    }

    /// Leave out one feature, the plane held where that feature is as it is in one sample.
    fn drop_feature(&mut self, view: &NodeView, f: u32, anchor: u32) {
        let weight = std::mem::take(&mut self.plane.normal[f as usize]);
        self.plane.offset -= weight * self.prepared.values.row(anchor)[f as usize];
        self.place(view);
    }

    /// Read one feature more than may be read, then leave out the one that costs least.
    fn add_and_drop(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) -> bool {
        let f = rng.u32(..self.prepared.problem.p as u32);
        let candidates = self.support();
        if candidates.binary_search(&f).is_ok() {
            return false;
        }
        self.turn(view, &[(f, 1.0)], rng);
        if self.plane.normal[f as usize] == 0.0 {
            return false;
        }
        let added = (self.plane.clone(), self.tally.clone());
        let mut best: Option<(i64, SampledPlane, Tally)> = None;
        for dropped in candidates {
            if !self.supervisor.goes_on() {
                break;
            }
            self.drop_feature(view, dropped, view.samples[rng.usize(..view.samples.len())]);
            if allowance.admits(&self.support()) {
                self.shift(view, rng);
                let gain = self.gain();
                if self.tally.is_large_enough() && best.as_ref().is_none_or(|(most, ..)| gain > *most) {
                    best = Some((gain, self.plane.clone(), self.tally.clone()));
                }
            }
            (self.plane, self.tally) = added.clone();
        }
        let is_found = best.is_some();
        if let Some((_, plane, tally)) = best {
            (self.plane, self.tally) = (plane, tally);
        }
        is_found
    }
}

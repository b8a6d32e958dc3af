//! Other features for a plane that may read no more: proposals, each refined before it is judged.

use crate::search::gains::tally::Tally;
use crate::search::logistic::ranking::leading;
use crate::search::logistic::regression::{MOST_FITTED, fit};
use crate::search::planes::line::Plane;
use crate::search::planes::logistic_fit::RIDGES;
use crate::search::planes::plane_search::PlaneAtWork;
use crate::search::planes::random::normal;
use crate::search::tree::allowance::Room;
use crate::search::tree::view::View;

/// Proposals of one visit.
const PROPOSALS: usize = 2;
/// Share of the gain that a proposal may lack before it is refined.
const SLACK: f64 = 0.03;
/// Random directions over its own features that refine a proposal.
const OWN_DIRECTIONS: usize = 2;
/// Least share of the features that a logistic regression chooses from.
const LEAST_SHARE: f64 = 0.3;

impl PlaneAtWork<'_> {
    /// Propose other features a few times, refine each plane over its own features, keep what gains no less.
    pub(crate) fn read_anew(&mut self, view: &View, room: &Room, rng: &mut fastrand::Rng) {
        for _ in 0..PROPOSALS {
            if !self.supervisor.goes_on() {
                return;
            }
            let (floor, before) = (self.gain(), (self.plane.clone(), self.tally.clone()));
            let slack = (SLACK * self.tally.total as f64) as i64;
            let is_new = match rng.u32(..3) {
                0 => self.lead_by_logistic(view, room, rng),
                1 => self.exchange(view, room, rng),
                _ => self.add_and_drop(view, room, rng),
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
    fn refine(&mut self, view: &View, rng: &mut fastrand::Rng) {
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
            let step = |&f: &u32| (f, normal(rng) / self.ground.deviations[f as usize]);
            let direction: Vec<(u32, f64)> = features.iter().map(step).collect();
            self.turn(view, &direction, rng);
        }
        self.shift(view, rng);
    }

    /// The features that lead in a logistic regression over many of them to what every sample would rather do.
    fn lead_by_logistic(&mut self, view: &View, room: &Room, rng: &mut fastrand::Rng) -> bool {
        let (values, supervisor) = (&self.ground.values, self.supervisor);
        let go_on = &|| supervisor.goes_on();
        let pulls = self.pulls(view, rng);
        let mut features: Vec<u32> = (0..self.ground.problem.p as u32).filter(|&f| room.admits(&[f])).collect();
        rng.shuffle(&mut features);
        let share = LEAST_SHARE + (1.0 - LEAST_SHARE) * rng.f64();
        features.truncate(((features.len() as f64 * share) as usize).max(self.ground.split_size()).min(MOST_FITTED));
        let ridge = RIDGES[rng.usize(..RIDGES.len())];
        let leading = leading(values, &pulls, &features, ridge, rng, go_on);
        let chosen = leading.map(|order| room.first_admitted(&order, self.ground.split_size())).unwrap_or_default();
        let Some((normal, offset)) = fit(values, &pulls, &chosen, ridge, go_on) else {
            return false;
        };
        let terms: Vec<(u32, f64)> = chosen.into_iter().zip(normal).filter(|term| term.1 != 0.0).collect();
        self.set(&terms, offset);
        self.place(view);
        self.shift(view, rng);
        true
    }

    /// Another feature in the place of one that is read now: all its coefficients, about a random sample.
    fn exchange(&mut self, view: &View, room: &Room, rng: &mut fastrand::Rng) -> bool {
        let f = rng.u32(..self.ground.problem.p as u32);
        let support = self.support();
        if support.len() < 2 || support.binary_search(&f).is_ok() {
            return false;
        }
        let dropped = support[rng.usize(..support.len())];
        let anchor = view.samples[rng.usize(..view.samples.len())];
        self.drop_feature(view, dropped, anchor);
        if !room.admits(&self.support_with(f)) {
            return false;
        }
        let patience = std::mem::replace(&mut self.patience, i64::MAX / 2);
        self.turn_about(view, &[(f, 1.0)], self.ground.values.row(anchor)[f as usize], rng);
        self.patience = patience;
        true
    }

    /// Leave out one feature, the plane held where that feature is as it is in one sample.
    fn drop_feature(&mut self, view: &View, f: u32, anchor: u32) {
        let weight = std::mem::take(&mut self.plane.normal[f as usize]);
        self.plane.offset -= weight * self.ground.values.row(anchor)[f as usize];
        self.place(view);
    }

    /// Read one feature more than may be read, then leave out the one that costs least.
    fn add_and_drop(&mut self, view: &View, room: &Room, rng: &mut fastrand::Rng) -> bool {
        let f = rng.u32(..self.ground.problem.p as u32);
        let candidates = self.support();
        if candidates.binary_search(&f).is_ok() {
            return false;
        }
        self.turn(view, &[(f, 1.0)], rng);
        if self.plane.normal[f as usize] == 0.0 {
            return false;
        }
        let added = (self.plane.clone(), self.tally.clone());
        let mut best: Option<(i64, Plane, Tally)> = None;
        for dropped in candidates {
            if !self.supervisor.goes_on() {
                break;
            }
            self.drop_feature(view, dropped, view.samples[rng.usize(..view.samples.len())]);
            if room.admits(&self.support()) {
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

//! Refinement: regions are split until their open samples have few dichotomies, each of which is tried.

use crate::geometry::line::Line;
use crate::regions::dichotomies::{Dichotomies, End, end_of};
use crate::regions::realisation::{Realisation, realise};
use crate::regions::region::{Region, split};
use crate::stumps::search::{Candidate, StumpSearch};
use crate::weighted_samples::{difference, sum};

impl StumpSearch<'_> {
    /// Split a region until nothing in it can win.
    pub(crate) fn refine(&mut self, candidate: Candidate) {
        let root = self.part_of(candidate.features, candidate.region, self.ids, None);
        let mut stack = vec![root];
        while let Some(part) = stack.pop() {
            if part.bound >= self.current || self.is_stopped() {
                continue;
            }
            self.try_center(candidate.features, &part);
            match end_of(self.samples.plane, candidate.features, &part.region, &part.open) {
                End::Parts { points, dichotomies } => {
                    self.try_dichotomies(candidate.features, &part, &points, &dichotomies);
                }
                End::Stuck => self.undecided = self.undecided.min(part.bound),
                End::Split => {
                    let regions = split(self.samples.plane, candidate.features, &part.region, &part.open, None);
                    let mut parts =
                        regions.map(|region| self.part_of(candidate.features, region, &part.open, Some(&part)));
                    if parts[0].bound < parts[1].bound {
                        parts.reverse(); // the better one on top of the stack
                    }
                    stack.extend(parts);
                }
            }
        }
    }

    fn part_of(&self, features: (usize, usize), region: Region, ids: &[u32], parent: Option<&Part>) -> Part {
        let zero = || vec![0; self.samples.loss.lanes()];
        let mut left = parent.map_or_else(zero, |part| part.left.clone());
        let mut right = parent.map_or_else(zero, |part| part.right.clone());
        let (x, y) = (self.samples.plane.column(features.0), self.samples.plane.column(features.1));
        let open = region.sort(x, y, ids, |i, goes_left| {
            self.samples.add(if goes_left { &mut left } else { &mut right }, i);
        });
        let may_left = difference(&self.total, &right);
        let may_right = difference(&self.total, &left);
        let bound =
            self.samples.loss.bound(&self.total, &may_left, &may_right, self.need) + self.samples.price(features);
        Part { region, left, right, open, bound }
    }

    fn try_center(&mut self, features: (usize, usize), part: &Part) {
        let (t, r) = part.region.center();
        let line = Line { features, t, r };
        let mut left = part.left.clone();
        for &i in &part.open {
            if line.sends_left(self.samples.plane, i) {
                self.samples.add(&mut left, i);
            }
        }
        let cost = self.cost_of_left(features, &left);
        if cost < self.incumbent && line.is_clear_of(self.samples.plane, &part.open) {
            self.offer(cost, line);
        }
    }

    fn cost_of_left(&self, features: (usize, usize), left: &[i64]) -> i64 {
        let right = difference(&self.total, left);
        let cost = self.samples.loss.sides(left, &right, self.need);
        cost + self.samples.price(features)
    }

    /// What a split costs that sends these of the open samples left.
    fn cost_of_open(&self, features: (usize, usize), part: &Part, open: &[i64]) -> i64 {
        self.cost_of_left(features, &sum(&part.left, open))
    }

    /// Try every dichotomy of the open points by a line of the region.
    fn try_dichotomies(
        &mut self,
        features: (usize, usize),
        part: &Part,
        points: &[Vec<u32>],
        dichotomies: &Dichotomies,
    ) {
        let tallies: Vec<Vec<i64>> = points.iter().map(|point| self.samples.tally(point)).collect();
        let below: Vec<Vec<bool>> = dichotomies
            .wanted(&tallies, self.total.len(), |open| self.cost_of_open(features, part, open) < self.current)
            .collect();
        for dichotomy in below {
            let chosen = tallies.iter().zip(&dichotomy).filter(|(_, goes_left)| **goes_left);
            let open = chosen.fold(vec![0; self.total.len()], |before, (tally, _)| sum(&before, tally));
            let cost = self.cost_of_open(features, part, &open);
            if cost >= self.current {
                continue;
            }
            if self.is_stopped() {
                return;
            }
            match realise(
                self.samples.plane,
                features,
                &part.region,
                self.ids,
                (points, &dichotomy),
                &mut self.separability,
            ) {
                Realisation::Line(line) => self.offer(cost, line),
                Realisation::Undecided => self.undecided = self.undecided.min(cost),
                Realisation::Never => {}
            }
        }
    }
}

/// A region with its samples counted.
pub(crate) struct Part {
    region: Region,
    left: Vec<i64>,
    right: Vec<i64>,
    open: Vec<u32>,
    bound: i64,
}

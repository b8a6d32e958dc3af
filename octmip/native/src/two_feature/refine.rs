//! Cells split until their open samples can be parted in a few ways, each of which is tried.

use super::cell::Cell;
use super::ends::{End, end_of};
use super::plane::Plane;
use super::realise::{Realised, realise};
use super::stump::{Candidate, Search};
use super::view::{Line, difference};

impl Search<'_> {
    /// Split a region until nothing in it can win.
    pub(super) fn refine(&mut self, candidate: Candidate) {
        let root = self.part_of(candidate.features, candidate.cell, self.ids, None);
        let mut stack = vec![root];
        while let Some(part) = stack.pop() {
            if part.bound >= self.current || self.is_stopped() {
                continue;
            }
            self.try_center(candidate.features, &part);
            match end_of(self.view.plane, candidate.features, &part.cell, &part.open) {
                End::Parts { points, ways } => {
                    self.close(candidate.features, &part, &points, &ways);
                }
                End::Stuck => self.thin = self.thin.min(part.bound),
                End::Split => {
                    let cells = split(self.view.plane, candidate.features, &part.cell, &part.open, None);
                    let mut parts = cells.map(|cell| self.part_of(candidate.features, cell, &part.open, Some(&part)));
                    if parts[0].bound < parts[1].bound {
                        parts.reverse(); // the better one on top of the stack
                    }
                    stack.extend(parts);
                }
            }
        }
    }

    fn part_of(&self, features: (usize, usize), cell: Cell, ids: &[u32], parent: Option<&Part>) -> Part {
        let zero = || vec![0; self.view.loss.lanes()];
        let mut left = parent.map_or_else(zero, |part| part.left.clone());
        let mut right = parent.map_or_else(zero, |part| part.right.clone());
        let (x, y) = (self.view.plane.column(features.0), self.view.plane.column(features.1));
        let open = cell.sort(x, y, ids, |i, goes_left| {
            self.view.add(if goes_left { &mut left } else { &mut right }, i);
        });
        let may_left = difference(&self.total, &right);
        let may_right = difference(&self.total, &left);
        let bound = self.view.loss.bound(&self.total, &may_left, &may_right, self.need) + self.view.price(features);
        Part { cell, left, right, open, bound }
    }

    fn try_center(&mut self, features: (usize, usize), part: &Part) {
        let (t, r) = part.cell.center();
        let line = Line { features, t, r };
        let mut left = part.left.clone();
        for &i in &part.open {
            if line.sends_left(self.view.plane, i) {
                self.view.add(&mut left, i);
            }
        }
        let cost = self.cost_of_left(features, &left);
        if cost < self.attained && line.is_clear_of(self.view.plane, &part.open) {
            self.offer(cost, line);
        }
    }

    fn cost_of_left(&self, features: (usize, usize), left: &[i64]) -> i64 {
        let right = difference(&self.total, left);
        let cost = self.view.loss.sides(left, &right, self.need);
        cost + self.view.price(features)
    }

    /// Look at every way in which a line of the cell can part its open points.
    fn close(&mut self, features: (usize, usize), part: &Part, points: &[Vec<u32>], ways: &[Vec<bool>]) {
        for way in ways {
            let mut left = part.left.clone();
            for (point, _) in points.iter().zip(way).filter(|(_, goes_left)| **goes_left) {
                for &i in point {
                    self.view.add(&mut left, i);
                }
            }
            let cost = self.cost_of_left(features, &left);
            if cost >= self.current {
                continue;
            }
            if self.is_stopped() {
                return;
            }
            match realise(self.view.plane, features, &part.cell, self.ids, (points, way), &mut self.asked) {
                Realised::Line(line) => self.offer(cost, line),
                Realised::Thin => self.thin = self.thin.min(cost),
                Realised::Never => {}
            }
        }
    }
}

/// A cell with its samples counted.
pub(super) struct Part {
    cell: Cell,
    left: Vec<i64>,
    right: Vec<i64>,
    open: Vec<u32>,
    bound: i64,
}

/// Split a cell in t (at `at`, or in the middle) or in r, whichever leaves fewer samples open.
pub(super) fn split(plane: &Plane, (f, g): (usize, usize), cell: &Cell, open: &[u32], at: Option<f64>) -> [Cell; 2] {
    let (x, y) = (plane.column(f), plane.column(g));
    let (m0, m1) = cell.middle_edge(x, y, open);
    let by_r = cell.split_r(m0, m1);
    if !cell.is_wide() {
        return by_r;
    }
    let by_t = cell.split_t(at.unwrap_or((cell.t0 + cell.t1) / 2.0));
    if !cell.is_high() || Cell::count_open(&by_t, x, y, open) <= Cell::count_open(&by_r, x, y, open) {
        by_t
    } else {
        by_r
    }
}

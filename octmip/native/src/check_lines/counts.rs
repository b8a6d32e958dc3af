//! Where samples lie, and what leaves cost them.

use super::{Cell, Checker, EPS, NO_TREE, Tally};

impl Cell {
    /// The two halves to both sides of t; what the new ends are rounded by is added outside.
    pub(super) fn cut(&self, t: f64) -> [Self; 2] {
        let part = (t - self.t[0]) / (self.t[1] - self.t[0]);
        let low = self.low[0] + part * (self.low[1] - self.low[0]) - EPS / 4.0;
        let high = self.high[0] + part * (self.high[1] - self.high[0]) + EPS / 4.0;
        let half = |s: usize| {
            let mut half = *self;
            (half.t[1 - s], half.low[1 - s], half.high[1 - s]) = (t, low, high);
            half
        };
        [half(0), half(1)]
    }
}

impl Checker<'_> {
    /// The samples left of all lines of a cell, those between, and those right of all of them.
    pub(super) fn sorted(&self, (f, g): (usize, usize), cell: &Cell) -> [Vec<u32>; 3] {
        let mut sorted = [const { Vec::new() }; 3];
        for (i, (x, y)) in self.columns[f].iter().zip(&self.columns[g]).enumerate() {
            let value = cell.t.map(|t| x + t * y);
            let is_left = (0..2).all(|e| value[e] <= cell.low[e] - EPS);
            let is_right = (0..2).all(|e| value[e] >= cell.high[e] + EPS);
            sorted[if is_left { 0 } else { 1 + usize::from(is_right) }].push(i as u32);
        }
        sorted
    }

    pub(super) fn tally(&self, ids: &[u32]) -> Tally {
        let mut tally = vec![0; self.q.n_classes + 1];
        ids.iter().for_each(|&i| self.join(&mut tally, i));
        tally
    }

    pub(super) fn join(&self, tally: &mut [i64], i: u32) {
        tally[self.q.labels[i as usize] as usize] += self.q.weights[i as usize];
        tally[self.q.n_classes] += 1;
    }

    pub(super) fn price(&self, chart: (usize, usize)) -> i64 {
        self.q.penalty * if chart.1 == self.q.p { 1 } else { 2 }
    }

    /// What samples cost when each has the cheapest of some answers.
    pub(super) fn choosing(&self, tally: &[i64], answers: &[usize]) -> i64 {
        let cheapest = |c| answers.iter().map(|&k| self.q.cost(c, k)).min().unwrap_or(0);
        (0..self.q.n_classes).map(|c| tally[c] * cheapest(c)).sum()
    }

    /// What samples cost in one leaf.
    pub(super) fn leaf(&self, tally: &[i64]) -> i64 {
        let answers = 0..self.q.n_classes;
        answers.map(|k| self.choosing(tally, &[k])).min().unwrap_or(0)
    }

    /// The most that samples can cost.
    pub(super) fn most(&self, tally: &[i64]) -> i64 {
        let dearest = |c| (0..self.q.n_classes).map(|k| self.q.cost(c, k)).max().unwrap_or(0);
        (0..self.q.n_classes).map(|c| tally[c] * dearest(c)).sum()
    }

    /// What two children and the samples between them cost at least: a child gives two answers at most, costs what is
    /// known and what its samples cost with these; a sample between has the cheapest of all four.
    pub(super) fn labels_due(&self, costs: [i64; 2], sides: &[Tally; 2], open: &Tally) -> i64 {
        let k = self.q.n_classes;
        let pairs = || (0..k).flat_map(move |a| (a..k).map(move |b| [a, b]));
        let with = |s: usize| {
            let choices = pairs().map(|pair| (costs[s].max(self.choosing(&sides[s], &pair)), pair));
            let mut choices: Vec<_> = choices.collect();
            choices.sort_unstable();
            choices
        };
        let (left, right, mut best) = (with(0), with(1), NO_TREE);
        for (one, a) in left {
            for (other, b) in &right {
                if one + other >= best {
                    break;
                }
                let answers = [a[0], a[1], b[0], b[1]];
                best = best.min(one + other + self.choosing(open, &answers));
            }
        }
        best
    }

    pub(super) fn is_same(&self, (f, g): (usize, usize), i: u32, j: u32) -> bool {
        let at = |f: usize, i: u32| self.columns[f][i as usize];
        at(f, i) == at(f, j) && at(g, i) == at(g, j)
    }

    /// One sample of each different point, the first; no more than `MOST` + 1.
    pub(super) fn distinct(&self, chart: (usize, usize), ids: &[u32], most: usize) -> Vec<u32> {
        let mut points: Vec<u32> = Vec::new();
        for &i in ids {
            if points.len() > most {
                break;
            }
            if !points.iter().any(|&p| self.is_same(chart, p, i)) {
                points.push(i);
            }
        }
        points
    }
}

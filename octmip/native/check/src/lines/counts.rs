//! Cells of lines, and what leaves cost samples.

use super::{Cell, Checker, EPS, NO_TREE, Tally};

impl Cell {
    /// All lines over two features that part the samples at all: no sample's value is beyond 2. On an axis t is 0.
    pub fn whole(is_axis: bool) -> Self {
        let t = if is_axis { [0.0; 2] } else { [-1.0, 1.0] };
        Self { t, low: [-2.25; 2], high: [2.25; 2] }
    }

    /// The lines below and above an edge.
    pub fn split(&self, edge: [f64; 2]) -> [Self; 2] {
        [Self { high: edge, ..*self }, Self { low: edge, ..*self }]
    }

    /// The two halves to both sides of t; what the new ends are rounded by is added outside.
    pub fn cut(&self, t: f64) -> [Self; 2] {
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
}

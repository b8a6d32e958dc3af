//! What the samples in each leaf below a node are worth, kept while samples change sides.
//!
//! A sample of class `y` and weight `w` in a leaf that predicts `k` gains `w * (dearest cost of y - cost of k)`. A
//! leaf predicts the class of largest gain, so minimising cost is maximising the sum of the leaves' largest gains:
//!
//! `objective = sum of all samples' dearest costs - sum over leaves of max_k gain_k + penalty * features in splits`

use crate::problem::Problem;

/// Gains of every class, and what all samples cost at worst.
#[derive(Debug)]
pub struct Prices {
    n_classes: usize,
    /// `gains[y * n_classes + k]`.
    gains: Vec<i64>,
    /// The one class that gains, for each class of sample, where there is just one (0/1 costs): `(k, gain)`.
    single: Option<Vec<(usize, i64)>>,
    labels: Vec<u32>,
    weights: Vec<i64>,
    leaf_size: u32,
    /// Sum of all samples' dearest costs.
    pub dearest: i64,
    /// Price of one feature in one split.
    pub penalty: i64,
}

impl Prices {
    /// The gains of a problem.
    pub fn new(problem: &Problem) -> Self {
        let k = problem.n_classes;
        let rows: Vec<&[i64]> = problem.costs.chunks(k).collect();
        let dearest: Vec<i64> = rows
            .iter()
            .map(|row| row.iter().copied().max().unwrap_or(0))
            .collect();
        let gains: Vec<i64> = rows
            .iter()
            .zip(&dearest)
            .flat_map(|(row, d)| row.iter().map(move |c| d - c))
            .collect();
        let single = gains.chunks(k).map(only_gain).collect();
        let of_sample = |i: usize| problem.weights[i] * dearest[problem.labels[i] as usize];
        Self {
            n_classes: k,
            gains,
            single,
            labels: problem.labels.clone(),
            weights: problem.weights.clone(),
            leaf_size: problem.leaf_size as u32,
            dearest: (0..problem.n).map(of_sample).sum(),
            penalty: problem.penalty,
        }
    }

    /// Class of a sample.
    pub fn label(&self, sample: u32) -> usize {
        self.labels[sample as usize] as usize
    }
}

fn only_gain(row: &[i64]) -> Option<(usize, i64)> {
    let mut positive = row.iter().enumerate().filter(|(_, gain)| **gain > 0);
    let first = positive.next().map_or((0, 0), |(k, gain)| (k, *gain));
    positive.next().is_none().then_some(first)
}

/// How good a placing of samples is: total gain first, then purity, which only breaks ties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worth {
    /// Sum of the leaves' largest gains, less the price of the splits.
    pub gain: i64,
    /// Sum over leaves of the squared gains over their sum: larger when leaves are purer.
    pub purity: f64,
}

impl Worth {
    /// Whether this is better: more gain, or as much and purer by more than rounding.
    pub fn beats(&self, other: &Self) -> bool {
        self.gain > other.gain
            || (self.gain == other.gain
                && self.purity > other.purity + 1e-9 * other.purity.abs().max(1.0))
    }
}

/// Gains of the leaves ("slots") below one node.
#[derive(Debug)]
pub struct Tally<'a> {
    prices: &'a Prices,
    gains: Vec<i64>,
    best: Vec<i64>,
    counts: Vec<u32>,
    /// Sum of `best`.
    pub total: i64,
    short: usize,
}

impl<'a> Tally<'a> {
    /// An empty tally.
    pub fn new(prices: &'a Prices) -> Self {
        Self {
            prices,
            gains: Vec::new(),
            best: Vec::new(),
            counts: Vec::new(),
            total: 0,
            short: 0,
        }
    }

    /// Empty `n_slots` slots.
    pub fn clear(&mut self, n_slots: usize) {
        self.gains.clear();
        self.gains.resize(n_slots * self.prices.n_classes, 0);
        self.best.clear();
        self.best.resize(n_slots, 0);
        self.counts.clear();
        self.counts.resize(n_slots, 0);
        self.total = 0;
        self.short = 0;
    }

    /// Whether every slot that holds samples holds enough of them. An empty one stands for a split that can go.
    pub fn is_large_enough(&self) -> bool {
        self.short == 0
    }

    /// Put a sample into a slot.
    #[inline]
    pub fn add(&mut self, slot: u32, sample: u32) {
        let (slot, k) = (slot as usize, self.prices.n_classes);
        let (label, weight) = (
            self.prices.label(sample),
            self.prices.weights[sample as usize],
        );
        let gains = &mut self.gains[slot * k..(slot + 1) * k];
        let before = self.best[slot];
        let best = match &self.prices.single {
            Some(single) => {
                let (class, gain) = single[label];
                gains[class] += weight * gain;
                before.max(gains[class])
            }
            None => shift(
                gains,
                &self.prices.gains[label * k..(label + 1) * k],
                weight,
            ),
        };
        self.best[slot] = best;
        self.total += best - before;
        self.counts[slot] += 1;
        if self.prices.leaf_size > 1 {
            self.short += usize::from(self.counts[slot] == 1);
            self.short -= usize::from(self.counts[slot] == self.prices.leaf_size);
        }
    }

    /// Take a sample out of a slot.
    #[inline]
    pub fn remove(&mut self, slot: u32, sample: u32) {
        let (slot, k) = (slot as usize, self.prices.n_classes);
        let (label, weight) = (
            self.prices.label(sample),
            self.prices.weights[sample as usize],
        );
        let gains = &mut self.gains[slot * k..(slot + 1) * k];
        let before = self.best[slot];
        let best = match &self.prices.single {
            Some(single) => {
                let (class, gain) = single[label];
                let was_best = gains[class] == before;
                gains[class] -= weight * gain;
                if was_best {
                    gains.iter().copied().max().unwrap_or(0)
                } else {
                    before
                }
            }
            None => shift(
                gains,
                &self.prices.gains[label * k..(label + 1) * k],
                -weight,
            ),
        };
        self.best[slot] = best;
        self.total += best - before;
        if self.prices.leaf_size > 1 {
            self.short += usize::from(self.counts[slot] == self.prices.leaf_size);
            self.short -= usize::from(self.counts[slot] == 1);
        }
        self.counts[slot] -= 1;
    }

    /// Sum over slots of squared gains over their sum. It is convex and homogeneous in the gains, so that a split
    /// never lowers it: with 0/1 costs it ranks cuts as Gini's impurity does.
    pub fn purity(&self) -> f64 {
        let of_slot = |gains: &[i64]| {
            let (sum, square) = gains.iter().fold((0.0, 0.0), |(s, q), &g| {
                (s + g as f64, q + g as f64 * g as f64)
            });
            if sum > 0.0 { square / sum } else { 0.0 }
        };
        self.gains.chunks(self.prices.n_classes).map(of_slot).sum()
    }

    /// Class of largest gain in a slot, the lowest of equals.
    pub fn label(&self, slot: u32) -> u32 {
        let (slot, k) = (slot as usize, self.prices.n_classes);
        let gains = &self.gains[slot * k..(slot + 1) * k];
        gains
            .iter()
            .position(|&gain| gain == self.best[slot])
            .unwrap_or(0) as u32
    }
}

fn shift(gains: &mut [i64], row: &[i64], weight: i64) -> i64 {
    let mut best = i64::MIN;
    for (gain, price) in gains.iter_mut().zip(row) {
        *gain += weight * price;
        best = best.max(*gain);
    }
    best
}

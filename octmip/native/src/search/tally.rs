//! What the samples in each leaf below a node are worth, kept while samples change sides.
//!
//! A sample of class `y` and weight `w` in a leaf that predicts `k` gains `w * (dearest cost of y - cost of k)`. A
//! leaf predicts the class of largest gain, so minimising cost is maximising the sum of the leaves' largest gains:
//!
//! `objective = sum of all samples' dearest costs - sum over leaves of max_k gain_k + penalty * features in splits`

use crate::costs::ClassCosts;
use crate::problem::Problem;
use crate::search::view::Member;

/// Gains of every class, and what a sample costs at worst.
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
    /// Dearest cost of each class of sample.
    dearest: Vec<i64>,
    /// Price of one feature in one split.
    penalty: i64,
    /// More than any tree of one leaf costs.
    above_all: i64,
}

impl Prices {
    /// The gains of a problem.
    pub fn new(problem: &Problem) -> Self {
        let k = problem.n_classes;
        let class_costs = ClassCosts::of(problem);
        let dearest: Vec<i64> = (0..k).map(|class| class_costs.most(class)).collect();
        let gains = (0..k).flat_map(|class| class_costs.gains(class).iter().copied()).collect();
        let single = (0..k).map(|class| class_costs.only_gain(class)).collect();
        let costs =
            problem.weights.iter().zip(&problem.labels).map(|(w, &label)| w.saturating_mul(dearest[label as usize]));
        let above_all = costs.fold(1_i64, i64::saturating_add).min(i64::MAX / 4);
        Self {
            n_classes: k,
            gains,
            single,
            labels: problem.labels.clone(),
            weights: problem.weights.clone(),
            leaf_size: problem.leaf_size as u32,
            dearest,
            penalty: problem.penalty,
            above_all,
        }
    }

    /// Price of so many features in splits; no more than makes a tree worse than one leaf, so that no sum overflows.
    pub fn price(&self, n_features: i64) -> i64 {
        self.penalty.saturating_mul(n_features).min(self.above_all)
    }

    /// Whether features in splits have a price.
    pub fn has_penalty(&self) -> bool {
        self.penalty > 0
    }

    /// What a sample costs at worst on average over the samples.
    pub fn mean_cost(&self) -> f64 {
        (self.above_all - 1) as f64 / self.labels.len() as f64
    }

    /// What a sample costs at worst.
    pub fn dearest_of(&self, sample: u32) -> i64 {
        self.weights[sample as usize] * self.dearest[self.label(sample)]
    }

    /// Weight of a sample.
    pub fn weight(&self, sample: u32) -> i64 {
        self.weights[sample as usize]
    }

    /// Gain of predicting `k` for a sample.
    pub fn gain_of(&self, sample: u32, k: usize) -> i64 {
        self.weights[sample as usize] * self.gains[self.label(sample) * self.n_classes + k]
    }

    /// Add a sample's gain of every class, times a factor.
    pub fn add_gains(&self, sample: u32, factor: f64, gains: &mut [f64]) {
        let weighed = self.weighed(sample);
        let factor = factor * weighed.weight as f64;
        match &self.single {
            Some(single) => {
                let (class, gain) = single[weighed.label as usize];
                gains[class] += factor * gain as f64;
            }
            None => {
                let row = self.row(weighed.label);
                gains.iter_mut().zip(row).for_each(|(sum, &gain)| *sum += factor * gain as f64);
            }
        }
    }

    /// Class and weight of a sample.
    pub fn weighed(&self, sample: u32) -> Weighed {
        Weighed { label: self.labels[sample as usize], weight: self.weights[sample as usize] }
    }

    fn row(&self, label: u32) -> &[i64] {
        &self.gains[label as usize * self.n_classes..][..self.n_classes]
    }

    /// Class of a sample.
    pub fn label(&self, sample: u32) -> usize {
        self.labels[sample as usize] as usize
    }
}

/// What counts of a sample.
#[derive(Debug, Clone, Copy, Default)]
pub struct Weighed {
    /// Class.
    pub label: u32,
    /// Risk weight.
    pub weight: i64,
}

/// The way of a sample that gains in one class only: slots and their cells of that class, left and right.
#[derive(Debug, Clone, Copy)]
pub struct Lane {
    slots: [u32; 2],
    cells: [u32; 2],
    gain: i64,
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
            || (self.gain == other.gain && self.purity > other.purity + 1e-9 * other.purity.abs().max(1.0))
    }
}

/// Gains of the leaves ("slots") below one node.
#[derive(Debug, Clone)]
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
        Self { prices, gains: Vec::new(), best: Vec::new(), counts: Vec::new(), total: 0, short: 0 }
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

    /// Take over what another tally of the same problem holds, without new memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.gains.clone_from(&other.gains);
        self.best.clone_from(&other.best);
        self.counts.clone_from(&other.counts);
        (self.total, self.short) = (other.total, other.short);
    }

    /// Whether every slot that holds samples holds enough of them. An empty one stands for a split that can go.
    pub fn is_large_enough(&self) -> bool {
        self.short == 0
    }

    /// Whether two slots at least hold samples.
    pub fn has_two_sides(&self) -> bool {
        self.counts.iter().filter(|count| **count > 0).count() > 1
    }

    /// Put a sample into a slot.
    #[inline]
    pub fn add(&mut self, slot: u32, sample: Weighed) {
        let (slot, k) = (slot as usize, self.prices.n_classes);
        let gains = &mut self.gains[slot * k..(slot + 1) * k];
        let before = self.best[slot];
        let best = match &self.prices.single {
            Some(single) => {
                let (class, gain) = single[sample.label as usize];
                gains[class] += sample.weight * gain;
                before.max(gains[class])
            }
            None => shift(gains, self.prices.row(sample.label), sample.weight),
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
    pub fn remove(&mut self, slot: u32, sample: Weighed) {
        let (slot, k) = (slot as usize, self.prices.n_classes);
        let gains = &mut self.gains[slot * k..(slot + 1) * k];
        let before = self.best[slot];
        let best = match &self.prices.single {
            Some(single) => {
                let (class, gain) = single[sample.label as usize];
                let was_best = gains[class] == before;
                gains[class] -= sample.weight * gain;
                if was_best { largest(gains) } else { before }
            }
            None => shift(gains, self.prices.row(sample.label), -sample.weight),
        };
        self.best[slot] = best;
        self.total += best - before;
        if self.prices.leaf_size > 1 {
            self.short += usize::from(self.counts[slot] == self.prices.leaf_size);
            self.short -= usize::from(self.counts[slot] == 1);
        }
        self.counts[slot] -= 1;
    }

    /// How each member crosses from right to left where it gains in one class only and leaves may be of any size.
    pub fn lanes(&self, members: &[Member]) -> Option<Vec<Lane>> {
        let single = self.prices.single.as_ref().filter(|_| self.prices.leaf_size <= 1)?;
        let n_classes = self.prices.n_classes as u32;
        let lane = |member: &Member| {
            let (class, gain) = single[member.weighed.label as usize];
            Lane {
                slots: member.slots,
                cells: member.slots.map(|slot| (slot * n_classes) + class as u32),
                gain: gain * member.weighed.weight,
            }
        };
        Some(members.iter().map(lane).collect())
    }

    /// Let a sample cross from right to left; counts of samples are left behind, as no leaf can be too small.
    #[inline(always)]
    pub fn cross(&mut self, lane: &Lane) {
        let [left, right] = lane.slots.map(|slot| slot as usize);
        let [to, from] = lane.cells.map(|cell| cell as usize);
        let before = self.gains[from];
        self.gains[from] = before - lane.gain;
        if before == self.best[right] {
            let k = self.prices.n_classes;
            let best = largest(&self.gains[right * k..(right + 1) * k]);
            self.total += best - before;
            self.best[right] = best;
        }
        self.gains[to] += lane.gain;
        if self.gains[to] > self.best[left] {
            self.total += self.gains[to] - self.best[left];
            self.best[left] = self.gains[to];
        }
    }

    /// Sum over slots of squared gains over their sum. It is convex and homogeneous in the gains, so that a split
    /// never lowers it: with 0/1 costs it ranks cuts as Gini's impurity does.
    pub fn purity(&self) -> f64 {
        let of_slot = |gains: &[i64]| {
            let (sum, square) = gains.iter().fold((0.0, 0.0), |(s, q), &g| (s + g as f64, q + g as f64 * g as f64));
            if sum > 0.0 { square / sum } else { 0.0 }
        };
        self.gains.chunks(self.prices.n_classes).map(of_slot).sum()
    }

    /// Class of largest gain in a slot, the lowest of equals.
    pub fn label(&self, slot: u32) -> u32 {
        let (slot, k) = (slot as usize, self.prices.n_classes);
        let gains = &self.gains[slot * k..(slot + 1) * k];
        gains.iter().position(|&gain| gain == self.best[slot]).unwrap_or(0) as u32
    }
}

#[inline]
fn largest(gains: &[i64]) -> i64 {
    gains.iter().fold(0, |best, &gain| best.max(gain))
}

fn shift(gains: &mut [i64], row: &[i64], weight: i64) -> i64 {
    let mut best = i64::MIN;
    for (gain, price) in gains.iter_mut().zip(row) {
        *gain += weight * price;
        best = best.max(*gain);
    }
    best
}

//! The gains of the samples in each leaf below a node, kept while samples change sides.
//!
//! A sample of class `y` and weight `w` in a leaf that predicts `k` gains `w * (highest cost of y - cost of k)`. A
//! leaf predicts the class of largest gain, so minimising cost is maximising the sum of the leaves' largest gains:
//!
//! `objective = sum of all samples' highest costs - sum over leaves of max_k gain_k + penalty * features in splits`

use crate::gains::prices::{Prices, Weighed};

/// A sample of a view: the slots that it reaches by way of the left (0) and the right (1) child, its class and weight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Member {
    /// Slots by side.
    pub(crate) slots: [u32; 2],
    /// Class and weight.
    pub(crate) weighed: Weighed,
}

impl Member {
    /// Cross to the other side in a tally.
    #[inline]
    pub(crate) fn cross(&self, tally: &mut Tally, is_left: bool) {
        tally.remove(self.slots[usize::from(!is_left)], self.weighed);
        tally.add(self.slots[usize::from(is_left)], self.weighed);
    }
}

/// The way of a sample that gains in one class only: slots and their entries of that class, left and right.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    slots: [u32; 2],
    entries: [u32; 2],
    gain: i64,
}

/// The worth of a placing of samples: total gain first, then purity, which only breaks ties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Worth {
    /// Sum of the leaves' largest gains, less the price of the splits.
    pub(crate) gain: i64,
    /// Sum over leaves of the squared gains over their sum: larger when leaves are purer.
    pub(crate) purity: f64,
}

impl Worth {
    /// Whether this is better: more gain, or as much and purer by more than rounding.
    pub(crate) fn beats(&self, other: &Self) -> bool {
        self.gain > other.gain
            || (self.gain == other.gain && self.purity > other.purity + 1e-9 * other.purity.abs().max(1.0))
    }
}

/// Gains of the leaves ("slots") below one node.
#[derive(Debug, Clone)]
pub(crate) struct Tally<'a> {
    prices: &'a Prices,
    gains: Vec<i64>,
    best: Vec<i64>,
    counts: Vec<u32>,
    /// Sum of `best`.
    pub(crate) total: i64,
    short: usize,
}

impl<'a> Tally<'a> {
    /// An empty tally.
    pub(crate) fn new(prices: &'a Prices) -> Self {
        Self { prices, gains: Vec::new(), best: Vec::new(), counts: Vec::new(), total: 0, short: 0 }
    }

    /// Empty `n_slots` slots.
    pub(crate) fn clear(&mut self, n_slots: usize) {
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
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.gains.clone_from(&other.gains);
        self.best.clone_from(&other.best);
        self.counts.clone_from(&other.counts);
        (self.total, self.short) = (other.total, other.short);
    }

    /// Whether every slot that holds samples holds enough of them. An empty one stands for a split that can go.
    pub(crate) fn is_large_enough(&self) -> bool {
        self.short == 0
    }

    /// Whether two slots at least hold samples.
    pub(crate) fn has_two_sides(&self) -> bool {
        self.counts.iter().filter(|count| **count > 0).count() > 1
    }

    /// Put a sample into a slot.
    #[inline]
    pub(crate) fn add(&mut self, slot: u32, sample: Weighed) {
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
    pub(crate) fn remove(&mut self, slot: u32, sample: Weighed) {
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

    /// The way of each member from right to left, where it gains in one class only and leaves may be of any size.
    pub(crate) fn crossings(&self, members: &[Member]) -> Option<Vec<Crossing>> {
        let single = self.prices.single.as_ref().filter(|_| self.prices.leaf_size <= 1)?;
        let n_classes = self.prices.n_classes as u32;
        let crossing = |member: &Member| {
            let (class, gain) = single[member.weighed.label as usize];
            Crossing {
                slots: member.slots,
                entries: member.slots.map(|slot| (slot * n_classes) + class as u32),
                gain: gain * member.weighed.weight,
            }
        };
        Some(members.iter().map(crossing).collect())
    }

    /// Let a sample cross from right to left; counts of samples are left behind, as no leaf can be too small.
    #[inline(always)]
    pub(crate) fn cross(&mut self, crossing: &Crossing) {
        let [left, right] = crossing.slots.map(|slot| slot as usize);
        let [to, from] = crossing.entries.map(|entry| entry as usize);
        let before = self.gains[from];
        self.gains[from] = before - crossing.gain;
        if before == self.best[right] {
            let k = self.prices.n_classes;
            let best = largest(&self.gains[right * k..(right + 1) * k]);
            self.total += best - before;
            self.best[right] = best;
        }
        self.gains[to] += crossing.gain;
        if self.gains[to] > self.best[left] {
            self.total += self.gains[to] - self.best[left];
            self.best[left] = self.gains[to];
        }
    }

    /// Sum over slots of squared gains over their sum. It is convex and homogeneous in the gains, so that a split
    /// never lowers it: with 0/1 costs it ranks cuts as Gini's impurity does.
    pub(crate) fn purity(&self) -> f64 {
        let of_slot = |gains: &[i64]| {
            let (sum, square) = gains.iter().fold((0.0, 0.0), |(s, q), &g| (s + g as f64, q + g as f64 * g as f64));
            if sum > 0.0 { square / sum } else { 0.0 }
        };
        self.gains.chunks(self.prices.n_classes).map(of_slot).sum()
    }

    /// Class of largest gain in a slot, the lowest of equals.
    pub(crate) fn label(&self, slot: u32) -> u32 {
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

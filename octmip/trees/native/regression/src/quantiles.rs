//! Least sloped error of one constant for a set of targets, while targets are taken away one after the other.
//!
//! The distinct targets form a linked list with the weight of each; a pointer stands at the weighted quantile. Taking a
//! sample away moves the pointer over few targets that are still there, so that all the sets that a feature's cuts
//! leave on one side cost time in proportion to the samples.

use crate::slopes::Slopes;

/// No target.
const NONE: u32 = u32::MAX;

/// Targets of a set of samples: how many samples and which weight each has.
#[derive(Debug, Default, Clone)]
pub(crate) struct Targets {
    counts: Vec<u32>,
    weights: Vec<f64>,
}

impl Targets {
    /// No samples of so many targets.
    pub(crate) fn clear(&mut self, n_targets: usize) {
        self.counts.clear();
        self.counts.resize(n_targets, 0);
        self.weights.clear();
        self.weights.resize(n_targets, 0.0);
    }

    /// Add a sample.
    pub(crate) fn add(&mut self, target: u32, weight: f64) {
        self.counts[target as usize] += 1;
        self.weights[target as usize] += weight;
    }

    /// Take a sample away.
    pub(crate) fn remove(&mut self, target: u32, weight: f64) {
        let target = target as usize;
        self.counts[target] -= 1;
        self.weights[target] = if self.counts[target] == 0 { 0.0 } else { self.weights[target] - weight };
    }
}

/// A set of samples with its weighted quantile: the median where both slopes are equal.
#[derive(Debug, Default, Clone)]
pub(crate) struct Quantiles {
    slopes: Slopes,
    targets: Targets,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The target at the quantile; `NONE` in an empty set.
    at: u32,
    below: f64,
    below_sum: f64,
    total: f64,
    total_sum: f64,
}

impl Quantiles {
    /// Take up a set; `values` are the targets, ascending.
    pub(crate) fn load<const EVEN: bool>(&mut self, slopes: Slopes, targets: &Targets, values: &[f64]) {
        self.slopes = slopes;
        self.targets.clone_from(targets);
        self.next.clear();
        self.next.resize(values.len(), NONE);
        self.previous.clear();
        self.previous.resize(values.len(), NONE);
        (self.total, self.total_sum, self.below, self.below_sum) = (0.0, 0.0, 0.0, 0.0);
        let mut last = NONE;
        self.at = NONE;
        for (v, &value) in values.iter().enumerate().filter(|(v, _)| targets.counts[*v] > 0) {
            match last {
                NONE => self.at = v as u32,
                last => self.next[last as usize] = v as u32,
            }
            self.previous[v] = last;
            last = v as u32;
            self.total += targets.weights[v];
            self.total_sum += targets.weights[v] * value;
        }
        self.balance::<EVEN>(values);
    }

    /// Least error of one constant.
    #[inline]
    pub(crate) fn cost<const EVEN: bool>(&self, values: &[f64]) -> f64 {
        if self.at == NONE {
            return 0.0;
        }
        let quantile = values[self.at as usize];
        let own = self.targets.weights[self.at as usize];
        let above = self.total - self.below - own;
        let above_sum = self.total_sum - self.below_sum - own * quantile;
        let slopes = self.slopes.known::<EVEN>();
        slopes.cost(quantile * self.below - self.below_sum, above_sum - quantile * above).max(0.0)
    }

    /// Take a sample away.
    #[inline]
    pub(crate) fn remove<const EVEN: bool>(&mut self, target: u32, weight: f64, values: &[f64]) {
        let value = values[target as usize];
        self.total -= weight;
        self.total_sum -= weight * value;
        if target < self.at {
            self.below -= weight;
            self.below_sum -= weight * value;
        }
        self.targets.remove(target, weight);
        if self.targets.counts[target as usize] == 0 {
            self.unlink(target, values);
        }
        self.balance::<EVEN>(values);
    }

    fn unlink(&mut self, target: u32, values: &[f64]) {
        let (previous, next) = (self.previous[target as usize], self.next[target as usize]);
        if previous != NONE {
            self.next[previous as usize] = next;
        }
        if next != NONE {
            self.previous[next as usize] = previous;
        }
        if self.at == target {
            self.at = next;
            if next == NONE && previous != NONE {
                self.step_down(previous, values);
            }
        }
    }

    fn step_down(&mut self, to: u32, values: &[f64]) {
        self.at = to;
        self.below -= self.targets.weights[to as usize];
        self.below_sum -= self.targets.weights[to as usize] * values[to as usize];
    }

    /// Move the pointer to where no more than the quantile's share of the weight is below it.
    /// No more than the rest is above it then.
    fn balance<const EVEN: bool>(&mut self, values: &[f64]) {
        if self.at == NONE {
            return;
        }
        let slopes = self.slopes.known::<EVEN>();
        while slopes.is_passed(self.below, self.total) && self.previous[self.at as usize] != NONE {
            self.step_down(self.previous[self.at as usize], values);
        }
        loop {
            let (own, next) = (self.targets.weights[self.at as usize], self.next[self.at as usize]);
            if slopes.is_reached(self.below + own, self.total) || next == NONE {
                return;
            }
            self.below += own;
            self.below_sum += own * values[self.at as usize];
            self.at = next;
        }
    }
}

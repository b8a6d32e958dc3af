//! A set of samples with its weighted quantile, from which samples are taken one by one.

use crate::regression::grid::Samples;
use crate::regression::slopes::Slopes;

const NONE: u32 = u32::MAX;

/// Samples in the order of their targets, by their place in it: a linked list with a pointer at the quantile.
#[derive(Debug, Default, Clone)]
pub(crate) struct Quantiles {
    slopes: Slopes,
    next: Vec<u32>,
    previous: Vec<u32>,
    weights: Vec<i64>,
    targets: Vec<i64>,
    at: u32,
    below: i64,
    below_target: i64,
    total: i64,
    total_target: i64,
}

impl Quantiles {
    /// Take up samples in the order of their targets.
    pub(crate) fn load(&mut self, slopes: Slopes, q: &Samples, set: &[u32]) {
        let n = set.len() as u32;
        let last = |k: u32| if k + 1 < n { k + 1 } else { NONE };
        *self = Self {
            slopes,
            next: (0..n).map(last).collect(),
            previous: (0..n).map(|k| k.checked_sub(1).unwrap_or(NONE)).collect(),
            weights: set.iter().map(|&i| q.weights[i as usize]).collect(),
            targets: set.iter().map(|&i| q.targets[i as usize]).collect(),
            at: if n > 0 { 0 } else { NONE },
            ..Self::default()
        };
        self.total = self.weights.iter().sum();
        self.total_target = self.weights.iter().zip(&self.targets).map(|(w, t)| w * t).sum();
        self.balance();
    }

    /// Least error of one constant for what is left.
    pub(crate) fn cost(&self) -> i64 {
        if self.at == NONE {
            return 0;
        }
        let quantile = self.targets[self.at as usize];
        let above = self.total_target - self.below_target - quantile * (self.total - self.below);
        self.slopes.cost(quantile * self.below - self.below_target, above)
    }

    /// Take the sample at a place away.
    pub(crate) fn remove(&mut self, place: u32) {
        let k = place as usize;
        let (weight, target) = (self.weights[k], self.targets[k]);
        self.total -= weight;
        self.total_target -= weight * target;
        if place < self.at {
            self.below -= weight;
            self.below_target -= weight * target;
        }
        let (previous, next) = (self.previous[k], self.next[k]);
        if previous != NONE {
            self.next[previous as usize] = next;
        }
        if next != NONE {
            self.previous[next as usize] = previous;
        }
        if self.at == place {
            self.at = next;
            if next == NONE && previous != NONE {
                self.step_down(previous);
            }
        }
        self.balance();
    }

    fn step_down(&mut self, to: u32) {
        self.at = to;
        self.below -= self.weights[to as usize];
        self.below_target -= self.weights[to as usize] * self.targets[to as usize];
    }

    /// Move the pointer to where the error rises on both sides: a step down costs `up` for all that is not below, and
    /// saves `down` for all below; a step up the other way round.
    fn balance(&mut self) {
        if self.at == NONE {
            return;
        }
        let Slopes { up, down, .. } = self.slopes;
        while down * self.below > up * (self.total - self.below) && self.previous[self.at as usize] != NONE {
            self.step_down(self.previous[self.at as usize]);
        }
        loop {
            let (own, next) = (self.weights[self.at as usize], self.next[self.at as usize]);
            if down * (self.below + own) >= up * (self.total - self.below - own) || next == NONE {
                return;
            }
            self.below += own;
            self.below_target += own * self.targets[self.at as usize];
            self.at = next;
        }
    }
}

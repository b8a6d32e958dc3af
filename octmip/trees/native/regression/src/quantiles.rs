//! Least sloped errors of one constant left and right of every cut of a feature.
//!
//! The samples of a set, in the order of their targets, form a linked list; a pointer stands at the weighted quantile.
//! One list loses its samples from the first in the order of the feature on, which leaves the sets right of the cuts,
//! another from the last, which leaves those left of them: time in proportion to the samples.
//!
//! Where all weights are equal, the quantile of n samples is the one before which there are j(n), and n - 1 samples
//! have j(n) or j(n) - 1 before theirs. So the pointer stays or goes to a neighbour, as says which side of it the
//! sample was on. That is selected, not branched on: no processor could foresee it.

use crate::slopes::Slopes;

/// Neighbours of each place, before and after it.
type Links = [[u32; 2]];

/// A set of samples in the order of their targets, those of equal ones in any.
///
/// Places begin with 1: at 0 and behind the last there is a target of 0 without weight.
#[derive(Debug, Default, Clone)]
pub(crate) struct Ranked {
    targets: Vec<f64>,
    weights: Vec<f64>,
    /// Sum of the targets before each.
    before: Vec<f64>,
}

impl Ranked {
    /// No samples.
    pub(crate) fn clear(&mut self) {
        for list in [&mut self.targets, &mut self.weights] {
            list.clear();
            list.push(0.0);
        }
    }

    /// Add a sample whose target is none of the lower ones; its place.
    #[inline(always)]
    pub(crate) fn push(&mut self, target: f64, weight: f64) -> u32 {
        self.targets.push(target);
        self.weights.push(weight);
        self.targets.len() as u32 - 1
    }

    /// After the last sample.
    pub(crate) fn end(&mut self) {
        self.push(0.0, 0.0);
        self.before.clear();
        self.before.extend(self.targets.iter().scan(0.0, |sum, target| {
            let before = *sum;
            *sum += target;
            Some(before)
        }));
    }
}

/// The quantile of a set and what its samples below sum to: targets, and weights where these differ.
#[derive(Debug, Clone, Copy)]
struct Pointer {
    at: u32,
    below: f64,
    below_weight: f64,
}

/// Least errors of the sets left and right of each cut of a feature.
#[derive(Debug, Default, Clone)]
pub(crate) struct Quantiles {
    /// Of the first samples, none to all.
    pub(crate) left: Vec<f64>,
    /// Of the others.
    pub(crate) right: Vec<f64>,
    links: [Vec<[u32; 2]>; 2],
    /// Samples of a set, and how many of them are before its quantile, as found last.
    quantile: [usize; 2],
}

impl Quantiles {
    /// Fill in the errors of a set whose samples, in the order of the feature, have these places.
    ///
    /// `weight` is that of every sample where all are equal.
    pub(crate) fn fill<const EVEN: bool>(
        &mut self,
        slopes: Slopes,
        weight: Option<f64>,
        set: &Ranked,
        places: impl DoubleEndedIterator<Item = u32> + Clone,
    ) {
        let n = set.targets.len() - 2;
        for links in &mut self.links {
            links.clear();
            links.extend((0..n as u32 + 2).map(|place| [place.wrapping_sub(1), place + 1]));
        }
        for errors in [&mut self.left, &mut self.right] {
            errors.clear();
            errors.resize(n + 1, 0.0);
        }
        match weight {
            Some(weight) => self.equal::<EVEN>(slopes, weight, set, places),
            None => self.weighted::<EVEN>(slopes, set, places),
        }
    }

    fn equal<const EVEN: bool>(
        &mut self,
        slopes: Slopes,
        weight: f64,
        set: &Ranked,
        places: impl DoubleEndedIterator<Item = u32> + Clone,
    ) {
        // All of one length, so that one check of an index serves them all.
        let size = set.targets.len();
        let (slopes, targets) = (slopes.known::<EVEN>(), &set.targets[..size]);
        let [rightwards, leftwards] = self.links.each_mut().map(|links| &mut links[..size]);
        let (left, right) = (&mut self.left[..size - 1], &mut self.right[..size - 1]);
        let mut n = size - 2;
        if self.quantile[0] != n {
            let mut before = 0;
            while before + 1 < n && !slopes.is_reached((before + 1) as f64, n as f64) {
                before += 1;
            }
            self.quantile = [n, before];
        }
        let mut before = self.quantile[1]; // as many samples before the quantile
        let start = Pointer { at: before as u32 + 1, below: set.before[before + 1], below_weight: 0.0 };
        let mut pointers = [start; 2];
        let mut sums = [set.before[size - 1]; 2];
        let error = |pointer: &Pointer, sum: f64, before: usize, n: usize| {
            let (quantile, after) = (targets[pointer.at as usize], n - before - 1);
            let below = quantile * before as f64 - pointer.below;
            let above = sum - pointer.below - quantile - quantile * after as f64;
            (weight * slopes.cost(below, above)).max(0.0)
        };
        if n > 0 {
            (left[n], right[0]) = (error(&start, sums[0], before, n), error(&start, sums[0], before, n));
        }
        for (k, (first, last)) in places.clone().zip(places.rev()).enumerate() {
            n -= 1;
            if n == 0 {
                break;
            }
            let is_lowered = before > 0 && slopes.is_reached(before as f64, n as f64);
            before -= usize::from(is_lowered);
            for (pointer, links, gone) in [(0, &mut *rightwards, first), (1, &mut *leftwards, last)] {
                sums[pointer] -= targets[gone as usize];
                pointers[pointer].pass(links, targets, gone, is_lowered);
            }
            right[k + 1] = error(&pointers[0], sums[0], before, n);
            left[n] = error(&pointers[1], sums[1], before, n);
        }
    }

    fn weighted<const EVEN: bool>(
        &mut self,
        slopes: Slopes,
        set: &Ranked,
        places: impl DoubleEndedIterator<Item = u32> + Clone,
    ) {
        let Self { left, right, links: [rightwards, leftwards], .. } = self;
        let n = set.targets.len() - 2;
        let slopes = slopes.known::<EVEN>();
        right[0] = Weighted::begin(set, rightwards, slopes).error(slopes);
        left[n] = right[0];
        let mut rest = Weighted::begin(set, rightwards, slopes);
        for (k, gone) in places.clone().take(n.saturating_sub(1)).enumerate() {
            rest.remove(rightwards, gone, slopes);
            right[k + 1] = rest.error(slopes);
        }
        let mut rest = Weighted::begin(set, leftwards, slopes);
        for (k, gone) in places.rev().take(n.saturating_sub(1)).enumerate() {
            rest.remove(leftwards, gone, slopes);
            left[n - k - 1] = rest.error(slopes);
        }
    }
}

/// One of two, without a branch.
#[inline(always)]
fn either(is_first: bool, first: u32, second: u32) -> u32 {
    second ^ ((first ^ second) & u32::from(is_first).wrapping_neg())
}

/// Take a place out of the list.
#[inline(always)]
fn unlink(links: &mut Links, gone: u32) {
    let [before, after] = links[gone as usize];
    links[before as usize][1] = after;
    links[after as usize][0] = before;
}

impl Pointer {
    /// Take a sample away, one of equal weights; `is_lowered`: one sample fewer is to stand before the quantile.
    #[inline(always)]
    fn pass(&mut self, links: &mut Links, targets: &[f64], gone: u32, is_lowered: bool) {
        let (at, [lower, higher]) = (self.at, links[self.at as usize]);
        if is_lowered {
            let is_below = gone < at;
            self.at = either(is_below, at, lower);
            self.below -= targets[either(is_below, gone, lower) as usize];
        } else {
            let is_above = gone > at;
            self.at = either(is_above, at, higher);
            self.below += targets[either(is_above, 0, at) as usize] - targets[either(is_above, 0, gone) as usize];
        }
        unlink(links, gone);
    }
}

/// A set of samples of different weights, its quantile and its sums.
struct Weighted<'a> {
    set: &'a Ranked,
    pointer: Pointer,
    total: f64,
    total_weight: f64,
}

impl<'a> Weighted<'a> {
    fn begin(set: &'a Ranked, links: &Links, slopes: Slopes) -> Self {
        let total = set.targets.iter().zip(&set.weights).map(|(target, weight)| target * weight).sum();
        let pointer = Pointer { at: 1, below: 0.0, below_weight: 0.0 };
        let mut all = Self { set, pointer, total, total_weight: set.weights.iter().sum() };
        all.balance(links, slopes);
        all
    }

    /// Weight and weighted target of a place.
    #[inline(always)]
    fn own(&self, place: u32) -> (f64, f64) {
        let weight = self.set.weights[place as usize];
        (weight, weight * self.set.targets[place as usize])
    }

    /// Least error of one constant.
    #[inline(always)]
    fn error(&self, slopes: Slopes) -> f64 {
        let Pointer { at, below, below_weight } = self.pointer;
        let (quantile, (weight, own)) = (self.set.targets[at as usize], self.own(at));
        let above = self.total - below - own - quantile * (self.total_weight - below_weight - weight);
        slopes.cost(quantile * below_weight - below, above).max(0.0)
    }

    fn remove(&mut self, links: &mut Links, gone: u32, slopes: Slopes) {
        let (weight, own) = self.own(gone);
        self.total_weight -= weight;
        self.total -= own;
        if gone < self.pointer.at {
            self.pointer.below_weight -= weight;
            self.pointer.below -= own;
        }
        unlink(links, gone);
        if gone == self.pointer.at {
            let [before, after] = links[gone as usize];
            if after as usize + 1 < links.len() {
                self.pointer.at = after;
            } else {
                self.step_down(before);
            }
        }
        self.balance(links, slopes);
    }

    fn step_down(&mut self, to: u32) {
        let (weight, own) = self.own(to);
        self.pointer.at = to;
        self.pointer.below_weight -= weight;
        self.pointer.below -= own;
    }

    /// Move the pointer to where no more than the quantile's share of the weight is below it.
    /// No more than the rest is above it then.
    fn balance(&mut self, links: &Links, slopes: Slopes) {
        while slopes.is_passed(self.pointer.below_weight, self.total_weight) {
            match links[self.pointer.at as usize][0] {
                0 => break,
                before => self.step_down(before),
            }
        }
        loop {
            let ((weight, own), after) = (self.own(self.pointer.at), links[self.pointer.at as usize][1]);
            let is_last = after as usize + 1 >= links.len();
            if is_last || slopes.is_reached(self.pointer.below_weight + weight, self.total_weight) {
                return;
            }
            self.pointer.below_weight += weight;
            self.pointer.below += own;
            self.pointer.at = after;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Quantiles, Ranked};
    use crate::slopes::Slopes;

    /// The least error of one constant, by every target as the constant.
    fn least(own: &[(f64, f64)], slopes: Slopes) -> f64 {
        let error = |m: f64| -> f64 { own.iter().map(|(y, w)| w * slopes.most(m - y, y - m)).sum() };
        own.iter().map(|(m, _)| error(*m)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn errors_on_both_sides_of_every_cut_are_those_of_the_best_targets() {
        for seed in 0..2000 {
            let rng = &mut fastrand::Rng::with_seed(seed);
            let (n, n_targets, heaviest) = (rng.usize(1..24), rng.u8(1..40), rng.u8(1..4));
            let is_equal = rng.bool();
            let weight = |rng: &mut fastrand::Rng| f64::from(if is_equal { heaviest } else { rng.u8(0..=heaviest) });
            // In the order of the feature: target and weight.
            let all: Vec<(f64, f64)> = (0..n).map(|_| (f64::from(rng.u8(0..n_targets)) - 9.0, weight(rng))).collect();
            let mut sorted: Vec<usize> = (0..n).collect();
            sorted.sort_by(|&i, &j| all[i].0.total_cmp(&all[j].0));
            let (mut set, mut places) = (Ranked::default(), vec![0; n]);
            set.clear();
            for &i in &sorted {
                places[i] = set.push(all[i].0, all[i].1);
            }
            set.end();
            let (up, down) = [(1.0, 1.0), (9.0, 1.0), (1.0, 9.0), (2.0, 3.0)][seed as usize % 4];
            let (slopes, mut found) = (Slopes { up, down }, Quantiles::default());
            let weight = is_equal.then_some(f64::from(heaviest));
            if slopes.are_even() {
                found.fill::<true>(slopes, weight, &set, places.iter().copied());
            } else {
                found.fill::<false>(slopes, weight, &set, places.iter().copied());
            }
            for k in 0..=n {
                let expected = [&all[..k], &all[k..]].map(|own| if own.is_empty() { 0.0 } else { least(own, slopes) });
                assert_eq!([found.left[k], found.right[k]], expected, "seed {seed}, {k} of {n} samples");
            }
        }
    }
}

//! The bounds of all regions of an interval from its histograms, in the widest vectors of the machine at hand.
//!
//! Plain loops over regions inside `pulp`'s dispatch; integer arithmetic, so every width gives the same numbers.

use pulp::{Simd, WithSimd};

use crate::loss::{INFEASIBLE, Loss};

/// Histograms of one interval, a row of regions for every class (and one of sample counts where leaves have a size).
pub(crate) struct Sweep<'a> {
    pub(crate) loss: &'a Loss,
    pub(crate) total: &'a [i64],
    /// Weights by the first region that a sample may lie in, and by the last.
    pub(crate) low: &'a mut [i64],
    pub(crate) high: &'a mut [i64],
    /// Fewest samples on a side, where it matters.
    pub(crate) need: Option<i64>,
    /// For each region a bound of its lines.
    pub(crate) bounds: &'a mut [i64],
    pub(crate) running: &'a mut [i64],
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        self.accumulate();
        if self.loss.is_uniform() {
            self.bound_uniform();
        } else {
            self.bound_graded();
        }
        if let Some(need) = self.need {
            self.leave_out_small(need);
        }
    }
}

impl Sweep<'_> {
    /// Turn the histograms into the weights that may go left and right of a line of each region.
    #[inline(always)]
    fn accumulate(&mut self) {
        let n = self.bounds.len();
        let rows = self.low.chunks_exact_mut(n).zip(self.high.chunks_exact_mut(n));
        for ((low, high), &total) in rows.zip(self.total) {
            let (mut left, mut right) = (0, total);
            for (low, high) in low.iter_mut().zip(high) {
                left += *low;
                *low = left;
                (*high, right) = (right, right - *high);
            }
        }
    }

    /// All weight less the largest `left[a] + right[b]` over `a != b` (one class alone has one label).
    #[inline(always)]
    fn bound_uniform(&mut self) {
        let (n, k) = (self.bounds.len(), self.loss.k);
        let left: &[i64] = self.low;
        let right: &[i64] = self.high;
        let row = |c: usize| c * n..(c + 1) * n;
        let best = &mut *self.bounds;
        best.fill(0);
        if k == 1 {
            raise(best, &left[row(0)]);
            raise(best, &right[row(0)]);
        }
        self.running.fill(0);
        for b in 1..k {
            raise(self.running, &left[row(b - 1)]);
            raise_by_sum(best, self.running, &right[row(b)]);
        }
        self.running.fill(0);
        for b in (0..k.saturating_sub(1)).rev() {
            raise(self.running, &left[row(b + 1)]);
            raise_by_sum(best, self.running, &right[row(b)]);
        }
        let all: i64 = self.total[..k].iter().sum();
        best.iter_mut().for_each(|best| *best = all - *best);
    }

    /// The least over two labels of what is certain to go left or right, and of the cheaper label for the rest.
    ///
    /// T, L and R of a class in all, possibly left, possibly right: (T - R) l + (T - L) r + (L + R - T) min(l, r).
    #[inline(always)]
    fn bound_graded(&mut self) {
        let (n, k) = (self.bounds.len(), self.loss.k);
        let row = |c: usize| c * n..(c + 1) * n;
        self.bounds.fill(INFEASIBLE);
        for (a, b) in (0..k).flat_map(|a| (0..k).map(move |b| (a, b))).filter(|(a, b)| a != b) {
            let cost = &mut *self.running;
            cost.fill(0);
            for c in 0..k {
                let (l, r) = (self.loss.cost(c, a), self.loss.cost(c, b));
                let (least, total) = (l.min(r), self.total[c]);
                let sides = self.low[row(c)].iter().zip(&self.high[row(c)]);
                for (cost, (left, right)) in cost.iter_mut().zip(sides) {
                    *cost += total * (l + r - least) - right * (l - least) - left * (r - least);
                }
            }
            self.bounds.iter_mut().zip(cost).for_each(|(bound, cost)| *bound = (*bound).min(*cost));
        }
    }

    #[inline(always)]
    fn leave_out_small(&mut self, need: i64) {
        let (n, k) = (self.bounds.len(), self.loss.k);
        let sides = self.low[k * n..].iter().zip(&self.high[k * n..]);
        for (bound, (&left, &right)) in self.bounds.iter_mut().zip(sides) {
            *bound = if left < need || right < need { INFEASIBLE } else { *bound };
        }
    }
}

#[inline(always)]
fn raise(best: &mut [i64], by: &[i64]) {
    best.iter_mut().zip(by).for_each(|(best, by)| *best = if *by > *best { *by } else { *best });
}

#[inline(always)]
fn raise_by_sum(best: &mut [i64], a: &[i64], b: &[i64]) {
    for ((best, a), b) in best.iter_mut().zip(a).zip(b) {
        let sum = a + b;
        *best = if sum > *best { sum } else { *best };
    }
}

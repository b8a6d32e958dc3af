//! The cheapest trees of one split, counted for many parts of the samples side by side.

use std::ops::Add;

use super::checker::{Checker, Orders};

/// Number of parts of the samples that are counted at once.
const LANES: usize = 64;
type Lanes<T> = [T; LANES];

/// A number in a lane: the narrower, the more are counted in one step of the machine.
trait Lane: Copy + Default + Ord + Add<Output = Self> + TryFrom<i64> + Into<i64> {}
impl Lane for i16 {}
impl Lane for i32 {}
impl Lane for i64 {}

impl Checker<'_> {
    /// The cheapest trees of one split at most, on parts of the samples.
    pub(super) fn stumps(&self, orders: &Orders, parts: &[&[u32]]) -> Vec<i64> {
        let count = match self.most {
            ..0x8000 => Self::count::<i16>,
            0x8000..0x8000_0000 => Self::count::<i32>,
            _ => Self::count::<i64>,
        };
        parts.chunks(LANES).flat_map(|parts| count(self, orders, parts)).collect()
    }

    /// The same for as many parts as there are lanes. What a tree costs is what its samples cost when answered worst,
    /// less what the best answers on both sides save of that.
    fn count<T: Lane>(&self, orders: &Orders, parts: &[&[u32]]) -> Vec<i64> {
        let of = |number: i64| T::try_from(number).unwrap_or_default();
        let mut is_in = vec![[of(0); LANES]; self.q.n];
        for (lane, part) in parts.iter().enumerate() {
            part.iter().for_each(|&i| is_in[i as usize][lane] = of(self.most));
        }
        let (ones, leaf) = (vec![vec![(0, 1)]; self.q.n], self.q.leaf_size.min(self.q.n + 1) as i64);
        let mut saved = [of(0); LANES];
        for (f, order) in orders[..self.q.p].iter().enumerate() {
            let (n, backwards) = (order.len(), order.iter().rev().copied().collect::<Vec<u32>>());
            let first = self.saved(order, &is_in, &self.savings);
            let last = self.saved(&backwards, &is_in, &self.savings);
            let sizes = (leaf > 1).then(|| self.saved(order, &is_in, &ones));
            for k in (1..n).filter(|&k| self.is_between(f, order, k)) {
                let (first, last) = (&first[k], &last[n - k]);
                for lane in 0..LANES {
                    let is_wide = |s: &Vec<Lanes<T>>| of(leaf) <= s[k][lane] && s[k][lane] + of(leaf) <= s[n][lane];
                    if sizes.as_ref().is_none_or(is_wide) {
                        saved[lane] = saved[lane].max(first[lane] + last[lane]);
                    }
                }
            }
        }
        let one_leaf = self.saved(&orders[self.q.p], &is_in, &self.savings);
        let cost = |(lane, part): (usize, &&[u32])| {
            let worst: i64 = part.iter().map(|&i| self.worst[i as usize]).sum();
            let split = worst - saved[lane].into() + self.q.penalty;
            split.min(worst - one_leaf[one_leaf.len() - 1][lane].into())
        };
        parts.iter().enumerate().map(cost).collect()
    }

    /// Savings of the best answer to the first samples of an order, to none, one, two and so on, in each part.
    /// More samples never save less by an answer: the most so far is the most.
    fn saved<T: Lane>(&self, order: &[u32], is_in: &[Lanes<T>], by: &[Vec<(usize, i64)>]) -> Vec<Lanes<T>> {
        let mut best = [T::default(); LANES];
        let mut answers = vec![best; self.q.n_classes];
        let mut best_of = Vec::with_capacity(self.q.n + 1);
        best_of.push(best);
        for i in order.iter().map(|&i| i as usize) {
            for &(k, saving) in &by[i] {
                let (answer, is_in) = (&mut answers[k], &is_in[i]);
                let saving = T::try_from(saving).unwrap_or_default();
                for lane in 0..LANES {
                    answer[lane] = answer[lane] + saving.min(is_in[lane]);
                    best[lane] = best[lane].max(answer[lane]);
                }
            }
            best_of.push(best);
        }
        best_of
    }
}

//! The best single splits of parts of the samples, counted one by one, many parts at a time.
//!
//! What a leaf costs is what its samples cost when answered worst, less what its answer saves of
//! that. The most that one answer can save is counted for the first samples of every order and for
//! the last; where these meet is a split. Savings only grow as samples join, so that the most so
//! far is the most of all answers.

use std::ops::{Add, BitAnd};
use std::thread;

use super::{Bound, Orders};
use crate::problem::Problem;

/// So many parts are counted at once, one in each lane of vector registers.
const LANES: usize = 16;
type Lanes<T> = [T; LANES];

/// A whole number in a lane: the narrower, the more fit into a register.
trait Lane: Copy + Default + Ord + Add<Output = Self> + BitAnd<Output = Self> {
    fn of(number: i64) -> Self;
    fn wide(self) -> i64;
}

macro_rules! lane {
    ($($lane:ty),*) => {$(
        impl Lane for $lane {
            fn of(number: i64) -> Self { number as $lane } // chosen to hold the largest sum
            fn wide(self) -> i64 { i64::from(self) }
        }
    )*};
}
lane!(i16, i32, i64);

/// The samples, and what answers to them save of the worst.
pub(super) struct Counter<'a> {
    q: &'a Problem,
    /// What each sample costs when it is answered worst.
    pub(super) dear: Vec<i64>,
    /// What each answer to a class saves, for a weight of one; those that save nothing left out.
    savings: Vec<Vec<(usize, i64)>>,
}

impl<'a> Counter<'a> {
    pub(super) fn new(q: &'a Problem) -> Self {
        let costs = |c| (0..q.n_classes).map(move |k| q.cost(c, k));
        let dearest = |c| costs(c).max().unwrap_or(0);
        let saving = |c| costs(c).map(move |cost| dearest(c) - cost).enumerate();
        let savings = |c| saving(c).filter(|&(_, saving)| saving > 0).collect();
        let dear = |i: usize| q.weights[i] * dearest(q.labels[i] as usize);
        Self {
            q,
            dear: (0..q.n).map(dear).collect(),
            savings: (0..q.n_classes).map(savings).collect(),
        }
    }

    /// Bounds, exact ones, of the trees of one split at most on each of these parts of the samples.
    pub(super) fn stumps(
        &self,
        orders: &Orders,
        leaf: usize,
        parts: &[&[u32]],
        threads: usize,
    ) -> Vec<Bound> {
        let most = self.dear.iter().sum::<i64>().max(self.q.n as i64);
        let count = match most {
            _ if most <= i64::from(i16::MAX) => Self::count::<i16>,
            _ if most <= i64::from(i32::MAX) => Self::count::<i32>,
            _ => Self::count::<i64>,
        };
        let mut bounds = vec![Bound::default(); parts.len()];
        let share = parts.len().div_ceil(LANES * threads) * LANES;
        let work = |parts: &[&[u32]], bounds: &mut [Bound]| {
            let lanes = parts.chunks(LANES).zip(bounds.chunks_mut(LANES));
            lanes.for_each(|(parts, bounds)| count(self, orders, leaf, parts, bounds));
        };
        if threads == 1 {
            work(parts, &mut bounds);
            return bounds;
        }
        thread::scope(|scope| {
            for (parts, bounds) in parts.chunks(share).zip(bounds.chunks_mut(share)) {
                scope.spawn(|| work(parts, bounds));
            }
        });
        bounds
    }

    fn count<T: Lane>(&self, orders: &Orders, leaf: usize, parts: &[&[u32]], bounds: &mut [Bound]) {
        let zero = [T::of(0); LANES];
        let mut is_in = vec![zero; self.q.n];
        for (lane, part) in parts.iter().enumerate() {
            part.iter()
                .for_each(|&i| is_in[i as usize][lane] = T::of(-1));
        }
        let (mut own, mut any) = (zero, zero);
        let has_sizes = leaf > 1;
        let (mut first, mut first_size): (Vec<Lanes<T>>, Vec<Lanes<T>>) = (Vec::new(), Vec::new());
        for (order, ranks) in orders.iter().zip(self.q.ranks.chunks(self.q.n)) {
            first.clear();
            first_size.clear();
            self.join(order.iter(), &is_in, has_sizes, |best, size| {
                first.push(*best);
                first_size.extend(has_sizes.then_some(*size));
            });
            let mut k = order.len();
            self.join(
                order[1.min(k)..].iter().rev(),
                &is_in,
                has_sizes,
                |last, last_size| {
                    k -= 1;
                    if ranks[order[k - 1] as usize] == ranks[order[k] as usize] {
                        return;
                    }
                    let first = &first[k - 1];
                    for lane in 0..LANES {
                        any[lane] = any[lane].max(first[lane] + last[lane]);
                    }
                    for lane in (0..LANES).filter(|_| has_sizes) {
                        if first_size[k - 1][lane].min(last_size[lane]) >= T::of(leaf as i64) {
                            own[lane] = own[lane].max(first[lane] + last[lane]);
                        }
                    }
                },
            );
        }
        let mut one_leaf = zero;
        self.join(orders[self.q.p].iter(), &is_in, false, |best, _| {
            one_leaf = *best
        });
        for (lane, (part, bound)) in parts.iter().zip(bounds).enumerate() {
            let dear: i64 = part.iter().map(|&i| self.dear[i as usize]).sum();
            let one_leaf = dear - one_leaf[lane].wide();
            let cost = |saved: T| one_leaf.min(dear - saved.wide() + self.q.penalty);
            bound.any = cost(any[lane]);
            bound.own = if leaf > 1 { cost(own[lane]) } else { bound.any };
        }
    }

    /// Join samples one by one, and show after each, for each part, what the best answer to those of
    /// it saves, and if asked how many they are.
    fn join<'o, T: Lane>(
        &self,
        order: impl Iterator<Item = &'o u32>,
        is_in: &[Lanes<T>],
        has_sizes: bool,
        mut show: impl FnMut(&Lanes<T>, &Lanes<T>),
    ) {
        let zero = [T::of(0); LANES];
        let (mut best, mut size, mut answers) = (zero, zero, vec![zero; self.q.n_classes]);
        for &i in order {
            let (is_in, class) = (&is_in[i as usize], self.q.labels[i as usize] as usize);
            for &(k, saving) in &self.savings[class] {
                let saving = T::of(saving * self.q.weights[i as usize]);
                let answer = &mut answers[k];
                for lane in 0..LANES {
                    answer[lane] = answer[lane] + (saving & is_in[lane]);
                    best[lane] = best[lane].max(answer[lane]);
                }
            }
            for lane in (0..LANES).filter(|_| has_sizes) {
                size[lane] = size[lane] + (T::of(1) & is_in[lane]);
            }
            show(&best, &size);
        }
    }
}

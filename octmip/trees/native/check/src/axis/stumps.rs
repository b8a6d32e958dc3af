//! The cheapest trees of one split, counted for many cuts of the samples side by side.

use std::ops::{Add, BitAnd, Sub};

use super::checker::{Checker, Orders};

/// Number of cuts whose two sides are counted at once.
const LANES: usize = 64;
type Lanes<T> = [T; LANES];

/// A number in a lane: the narrower, the more are counted in one step of the machine.
trait Lane:
    Copy + Default + Ord + Add<Output = Self> + Sub<Output = Self> + BitAnd<Output = Self> + TryFrom<i64> + Into<i64>
{
}
impl Lane for i16 {}
impl Lane for i32 {}
impl Lane for i64 {}

fn of<T: Lane>(number: i64) -> T {
    T::try_from(number).unwrap_or_default()
}

/// Raise numbers to others that are larger.
fn raise<T: Lane>(most: &mut Lanes<T>, others: &Lanes<T>) {
    most.iter_mut().zip(others).for_each(|(most, other)| *most = *other.max(most));
}

/// Labels that save something of each sample, and how much, one sample after the other.
struct Savings<T> {
    ends: Vec<usize>,
    entries: Vec<(usize, T)>,
}

impl<T: Lane> Savings<T> {
    /// In units that they are whole multiples of.
    fn new<'s>(samples: impl Iterator<Item = &'s [(usize, i64)]>, unit: i64) -> Self {
        let (mut ends, mut entries) = (vec![0], Vec::new());
        for own in samples {
            entries.extend(own.iter().map(|&(label, saving)| (label, of::<T>(saving / unit))));
            ends.push(entries.len());
        }
        Self { ends, entries }
    }

    fn of(&self, sample: u32) -> &[(usize, T)] {
        let i = sample as usize;
        &self.entries[self.ends[i]..self.ends[i + 1]]
    }
}

impl Checker<'_> {
    /// The cheapest trees of one split at most, with leaves of `leaf` samples or more, on sets of the samples and on
    /// what is left outside each set.
    pub(super) fn stumps(&self, orders: &Orders, sets: &[&[u32]], leaf: usize) -> Vec<[i64; 2]> {
        let all = &orders[self.q.p];
        let worst = all.iter().map(|&i| self.worst[i as usize]).sum::<i64>() / self.unit;
        let is_counted = leaf > 1;
        // No sum of savings in the unit, or of samples where these are counted, is larger.
        match worst.max(if is_counted { 2 * self.q.n as i64 + 1 } else { 0 }) {
            ..0x8000 => self.stumps_in::<i16>(orders, sets, leaf),
            0x8000..0x8000_0000 => self.stumps_in::<i32>(orders, sets, leaf),
            _ => self.stumps_in::<i64>(orders, sets, leaf),
        }
    }

    /// The same in numbers of one width, no sum too large for it.
    fn stumps_in<T: Lane>(&self, orders: &Orders, sets: &[&[u32]], leaf: usize) -> Vec<[i64; 2]> {
        let cuts: Vec<Vec<usize>> = (0..self.q.p).map(|f| self.cuts_to_count(f, &orders[f], leaf)).collect();
        let all = &orders[self.q.p];
        let savings = Savings::<T>::new(all.iter().map(|&i| &self.savings[i as usize][..]), self.unit);
        // Samples by their place in the node: what is counted of them lies side by side.
        let mut place = vec![0; self.q.n];
        all.iter().zip(0u32..).for_each(|(&i, k)| place[i as usize] = k);
        let placed = |order: &Vec<u32>| order.iter().map(|&i| place[i as usize]).collect();
        let placed: Orders = orders.iter().map(placed).collect();
        let mut is_in = vec![[of::<T>(0); LANES]; all.len()]; // all bits of a lane, or none
        let mut costs = Vec::with_capacity(sets.len());
        for sets in sets.chunks(LANES) {
            is_in.fill([of(0); LANES]);
            for (lane, set) in sets.iter().enumerate() {
                set.iter().for_each(|&i| is_in[place[i as usize] as usize][lane] = of(-1));
            }
            let saved = self.count(&placed, &cuts, &savings, &is_in, leaf);
            costs.extend(sets.iter().enumerate().map(|(lane, set)| self.costs(all, set, &saved, lane)));
        }
        costs
    }

    /// The cuts of a feature that may be the best of some part of the samples, ascending.
    ///
    /// Where leaves may have any size, a cut between samples of one class is left out. As the cut moves on through a
    /// run of one class, what each label saves on either side moves in a straight line; the most of several straight
    /// lines is convex, and so is the sum of both sides. So inside the run no cut saves more than at both of its ends,
    /// in every part of the samples; and an end of all the samples is no split, but one leaf, which is counted too.
    fn cuts_to_count(&self, f: usize, order: &[u32], leaf: usize) -> Vec<usize> {
        let cuts = (1..order.len()).filter(|&k| self.is_between(f, order, k));
        let ends: Vec<usize> = [0].into_iter().chain(cuts).chain([order.len()]).collect();
        let label = |&i: &u32| self.q.labels[i as usize];
        let only_label = |values: &[usize]| {
            let block = &order[values[0]..values[1]];
            block.iter().all(|i| label(i) == label(&block[0])).then(|| label(&block[0]))
        };
        let is_inside_run = |around: &[usize]| {
            let labels = [only_label(&around[..2]), only_label(&around[1..])];
            leaf == 1 && labels[0].is_some() && labels[0] == labels[1]
        };
        ends.windows(3).filter(|around| !is_inside_run(around)).map(|around| around[1]).collect()
    }

    /// What the best labels save on both sides of the best cut, and of one leaf, inside and outside as many sets as
    /// there are lanes.
    fn count<T: Lane>(
        &self,
        orders: &Orders,
        cuts: &[Vec<usize>],
        savings: &Savings<T>,
        is_in: &[Lanes<T>],
        leaf: usize,
    ) -> [[Lanes<T>; 2]; 2] {
        let mut saved = [[of::<T>(0); LANES]; 2];
        for (order, cuts) in orders.iter().zip(cuts) {
            let (n, mut first, mut c) = (order.len(), Vec::with_capacity(cuts.len()), cuts.len());
            self.saved(order.iter(), cuts, is_in, savings, |best| first.push(*best));
            let is_wide = self.are_wide(order, cuts, is_in, leaf);
            let backwards: Vec<usize> = cuts.iter().rev().map(|k| n - k).collect();
            self.saved(order.iter().rev(), &backwards, is_in, savings, |last| {
                c -= 1;
                for side in 0..2 {
                    let mut both = std::array::from_fn(|lane| first[c][side][lane] + last[side][lane]);
                    if let Some(is_wide) = &is_wide {
                        both = std::array::from_fn(|lane| both[lane] & is_wide[c][side][lane]);
                    }
                    raise(&mut saved[side], &both);
                }
            });
        }
        let all = &orders[self.q.p];
        let mut one_leaf = [[of::<T>(0); LANES]; 2];
        self.saved(all.iter(), &[all.len()], is_in, savings, |best| one_leaf = *best);
        [saved, one_leaf]
    }

    /// The cost of the cheapest trees on a set and outside it: what its samples cost under their most expensive labels,
    /// less what the best labels save of that.
    fn costs<T: Lane>(&self, all: &[u32], set: &[u32], saved: &[[Lanes<T>; 2]; 2], lane: usize) -> [i64; 2] {
        let worst_of = |ids: &[u32]| ids.iter().map(|&i| self.worst[i as usize]).sum::<i64>();
        let inside = worst_of(set);
        let worst = [inside, worst_of(all) - inside];
        [0, 1].map(|side| {
            let [split, leaf] = [0, 1].map(|of| worst[side] - self.unit * saved[of][side][lane].into());
            leaf.min(split + self.q.penalty)
        })
    }

    /// For each cut and side the lanes, all of their bits, in which both leaves hold enough samples; None if any do.
    fn are_wide<T: Lane>(
        &self,
        order: &[u32],
        cuts: &[usize],
        is_in: &[Lanes<T>],
        leaf: usize,
    ) -> Option<Vec<[Lanes<T>; 2]>> {
        let leaf = leaf.min(self.q.n + 1) as i64;
        if leaf == 1 {
            return None;
        }
        let ones = Savings::new((0..self.q.n).map(|_| &[(0, 1)][..]), 1);
        let stops: Vec<usize> = cuts.iter().copied().chain([order.len()]).collect();
        let mut sizes = Vec::with_capacity(stops.len());
        self.saved(order.iter(), &stops, is_in, &ones, |size| sizes.push(*size));
        let all = sizes.pop().unwrap_or([[of(0); LANES]; 2]);
        let is_wide = |size: i64, all: i64| of(if size >= leaf && all - size >= leaf { -1 } else { 0 });
        let wide = |sizes: &[Lanes<T>; 2]| {
            [0, 1].map(|s| std::array::from_fn(|lane| is_wide(sizes[s][lane].into(), all[s][lane].into())))
        };
        Some(sizes.iter().map(wide).collect())
    }

    /// What the best label saves of the first samples of an order, inside and outside each set, after each of these
    /// numbers of samples. What a label saves outside a set is what it saves of all less what it saves inside. More
    /// samples never save less by a label: the most so far is the most of the labels that saved anything since.
    fn saved<'o, T: Lane>(
        &self,
        mut order: impl Iterator<Item = &'o u32>,
        stops: &[usize],
        is_in: &[Lanes<T>],
        by: &Savings<T>,
        mut see: impl FnMut(&[Lanes<T>; 2]),
    ) {
        let mut best = [[of(0); LANES]; 2];
        let (mut all, mut inside) = (vec![of::<T>(0); self.q.n_classes], vec![best[0]; self.q.n_classes]);
        let (mut has_grown, mut grown) = (vec![false; self.q.n_classes], Vec::new());
        let mut n_counted = 0;
        for &stop in stops {
            for &i in order.by_ref().take(stop - n_counted) {
                let is_in = &is_in[i as usize];
                for &(k, saving) in by.of(i) {
                    let (all, inside) = (&mut all[k], &mut inside[k]);
                    *all = *all + saving;
                    inside.iter_mut().zip(is_in).for_each(|(inside, &is_in)| *inside = *inside + (saving & is_in));
                    if !std::mem::replace(&mut has_grown[k], true) {
                        grown.push(k);
                    }
                }
            }
            for k in grown.drain(..) {
                let (all, inside) = (all[k], &inside[k]);
                has_grown[k] = false;
                raise(&mut best[0], inside);
                raise(&mut best[1], &std::array::from_fn(|lane| all - inside[lane]));
            }
            n_counted = stop;
            see(&best);
        }
    }
}

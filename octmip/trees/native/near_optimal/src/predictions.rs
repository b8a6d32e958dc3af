//! Distinct predictions of the trees within a limit: vectors of the labels of all samples, told apart by hashes.
//!
//! A vector is the sum of one pseudo-random number per sample and label. Of two different vectors the sums agree with
//! probability 2^-128. Each node keeps for each of its vectors the least cost of a tree that predicts it: a vector of
//! the whole is within the limit if and only if the cheapest trees of its two parts are.

use std::collections::HashMap;

use crate::cost::Cost;
use crate::counter::Counter;
use crate::stumps::{self, Side};
use octmip_exact::View;

/// Least cost by hash and sensors read.
type Vectors<T> = HashMap<(u128, u128), T>;

fn see<T: Cost>(vectors: &mut Vectors<T>, hash: u128, mask: u128, cost: T) {
    vectors.entry((hash, mask)).and_modify(|least| *least = cost.min(*least)).or_insert(cost);
}

/// Pseudo-random number of a sample and a label (splitmix64, twice).
fn key(sample: u32, label: usize) -> u128 {
    let mix = |seed: u64| {
        let mut z = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let place = (u64::from(sample) << 24 | label as u64) * 2 + 1;
    u128::from(mix(place)) << 64 | u128::from(mix(mix(place + 1)))
}

fn hash(ids: &[u32], label: usize) -> u128 {
    ids.iter().fold(0, |sum, &i| sum.wrapping_add(key(i, label)))
}

impl<T: Cost> Counter<'_, T> {
    /// Number of distinct predictions of the trees up to the limit; None when stopped or a node has more than `most`.
    pub fn n_predictions(&mut self, view: &View, depth: usize, limit: T, most: usize) -> Option<usize> {
        let vectors = self.vectors(view, depth, limit, most)?;
        let mut hashes: Vec<u128> = vectors.into_keys().map(|(hash, _)| hash).collect();
        hashes.sort_unstable();
        hashes.dedup();
        Some(hashes.len())
    }

    fn vectors(&mut self, view: &View, depth: usize, limit: T, most: usize) -> Option<Vectors<T>> {
        let mut vectors = Vectors::new();
        let totals = self.instance.totals_of(view);
        let ids: Vec<u32> = view.ids(&self.instance.samples).collect();
        for label in (0..totals.gains.len()).filter(|&label| totals.leaf(label) <= limit) {
            see(&mut vectors, hash(&ids, label), 0, totals.leaf(label));
        }
        match depth {
            0 => {}
            1 => self.stump_vectors(view, limit, &mut vectors),
            _ => {
                for cut in self.all_cuts(view, depth, limit) {
                    let views = self.split(view, &cut);
                    let bases = [0, 1].map(|side| self.instance.totals_of(&views[side]).base);
                    let rest = limit - self.instance.penalty;
                    let least = [0, 1].map(|side| self.instance.bound(cut.bounds[side], bases[side]));
                    let left = self.vectors(&views[0], depth - 1, rest - least[1], most)?;
                    let right = self.vectors(&views[1], depth - 1, rest - least[0], most)?;
                    self.join_vectors([left, right], self.instance.masks[cut.feature], rest, most, &mut vectors)?;
                }
            }
        }
        (!self.is_stopped() && vectors.len() <= most).then_some(vectors)
    }

    fn join_vectors(
        &self,
        sides: [Vectors<T>; 2],
        mask: u128,
        rest: T,
        most: usize,
        vectors: &mut Vectors<T>,
    ) -> Option<()> {
        let [left, right] = sides;
        let mut ordered: Vec<_> = right.into_iter().collect();
        ordered.sort_unstable_by_key(|&((hash, mask), cost)| (cost, hash, mask));
        for ((hash, read), cost) in left {
            for ((other, also), more) in ordered.iter().take_while(|(_, more)| cost + *more <= rest) {
                let mask = mask | read | also;
                if self.instance.fits(mask) {
                    see(vectors, hash.wrapping_add(*other), mask, self.instance.penalty + cost + *more);
                }
            }
            if vectors.len() > most || self.is_stopped() {
                return None;
            }
        }
        Some(())
    }

    fn stump_vectors(&self, view: &View, limit: T, vectors: &mut Vectors<T>) {
        let instance = self.instance;
        let sides = [Side { totals: instance.totals_of(view), len: view.len, limit }, Side::empty(instance)];
        for f in (0..instance.samples.p).filter(|&f| instance.fits(instance.masks[f])) {
            let (list, ranks) = (view.list(f), instance.samples.ranks_of(f));
            stumps::walk(
                instance,
                f,
                list,
                |_| 0,
                &sides,
                |_, cut, [a, b], cost| {
                    let (left, right) = list.split_at(list.partition_point(|&i| ranks[i as usize] <= cut));
                    see(vectors, hash(left, a).wrapping_add(hash(right, b)), instance.masks[f], cost);
                },
            );
        }
    }
}

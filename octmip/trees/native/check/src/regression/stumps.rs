//! The cheapest trees of one split at most.
//!
//! Sloped errors are whole numbers. A squared error is `Q - S^2 / W` with whole sums Q, S and W, the last two below
//! 2^53. What a cut explains, `S_left^2 / W_left + S_right^2 / W_right`, is computed in float64 in five steps, each
//! rounded by at most 2^-53 of itself, and so is at most the computed number times `1 + 2^-50`.

use crate::regression::grid::Samples;
use crate::regression::quantiles::Quantiles;

/// The best stump of a set, and that with leaves of any size; the feature of the first, None for a leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stump {
    /// No tree of one split at most costs less.
    pub strict: i64,
    /// The same where leaves may be of any size.
    pub relaxed: i64,
    /// Feature of the split.
    pub feature: Option<usize>,
}

/// Sums of weights and weighted targets: whole numbers of float64.
type Pile = (f64, f64);

/// What the splits of all features start from: of squared errors sums of the set, of sloped ones the set with its
/// quantile and the place of each sample in it.
#[derive(Default)]
struct Whole {
    total: Pile,
    square: i128,
    quantiles: Quantiles,
    place: Vec<u32>,
}

impl Samples {
    /// The samples of a side of a cut, in every order.
    pub fn part(&self, orders: &[Vec<u32>], left: &[u32], is_left: bool) -> Vec<Vec<u32>> {
        let mut kept = vec![!is_left; self.n];
        left.iter().for_each(|&i| kept[i as usize] = is_left);
        orders.iter().map(|order| order.iter().copied().filter(|&i| kept[i as usize]).collect()).collect()
    }

    /// Whether the first `k` samples lie below the others, neither part too small for a leaf.
    pub fn is_cut(&self, f: usize, order: &[u32], k: usize) -> bool {
        let rank = |k: usize| self.ranks_of(f)[order[k] as usize];
        (self.leaf_size..=order.len().saturating_sub(self.leaf_size)).contains(&k) && rank(k - 1) != rank(k)
    }

    /// Least error of one constant for samples in the order of their targets.
    pub fn leaf(&self, set: &[u32]) -> i64 {
        self.one_leaf(&self.whole(set))
    }

    fn one_leaf(&self, whole: &Whole) -> i64 {
        if self.slopes.is_some() {
            return self.floor(i128::from(whole.quantiles.cost()));
        }
        self.rest(whole, explained(whole.total))
    }

    fn whole(&self, set: &[u32]) -> Whole {
        let mut whole = Whole::default();
        if let Some(slopes) = self.slopes {
            whole.quantiles.load(slopes, self, set);
            whole.place = vec![0; self.n];
            set.iter().enumerate().for_each(|(k, &i)| whole.place[i as usize] = k as u32);
            return whole;
        }
        for &i in set {
            let (weight, target) = (self.weights[i as usize], self.targets[i as usize]);
            whole.total = self.with(whole.total, i);
            whole.square += i128::from(weight * target) * i128::from(target);
        }
        whole
    }

    /// The cheapest tree of one split at most, the first feature where several are.
    pub fn stump(&self, orders: &[Vec<u32>]) -> Stump {
        let whole = self.whole(&orders[self.p]);
        let leaf = self.one_leaf(&whole);
        let mut best = Stump { strict: leaf, relaxed: leaf, feature: None };
        for f in (0..self.p).filter(|&f| !orders[f].is_empty()) {
            let [strict, relaxed] = self.split_of(f, &orders[f], &whole);
            if strict < best.strict {
                (best.strict, best.feature) = (strict, Some(f));
            }
            best.relaxed = best.relaxed.min(relaxed);
        }
        best
    }

    /// The cheapest split by one feature, and that with leaves of any size.
    pub fn split(&self, f: usize, orders: &[Vec<u32>]) -> [i64; 2] {
        self.split_of(f, &orders[f], &self.whole(&orders[self.p]))
    }

    fn split_of(&self, f: usize, order: &[u32], whole: &Whole) -> [i64; 2] {
        let costs = if self.slopes.is_some() { self.sloped(f, order, whole) } else { self.squared(f, order, whole) };
        costs.map(|cost| cost.saturating_add(self.penalty))
    }

    fn squared(&self, f: usize, order: &[u32], whole: &Whole) -> [i64; 2] {
        let (total, ranks, mut left, mut most) = (whole.total, self.ranks_of(f), (0.0, 0.0), [None::<f64>; 2]);
        for (k, &i) in order.iter().enumerate() {
            if k > 0 && ranks[i as usize] != ranks[order[k - 1] as usize] {
                let found = explained(left) + explained((total.0 - left.0, total.1 - left.1));
                let is_wide = self.leaf_size <= k && k + self.leaf_size <= order.len();
                for most in &mut most[usize::from(!is_wide)..] {
                    *most = Some(most.map_or(found, |most| if most > found { most } else { found }));
                }
            }
            left = self.with(left, i);
        }
        most.map(|most| most.map_or(i64::MAX, |most| self.rest(whole, most)))
    }

    fn sloped(&self, f: usize, order: &[u32], whole: &Whole) -> [i64; 2] {
        let (n, mut quantiles, mut right) = (order.len(), whole.quantiles.clone(), Vec::with_capacity(order.len()));
        for &i in order {
            right.push(quantiles.cost());
            quantiles.remove(whole.place[i as usize]);
        }
        quantiles.clone_from(&whole.quantiles);
        let (ranks, mut least) = (self.ranks_of(f), [i64::MAX; 2]);
        for k in (1..n).rev() {
            quantiles.remove(whole.place[order[k] as usize]);
            if ranks[order[k] as usize] != ranks[order[k - 1] as usize] {
                let cost = self.floor(i128::from(quantiles.cost() + right[k]));
                let is_wide = self.leaf_size <= k && k + self.leaf_size <= n;
                least[usize::from(!is_wide)..].iter_mut().for_each(|least| *least = cost.min(*least));
            }
        }
        least
    }

    fn with(&self, pile: Pile, i: u32) -> Pile {
        let (weight, target) = (self.weights[i as usize], self.targets[i as usize]);
        (pile.0 + weight as f64, pile.1 + (weight * target) as f64)
    }

    /// What is left of the weighted squares, rounded down.
    fn rest(&self, whole: &Whole, explained: f64) -> i64 {
        self.floor(whole.square - (explained * (1.0 + 2f64.powi(-50))).ceil() as i128)
    }
}

/// What one constant explains of weighted squares; without a weight there is no weighted target either.
fn explained((weight, target): Pile) -> f64 {
    target * target / if weight > 0.0 { weight } else { 1.0 }
}

//! The best cut of one feature on either side of a cut of another.

use crate::quantiles::Quantiles;
use crate::samples::Samples;
use crate::sides::Sides;
use crate::view::View;

/// The best cut of a feature for one set of samples, prices of splits left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BestCut {
    /// Least error of a cut with leaves of any size, or of no cut.
    pub(crate) relaxed: f64,
    /// Least error of a cut whose leaves are large enough; +inf where there is none.
    pub(crate) error: f64,
    /// The largest rank left of that cut.
    pub(crate) rank: u32,
}

/// Buffers of scans.
#[derive(Debug, Default)]
pub(crate) struct Scanner {
    /// The samples of a side in the order of the feature.
    items: Vec<Item>,
    quantiles: Quantiles,
}

/// One sample of a side: its place in the order of the targets, its rank of the feature.
#[derive(Debug, Clone, Copy)]
struct Item {
    place: u32,
    rank: u32,
}

impl Scanner {
    /// The best cuts of feature `g` on the sides that are asked for; of the other it may return nothing.
    pub(crate) fn scan(
        &mut self,
        samples: &Samples,
        view: &View,
        g: usize,
        sides: &mut Sides,
        needs: [bool; 2],
    ) -> [BestCut; 2] {
        if samples.slopes.is_none() {
            return squared(samples, view, g, sides);
        }
        let nothing = BestCut { relaxed: 0.0, error: f64::INFINITY, rank: 0 };
        std::array::from_fn(|m| if needs[m] { self.sloped(samples, view, g, sides, m) } else { nothing })
    }

    /// Least errors of one constant left and right of each cut of feature `g`, for the samples of one side.
    pub(crate) fn errors(
        &mut self,
        samples: &Samples,
        view: &View,
        g: usize,
        sides: &mut Sides,
        side: usize,
    ) -> (&[f64], &[f64]) {
        sides.rank(samples, view);
        let (ranks, list) = (samples.ranks_of(g), view.list(g));
        self.items.resize(list.len(), Item { place: 0, rank: 0 });
        let mut n = 0;
        for &i in list {
            let key = sides.keys[i as usize];
            self.items[n] = Item { place: key / 2, rank: ranks[i as usize] };
            n += usize::from(key as usize % 2 == side); // those of the other side are written over
        }
        self.items.truncate(n);
        let places = self.items.iter().map(|item| item.place);
        let slopes = samples.slopes.unwrap_or_default();
        let quantiles = &mut self.quantiles;
        if slopes.are_even() {
            quantiles.fill::<true>(slopes, samples.weight, &sides.ranked[side], places);
        } else {
            quantiles.fill::<false>(slopes, samples.weight, &sides.ranked[side], places);
        }
        (&quantiles.left, &quantiles.right)
    }

    fn sloped(&mut self, samples: &Samples, view: &View, g: usize, sides: &mut Sides, side: usize) -> BestCut {
        self.errors(samples, view, g, sides, side);
        let (items, n) = (&self.items[..], self.items.len());
        let (left, right) = (&self.quantiles.left[..n + 1], &self.quantiles.right[..n + 1]);
        let mut best = BestCut { relaxed: right[0], error: f64::INFINITY, rank: 0 };
        for k in 1..n {
            let error = left[k] + right[k];
            if error >= best.error || items[k - 1].rank == items[k].rank {
                continue;
            }
            best.relaxed = best.relaxed.min(error);
            if k >= samples.leaf_size && n - k >= samples.leaf_size {
                (best.error, best.rank) = (error, items[k - 1].rank);
            }
        }
        best
    }
}

/// Half of a scan of squared errors: what stands left of the cut, on one side of the other cut.
#[derive(Debug, Clone, Copy, Default)]
struct Running {
    weight: f64,
    target: f64,
    count: usize,
    /// Most that a cut explains, leaves of any size: `S_left^2 / W_left + S_right^2 / W_right`.
    relaxed: f64,
    /// The same where the leaves are large enough; below 0 without any.
    explained: f64,
    rank: u32,
}

impl Running {
    #[inline(always)]
    fn judge(&mut self, total: (f64, f64, usize), rank: u32, leaf_size: usize) {
        let (weight, target) = (total.0 - self.weight, total.1 - self.target);
        let is_large = self.count >= leaf_size && total.2 - self.count >= leaf_size;
        let product = self.weight * weight;
        if product > 0.0 {
            let both = self.target * self.target * weight + target * target * self.weight;
            if both > self.relaxed * product {
                self.relaxed = both / product;
            }
            if both > self.explained * product && is_large {
                (self.explained, self.rank) = (both / product, rank);
            }
        } else if is_large && self.count > 0 && self.count < total.2 && self.explained < 0.0 {
            // A side without weight: nothing is explained beyond one leaf.
            let whole = if total.0 > 0.0 { total.1 * total.1 / total.0 } else { 0.0 };
            (self.explained, self.rank) = (whole, rank);
        }
    }
}

fn squared(samples: &Samples, view: &View, g: usize, sides: &Sides) -> [BestCut; 2] {
    let (list, ranks) = (view.list(g), samples.ranks_of(g));
    let totals = [0, 1].map(|m| (sides.sums[m].weight, sides.sums[m].target, sides.counts[m]));
    let whole = totals.map(|(w, s, _)| if w > 0.0 { s * s / w } else { 0.0 });
    let mut running = whole.map(|relaxed| Running { relaxed, explained: -1.0, ..Running::default() });
    let mut is_run = false; // whether the sample before has the same rank
    for (k, &i) in list.iter().enumerate() {
        let i = i as usize;
        let m = sides.of_sample[i] as usize;
        let own = &samples.sums[i];
        running[m].weight += own.weight;
        running[m].target += own.target;
        running[m].count += 1;
        let Some(&next) = list.get(k + 1) else { break };
        if ranks[next as usize] == ranks[i] {
            is_run = true;
            continue;
        }
        running[m].judge(totals[m], ranks[i], samples.leaf_size);
        if std::mem::take(&mut is_run) {
            running[1 - m].judge(totals[1 - m], ranks[i], samples.leaf_size);
        }
    }
    std::array::from_fn(|m| {
        let square = sides.sums[m].square;
        let error = |explained: f64| if explained < 0.0 { f64::INFINITY } else { (square - explained).max(0.0) };
        BestCut { relaxed: error(running[m].relaxed), error: error(running[m].explained), rank: running[m].rank }
    })
}

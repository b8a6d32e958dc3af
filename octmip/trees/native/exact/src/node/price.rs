//! What the price of a split says of a node, whatever its cuts.
//!
//! * levels: a tree of `m` levels has `m` splits or more, and costs their price at least.
//! * labels: a tree of `j` leaves has `j - 1` splits and predicts `j` labels at most, the samples of all others are
//!   lost. Where samples gain in several labels, only the leaf is counted: any other tree costs one price.
//!
//! Both hold for leaves of any size, and the second never falls as samples are added: each term is a price and the
//! cost of the set under as many labels as one likes.

use crate::samples::Samples;
use crate::view::View;

/// Levels that a tree of cost below `upper` may have, if `depth` are allowed.
#[inline]
pub(crate) fn levels_below(upper: i64, penalty: i64, depth: usize) -> usize {
    if penalty == 0 || upper <= 0 { depth } else { depth.min(((upper - 1) / penalty) as usize) }
}

/// Lower bound of trees of at most `more` levels, where trees of at most `levels` cost `lower` or more: they are those,
/// or pay for a split more than these have levels.
#[inline]
pub(crate) fn at_all_levels(lower: i64, levels: usize, more: usize, penalty: i64) -> i64 {
    if more <= levels { lower } else { lower.min(penalty.saturating_mul(levels as i64 + 1)) }
}

/// Least cost of trees of at most `n_leaves` leaves on samples of a total range and gains (`n_labels`), by price and
/// labels alone; the gains are sorted.
#[inline]
fn least_by_labels(samples: &Samples, total_range: i64, gains: &mut [i64], n_leaves: usize) -> i64 {
    let penalty = samples.penalty;
    if !samples.is_single || gains.len() <= 2 {
        let leaf = total_range - gains.iter().copied().max().unwrap_or(0);
        // Two labels in two leaves may cost nothing.
        return if n_leaves == 1 { leaf } else { leaf.min(penalty) };
    }
    gains.sort_unstable_by(|a, b| b.cmp(a));
    let (mut lost, mut prices, mut least) = (total_range, 0, i64::MAX);
    for gain in gains.iter().take(n_leaves) {
        lost -= gain;
        least = least.min(prices + lost);
        prices += penalty;
        if prices >= least {
            break;
        }
    }
    least
}

/// What each side of the cuts of a feature costs at least by price and labels, cut after cut.
pub(crate) struct Prices<'a> {
    samples: &'a Samples,
    view: &'a View,
    n_leaves: usize,
    /// Gains of each label left of the cut.
    pub(crate) gains: Vec<i64>,
    sorted: Vec<i64>,
    /// Of the left and the right child.
    pub(crate) least: [Vec<i64>; 2],
}

impl<'a> Prices<'a> {
    /// Left of all samples; `least` is used again.
    pub(crate) fn new(samples: &'a Samples, view: &'a View, n_leaves: usize, mut least: [Vec<i64>; 2]) -> Self {
        least.iter_mut().for_each(Vec::clear);
        let [gains, sorted] = [0, 0].map(|gain| vec![gain; samples.n_labels]);
        Self { samples, view, n_leaves, gains, sorted, least }
    }

    /// The next cut, with this total range left of it.
    pub(crate) fn push(&mut self, total_range: i64) {
        let (samples, view) = (self.samples, self.view);
        self.sorted.copy_from_slice(&self.gains);
        self.least[0].push(least_by_labels(samples, total_range, &mut self.sorted, self.n_leaves));
        let sides = view.totals.iter().zip(&self.gains);
        self.sorted.iter_mut().zip(sides).for_each(|(rest, (all, left))| *rest = all - left);
        let right = view.total_range - total_range;
        self.least[1].push(least_by_labels(samples, right, &mut self.sorted, self.n_leaves));
    }
}

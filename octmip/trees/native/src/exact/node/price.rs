//! What the price of a split says of a node, whatever its cuts.
//!
//! * levels: a tree of `m` levels has `m` splits or more, and costs their price at least.
//! * labels: a tree of `j` leaves has `j - 1` splits and predicts `j` labels at most, the samples of all others are
//!   lost. Where samples gain in several labels, only the leaf is counted: any other tree costs one price.
//!
//! Both hold for leaves of any size, and the second never falls as samples are added: each term is a price and the
//! cost of the set under as many labels as one likes.

use crate::exact::samples::Samples;

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
pub(crate) fn least_by_labels(samples: &Samples, total_range: i64, gains: &mut [i64], n_leaves: usize) -> i64 {
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

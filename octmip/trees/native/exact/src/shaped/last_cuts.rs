//! Cuts of a node whose sides are leaves.

use crate::samples::Samples;
use crate::view::View;

/// A cut of a node: feature, samples left of it, lower bounds of both sides.
pub(super) type Cut = (usize, usize, [i64; 2]);

/// The cuts of a feature whose sides' best leaves cost less than `target` together.
pub(super) fn last_cuts(samples: &Samples, view: &View, f: usize, target: i64) -> Vec<Cut> {
    let (ranks, list, least) = (samples.ranks_of(f), view.list(f), samples.leaf_size.max(1));
    let mut left = vec![0; samples.n_labels];
    let (mut range, mut cuts) = (0, Vec::new());
    for position in 1..list.len() {
        let before = list[position - 1];
        samples.count(before, 1, &mut left);
        range += samples.ranges[before as usize];
        let is_cut = ranks[before as usize] != ranks[list[position] as usize];
        if !is_cut || position < least || list.len() - position < least {
            continue;
        }
        let most = left.iter().copied().max().unwrap_or(0);
        let rest = view.totals.iter().zip(&left).map(|(all, left)| all - left).max().unwrap_or(0);
        let bounds = [range - most, view.total_range - range - rest];
        if bounds[0] + bounds[1] < target {
            cuts.push((f, position, bounds));
        }
    }
    cuts
}

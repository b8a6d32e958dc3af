//! The most promising cuts of the root, each judged by the exact trees of two levels on both of its sides.

use crate::prepared::Prepared;
use crate::tree::rule::AxisCut;
use octmip_exact::{Samples, best_subtree};
use octmip_frame::effort::Control;

/// Samples that the cuts are judged by, and features that are judged.
const MOST_SAMPLES: usize = 2000;
const MOST_FEATURES: usize = 40;
/// Samples x features that judging one side of a cut may look at.
const WORK_OF_A_SIDE: f64 = 2e6;
/// Cuts judged in all, and of one feature at least and at most.
const CUTS: usize = 100;
const CUTS_OF_A_FEATURE: [usize; 2] = [3, 12];

/// The cuts judged: the best one of each feature, then the others, the most promising first in both.
pub(crate) fn promising(prepared: &Prepared, samples: &Samples, control: &Control, seed: u64) -> Vec<AxisCut> {
    let mut rng = fastrand::Rng::with_seed(seed ^ 0x5EED_0F00);
    let mut chosen: Vec<u32> = (0..prepared.problem.n as u32).collect();
    rng.shuffle(&mut chosen);
    chosen.truncate(MOST_SAMPLES);
    let mut features: Vec<u32> =
        (0..prepared.problem.p as u32).filter(|&f| prepared.problem.allowed[f as usize]).collect();
    rng.shuffle(&mut features);
    features.truncate(MOST_FEATURES);
    let [fewest, most] = CUTS_OF_A_FEATURE;
    let n_cuts = (CUTS / features.len().max(1)).clamp(fewest, most);
    let mut found: Vec<(bool, i64, AxisCut)> = Vec::new();
    for feature in features {
        if control.is_stopped() {
            break; // to set up the trees of one cut of many features takes hundredths of a second
        }
        let judge = |side: &[u32]| cost(prepared, samples, control, side);
        let mut judged = cuts_of(prepared, &mut chosen, feature, n_cuts, control, judge);
        judged.sort_by_key(|(cost, root)| (*cost, root.cut));
        found.extend(judged.into_iter().enumerate().map(|(k, (cost, root))| (k > 0, cost, root)));
    }
    found.sort_by_key(|(is_second, cost, root)| (*is_second, *cost, root.feature, root.cut));
    found.into_iter().map(|(_, _, root)| root).collect()
}

/// Cuts of a feature that part the samples evenly, with the cost of both sides.
fn cuts_of(
    prepared: &Prepared,
    chosen: &mut [u32],
    feature: u32,
    n_cuts: usize,
    control: &Control,
    cost: impl Fn(&[u32]) -> i64,
) -> Vec<(i64, AxisCut)> {
    let ranks = prepared.problem.feature(feature as usize);
    chosen.sort_by_key(|&i| (ranks[i as usize], i));
    let rank_at = |k: usize| ranks[chosen[chosen.len() * k / (n_cuts + 1)] as usize];
    let mut cuts: Vec<u32> = (1..=n_cuts).map(rank_at).collect();
    cuts.dedup();
    let judge = |cut: u32| {
        let (left, right) = chosen.split_at(chosen.partition_point(|&i| ranks[i as usize] <= cut));
        let has_sides = !left.is_empty() && !right.is_empty() && !control.is_stopped();
        has_sides.then(|| (cost(left) + cost(right), AxisCut { feature, cut }))
    };
    cuts.into_iter().filter_map(judge).collect()
}

/// Cost on these samples of the best tree of two levels that a limited search finds.
fn cost(prepared: &Prepared, samples: &Samples, control: &Control, side: &[u32]) -> i64 {
    let levels = (prepared.problem.depth - 1).min(2);
    let most = WORK_OF_A_SIDE / (side.len() * prepared.problem.p) as f64;
    let found = best_subtree(samples, control, side, levels, i64::MAX, 1 + most as u64);
    found.tree.map_or(i64::MAX / 4, |(cost, _)| cost)
}

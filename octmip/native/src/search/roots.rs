//! Which cuts of the root promise most: each judged by the exact trees of two levels on both of its sides.

use crate::exact::effort::Control;
use crate::exact::samples::Samples;
use crate::exact::subtree::best_subtree;
use crate::search::ground::Ground;

/// A cut of the root.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Root {
    /// Feature.
    pub feature: u32,
    /// Largest rank that goes left.
    pub cut: u32,
}

/// Samples that the cuts are judged by.
const MOST_SAMPLES: usize = 600;
/// Samples x features that judging one cut may look at, cuts of the same feature, and features judged.
const WORK_OF_A_SIDE: f64 = 2e6;
const CUTS: usize = 3;
const MOST_FEATURES: usize = 40;

/// The best cut of each feature, the most promising feature first; all with a look at no more than `MOST_SAMPLES`.
pub fn promising(ground: &Ground, samples: &Samples, control: &Control, seed: u64) -> Vec<Root> {
    let mut rng = fastrand::Rng::with_seed(seed ^ 0x5EED_0F00);
    let mut chosen: Vec<u32> = (0..ground.problem.n as u32).collect();
    rng.shuffle(&mut chosen);
    chosen.truncate(MOST_SAMPLES);
    let mut features: Vec<u32> = (0..ground.problem.p as u32).filter(|&f| ground.problem.allowed[f as usize]).collect();
    rng.shuffle(&mut features);
    features.truncate(MOST_FEATURES);
    let levels = (ground.problem.depth - 1).min(2);
    let mut found: Vec<(i64, Root)> = Vec::new();
    for feature in features {
        let ranks = ground.problem.feature(feature as usize);
        chosen.sort_by_key(|&i| (ranks[i as usize], i));
        let best = (1..=CUTS)
            .filter_map(|k| {
                let cut = ranks[chosen[chosen.len() * k / (CUTS + 1)] as usize];
                let n_left = chosen.partition_point(|&i| ranks[i as usize] <= cut);
                let sides = [&chosen[..n_left], &chosen[n_left..]];
                if sides.iter().any(|side| side.is_empty()) {
                    return None;
                }
                let costs = sides.map(|side| {
                    let most = WORK_OF_A_SIDE / (side.len() * ground.problem.p) as f64;
                    let found = best_subtree(samples, control, side, levels, i64::MAX, 1 + most as u64);
                    found.tree.map_or(i64::MAX / 4, |(cost, _)| cost)
                });
                Some((costs[0] + costs[1], Root { feature, cut }))
            })
            .min_by_key(|(cost, root)| (*cost, root.cut));
        found.extend(best);
    }
    found.sort_by_key(|(cost, root)| (*cost, root.feature));
    found.into_iter().map(|(_, root)| root).collect()
}

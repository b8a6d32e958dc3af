//! The features that are left beside those that a path has banned.

use std::sync::Arc;

use crate::samples::Samples;
use crate::shaped::rules::Rules;

/// Sets of banned features that have a search of their own; beyond them that of a smaller set bounds.
const MOST_SETS: usize = 64;

/// The samples with the features that are left beside a set of banned ones.
pub(super) struct Left {
    pub(super) banned: Arc<[bool]>,
    /// Usable features that are left.
    pub(super) columns: Vec<usize>,
    pub(super) samples: Samples,
}

/// The sets of banned features that paths may come to, at most so many, that of the root first.
pub(super) fn sets_of_features(samples: &Samples, rules: &Rules) -> Vec<Left> {
    let bans = rules.bans_of(&samples.features);
    let mut sets: Vec<Arc<[bool]>> = vec![vec![false; samples.p].into()];
    let mut next = 0;
    while next < sets.len() && sets.len() < MOST_SETS {
        let set = sets[next].clone();
        for f in (0..samples.p).filter(|&f| !set[f] && !bans[f].is_empty()) {
            let below = with(&set, &bans[f]);
            if !sets.contains(&below) && sets.len() < MOST_SETS {
                sets.push(below);
            }
        }
        next += 1;
    }
    let left = |banned: Arc<[bool]>| {
        let columns: Vec<usize> = (0..samples.p).filter(|&f| !banned[f]).collect();
        let samples = samples.with_features(&columns);
        Left { banned, columns, samples }
    };
    sets.into_iter().map(left).collect()
}

/// A set of features and some more.
pub(super) fn with(set: &Arc<[bool]>, more: &[usize]) -> Arc<[bool]> {
    if more.iter().all(|&f| set[f]) {
        return set.clone();
    }
    let mut all = set.to_vec();
    more.iter().for_each(|&f| all[f] = true);
    all.into()
}

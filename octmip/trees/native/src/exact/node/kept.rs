//! Results of nodes by their samples: where a split has a price, trees of many levels meet the same samples again and
//! again, by the same cuts in another order, and at every number of levels.

use std::collections::HashMap;

use crate::exact::node::result::{FeatureIncumbent, NodeResult};
use crate::exact::samples::Samples;
use crate::exact::view::View;

/// Samples as bits, and the levels of the trees.
pub(crate) type Key = (Box<[u64]>, usize);

/// Results of nodes, and the order of their features.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    found: HashMap<Key, (NodeResult, Vec<FeatureIncumbent>)>,
    pub(crate) hits: [u64; 32],
    pub(crate) misses: [u64; 32],
}

/// The key of a node.
pub(crate) fn key(samples: &Samples, view: &View, depth: usize) -> Key {
    let mut bits = vec![0; samples.n.div_ceil(64)].into_boxed_slice();
    for i in view.ids(samples) {
        bits[i as usize / 64] |= 1 << (i % 64);
    }
    (bits, depth)
}

impl Kept {
    /// What is known of a node if it answers for trees below `upper`.
    pub(crate) fn find(&mut self, key: &Key, upper: i64) -> Option<(NodeResult, Vec<FeatureIncumbent>)> {
        let found = self.found.get(key).and_then(|(result, incumbents)| {
            let answer = match &result.best {
                Some((cost, _)) if *cost < upper => Some(result.clone()),
                _ if result.lower >= upper => Some(NodeResult::none(result.lower)),
                _ => None,
            };
            answer.map(|answer| (answer, incumbents.clone()))
        });
        if found.is_some() { self.hits[key.1] += 1 } else { self.misses[key.1] += 1 }
        found
    }

    pub(crate) fn clear(&mut self) {
        self.found.clear();
    }

    pub(crate) fn keep(&mut self, key: Key, result: &NodeResult, incumbents: &[FeatureIncumbent]) {
        self.found.insert(key, (result.clone(), incumbents.to_vec()));
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        if std::env::var("KEPT_SHOW").is_ok() {
            for d in 0..32 {
                if self.hits[d] + self.misses[d] > 0 {
                    eprintln!("depth {d}: hits {} misses {}", self.hits[d], self.misses[d]);
                }
            }
        }
    }
}

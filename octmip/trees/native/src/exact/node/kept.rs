//! Results of nodes by their samples: where a split has a price, trees of many levels meet the same samples again, by
//! the same cuts in another order and at every number of levels.

use std::collections::HashMap;

use crate::exact::node::result::{FeatureIncumbent, NodeResult};
use crate::exact::samples::Samples;
use crate::exact::view::View;

/// Bytes of the results that one thread keeps; once they are full nothing more is kept.
pub(crate) const MOST_BYTES: usize = 1 << 24;

/// Bytes of a plan, a key's frame and a place in the table, about.
const FRAME: usize = 256;

/// Samples as bits, and the levels of the trees.
pub(crate) type Key = (Box<[u64]>, usize);

/// A result and the incumbents of the features at the node's root.
pub(crate) type Found = (NodeResult, Vec<FeatureIncumbent>);

/// Results of nodes.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    found: HashMap<Key, Found>,
    bytes: usize,
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
    /// What is known of a node, if it says which tree is the best below `upper`, or that none is.
    pub(crate) fn find(&self, key: &Key, upper: i64) -> Option<Found> {
        let (result, incumbents) = self.found.get(key)?;
        let answer = match &result.best {
            Some((cost, _)) if *cost < upper => result.clone(),
            _ if result.lower >= upper => NodeResult::none(result.lower),
            _ => return None,
        };
        Some((answer, incumbents.clone()))
    }

    /// Keep the result of a search to its end.
    pub(crate) fn keep(&mut self, key: Key, result: &NodeResult, incumbents: &[FeatureIncumbent]) {
        let bytes = size_of_val(&*key.0) + size_of_val(incumbents) + FRAME;
        if self.bytes + bytes <= MOST_BYTES {
            self.bytes += bytes;
            self.found.insert(key, (result.clone(), incumbents.to_vec()));
        }
    }

    /// Forget everything.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}

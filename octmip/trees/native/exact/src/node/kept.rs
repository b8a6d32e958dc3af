//! Results of nodes by their samples: where a split has a price, trees of many levels meet the same samples again, by
//! the same cuts in another order and at every number of levels.
//!
//! The table is one for the whole search, whatever the threads. The search of a cut of the root writes what it finds
//! into a table of its own. That joins the table of all when the cut is entered, in the order in which cuts were
//! chosen, each result with the number of its cut. A search sees of the table of all what had been entered when its own
//! cut was chosen, and nothing later. Which cuts these are depends on that order alone, not on threads or their speed
//! (`frontier`), and so does what fits into the table. By induction over the order every cut is searched by the same
//! steps, and tree, bound and evaluated cuts are the same for any number of threads. Cuts that another process solves
//! see their own results only.

use std::collections::HashMap;
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

use crate::node::price::at_all_levels;
use crate::node::result::{FeatureIncumbent, NodeResult};
use crate::samples::Samples;
use crate::switches::Switches;

/// Bytes of the results that the search of one cut of the root keeps; once they are full nothing more is kept.
pub(crate) const MOST_BYTES_OF_CUT: usize = 1 << 24;

/// The same of all cuts.
pub(crate) const MOST_BYTES: usize = 1 << 27;

/// Bytes of a plan, a key's frame and a place in the table, about.
const FRAME: usize = 256;

/// Samples as bits.
pub(crate) type Key = Box<[u64]>;

/// A result and the incumbents of the features at the node's root.
pub(crate) type Found = (NodeResult, Vec<FeatureIncumbent>);

/// Whether results are kept by searches of trees of so many levels: with three or fewer hardly a node is met again.
pub(crate) fn keeps(samples: &Samples, switches: &Switches, depth: usize) -> bool {
    switches.kept && switches.price && samples.penalty > 0 && depth > 3
}

/// The key of a node.
pub(crate) fn key(samples: &Samples, ids: &[u32]) -> Key {
    let mut bits = vec![0; samples.n.div_ceil(64)].into_boxed_slice();
    for &i in ids {
        bits[i as usize / 64] |= 1 << (i % 64);
    }
    bits
}

/// What a search for trees of at most `depth` levels has shown.
#[derive(Debug)]
struct Fact {
    /// Number of the cut of the root that it was found below; 0 where that is not entered.
    number: usize,
    depth: usize,
    result: NodeResult,
    incumbents: Vec<FeatureIncumbent>,
}

impl Fact {
    /// Whether it tells which tree of at most `depth` levels costs less than `upper`, or that none does; else a bound.
    ///
    /// Trees of more levels than those searched pay for a split more. So the best one is the best at more levels too if
    /// it costs no more than that.
    fn of(&self, depth: usize, upper: i64, price: i64) -> Result<NodeResult, i64> {
        let bound = at_all_levels(self.result.lower, self.depth, depth, price);
        let has_best = self.result.best.is_some() && depth >= self.depth && bound == self.result.lower;
        match bound {
            bound if bound >= upper => Ok(NodeResult::none(bound)),
            _ if has_best => Ok(self.result.clone()),
            bound => Err(bound),
        }
    }
}

/// Results of nodes.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    found: HashMap<Key, Vec<Fact>>,
    bytes: usize,
}

impl Kept {
    /// What the cuts up to a number tell of a node, else a bound.
    fn find(&self, key: &Key, (depth, upper, price): (usize, i64, i64), until: usize) -> Result<Found, i64> {
        let mut least = 0;
        for fact in self.found.get(key).into_iter().flatten().filter(|fact| fact.number <= until) {
            match fact.of(depth, upper, price) {
                Ok(result) => return Ok((result, fact.incumbents.clone())),
                Err(bound) => least = least.max(bound),
            }
        }
        Err(least)
    }

    fn keep(&mut self, key: Key, fact: Fact, most: usize) {
        let bytes = size_of_val(&*key) + size_of_val(&*fact.incumbents) + FRAME;
        if self.bytes + bytes <= most {
            self.bytes += bytes;
            self.found.entry(key).or_default().push(fact);
        }
    }
}

/// The table of all cuts of the root that are entered, and their number.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    all: RwLock<(Kept, usize)>,
}

impl Shared {
    fn read(&self) -> RwLockReadGuard<'_, (Kept, usize)> {
        self.all.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Cuts that are entered.
    pub(crate) fn n_entered(&self) -> usize {
        self.read().1
    }

    /// Take up what the next cut has shown.
    pub(crate) fn enter(&self, own: Kept) {
        let mut all = self.all.write().unwrap_or_else(PoisonError::into_inner);
        let (kept, number) = &mut *all;
        *number += 1;
        // In the order of the keys: which results are kept as the table fills up depends on it.
        let mut found: Vec<(Key, Vec<Fact>)> = own.found.into_iter().collect();
        found.sort_unstable_by(|a, b| a.0.cmp(&b.0));
        for (key, facts) in found {
            for fact in facts {
                kept.keep(key.clone(), Fact { number: *number, ..fact }, MOST_BYTES);
            }
        }
    }
}

/// What the search of a cut of the root sees.
#[derive(Debug, Default)]
pub(crate) struct Seen<'a> {
    shared: Option<&'a Shared>,
    /// Number of the last entered cut that it sees.
    until: usize,
    own: Kept,
}

impl<'a> Seen<'a> {
    /// The table of all cuts, none of which is entered yet.
    pub(crate) fn of(shared: &'a Shared) -> Self {
        Self { shared: Some(shared), ..Self::default() }
    }

    /// Begin with a cut chosen when so many were entered.
    pub(crate) fn begin(&mut self, until: usize) {
        (self.until, self.own) = (until, Kept::default());
    }

    /// Hand out what the cut has shown.
    pub(crate) fn take(&mut self) -> Kept {
        std::mem::take(&mut self.own)
    }

    /// Which tree of at most `depth` levels on a node costs less than `upper`, or that none does; else a bound.
    pub(crate) fn find(&self, key: &Key, depth: usize, upper: i64, price: i64) -> Result<Found, i64> {
        let bound = match self.own.find(key, (depth, upper, price), 0) {
            Err(bound) => bound,
            found => return found,
        };
        let Some(shared) = self.shared else { return Err(bound) };
        shared.read().0.find(key, (depth, upper, price), self.until).map_err(|other| other.max(bound))
    }

    /// Keep the result of a search to its end.
    pub(crate) fn keep(&mut self, key: Key, depth: usize, result: &NodeResult, incumbents: &[FeatureIncumbent]) {
        let fact = Fact { number: 0, depth, result: result.clone(), incumbents: incumbents.to_vec() };
        self.own.keep(key, fact, MOST_BYTES_OF_CUT);
    }
}

//! Exact subtrees as moves: the exact core's best tree of one to three levels on the samples of a node.

use std::collections::HashMap;

use crate::prepared::Prepared;
use crate::tree::rule::Rule;
use crate::tree::state::State;
use octmip_exact::{Samples, best_subtree};
use octmip_frame::effort::Control;
use octmip_frame::tree::{Node, Tree};

/// The solver of one restart's exact subtrees.
pub(crate) struct Blocks<'a> {
    prepared: &'a Prepared<'a>,
    samples: &'a Samples,
    control: &'a Control,
    /// Samples x features that one block of three levels and more may look at before it is given up.
    pub(crate) work: f64,
    /// Costs below which no tree lies, by levels, samples and features, and a tree of that cost where one was found.
    proven: HashMap<Key, (i64, Option<Tree>)>,
    /// The most work that was spent on a block without success, with the cost that it was to beat.
    given_up: HashMap<Key, (f64, i64)>,
    /// The samples as read through the last mask.
    masked: Option<(Vec<bool>, Samples)>,
}

type Key = (usize, u64, Option<Vec<bool>>);

/// The features that may be read; none: all that the problem allows.
pub(crate) type Mask<'m> = Option<&'m [bool]>;

/// Samples x features^2 up to which a block of two levels is worth its time.
const WORTH_TWO: f64 = 3e7;
/// Work of evaluating a cut however few the samples are, in samples x features.
const CUT_ALONE: f64 = 2e4;
/// Factor of the work of a cut where a sample gains in several columns of the cost matrix.
const MANY_COLUMNS: f64 = 8.0;

impl<'a> Blocks<'a> {
    /// Blocks of a problem, given up as soon as `control` says stop.
    pub(crate) fn new(prepared: &'a Prepared<'a>, samples: &'a Samples, control: &'a Control) -> Self {
        Self { prepared, samples, control, work: 0.0, proven: HashMap::new(), given_up: HashMap::new(), masked: None }
    }

    /// The deepest block worth its time on so many samples, `levels` at most.
    pub(crate) fn deepest(&self, n_samples: usize, levels: usize) -> usize {
        let work = n_samples as f64 * (self.prepared.problem.p as f64).powi(2);
        if work <= WORTH_TWO { levels } else { 1 }
    }

    /// Put the best tree of at most `levels` levels in the place of `v` where it costs less; whether it did.
    pub(crate) fn replace(&mut self, state: &mut State, v: u32, levels: usize, mask: Mask) -> bool {
        let samples = state.samples(v);
        let upper = state.cost_below(&self.prepared.prices, v);
        let Some(tree) = self.best(&samples, levels, upper, mask) else {
            return false;
        };
        state.collapse(v);
        state.attach(self.prepared.problem, v, &tree);
        let now = state.cost_below(&self.prepared.prices, v);
        debug_assert!(now < upper, "an exact tree of {levels} levels costs {now}, not below {upper}");
        now < upper
    }

    /// Build below leaf `v`, top down: with r levels left the exact tree of the deepest block allowed, of which the
    /// root is kept (the whole block when it reaches the last level). Leaves that no block improves stay.
    pub(crate) fn look_ahead(&mut self, state: &mut State, v: u32, levels: usize, deepest: usize, mask: Mask) {
        let samples = state.samples(v);
        let block = self.deepest(samples.len(), levels.min(deepest));
        if levels == 0 || samples.is_empty() {
            return;
        }
        let upper = state.cost_below(&self.prepared.prices, v);
        let Some(tree) = self.best(&samples, block, upper, mask) else {
            return;
        };
        if block == levels {
            return state.attach(self.prepared.problem, v, &tree);
        }
        let Node::Split { feature, cut, .. } = tree.nodes[0] else {
            return;
        };
        let [left, right] = state.split(self.prepared.problem, v, Rule::Axis { feature, cut });
        self.look_ahead(state, left, levels - 1, deepest, mask);
        self.look_ahead(state, right, levels - 1, deepest, mask);
    }

    /// Whether a block has shown that no tree of the problem costs less.
    pub(crate) fn has_proven(&self, state: &State, cost: i64) -> bool {
        let key = (self.prepared.problem.depth, fingerprint(state.samples(0).iter()), None);
        self.proven.get(&key).is_some_and(|&(bound, _)| bound >= cost)
    }

    /// The best tree below `upper`; none where an earlier call has shown that there is none, or work ran out.
    fn best(&mut self, samples: &[u32], levels: usize, upper: i64, mask: Mask) -> Option<Tree> {
        let key = (levels, fingerprint(samples.iter()), mask.map(<[bool]>::to_vec));
        let work = if levels < 3 { f64::INFINITY } else { self.work };
        match self.proven.get(&key) {
            Some(&(bound, _)) if bound >= upper => return None,
            Some((_, Some(tree))) => return Some(tree.clone()),
            _ => (),
        }
        let is_vain = self.given_up.get(&key).is_some_and(|&(spent, at)| work <= spent && upper >= at);
        if is_vain || work == 0.0 || self.control.is_stopped() {
            return None;
        }
        let columns = if self.samples.is_single { 1.0 } else { MANY_COLUMNS };
        let of_a_cut = columns * (CUT_ALONE + (samples.len() * self.prepared.problem.p) as f64);
        let most = ((work / of_a_cut) as u64).saturating_add(1);
        let control = self.control;
        let encoded = match mask {
            None => self.samples,
            Some(mask) => self.masked(mask),
        };
        let found = best_subtree(encoded, control, samples, levels, upper, most);
        let (cost, tree) = found.tree.map_or((upper, None), |(cost, tree)| (cost, Some(tree)));
        if found.is_proof {
            self.proven.insert(key, (cost, tree.clone()));
        } else {
            self.given_up.insert(key, (work, cost));
        }
        tree
    }

    fn masked(&mut self, mask: &[bool]) -> &Samples {
        if self.masked.as_ref().is_none_or(|(of, _)| of != mask) {
            let mut problem = self.prepared.problem.clone();
            let open = problem.allowed.iter_mut().zip(mask);
            open.for_each(|(allowed, open)| *allowed &= open);
            self.masked = Some((mask.to_vec(), Samples::new(&problem)));
        }
        self.masked.as_ref().map_or(self.samples, |(_, samples)| samples)
    }
}

/// A number that distinguishes sets of samples, whatever their order. Two sets that share it would cost a move, no
/// more.
pub(crate) fn fingerprint<'s>(samples: impl Iterator<Item = &'s u32>) -> u64 {
    let mixed = |&i: &u32| {
        let z = (u64::from(i) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB)
    };
    samples.map(mixed).fold(0, |sum, mixed| sum.wrapping_add(mixed).wrapping_add(1))
}

//! The whole count: the cuts of the root, feature by feature, then the trees of each, in several threads.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::cost::Cost;
use crate::counter::Counter;
use crate::instance::Instance;
use crate::spectrum::{Counts, Entry, Spectrum, add, entries};
use crate::stumps::{self, Side};
use octmip_exact::{Solved, View};
use octmip_frame::control::{KeepGoing, Limits, Progress, Stop};
use octmip_frame::effort::Control;
use octmip_frame::supervise::Supervision;

/// A cut of the root and the trees that have it; none known where it is open.
#[derive(Debug, Clone)]
pub struct RootCut<T> {
    /// The cut, with bounds of both sides on the grid.
    pub cut: Solved,
    /// Counts of its trees.
    pub trees: Option<Vec<Entry<T>>>,
}

/// What is counted.
#[derive(Debug, Clone)]
pub struct Counted<T> {
    /// Leaves, by cost.
    pub leaves: Vec<Entry<T>>,
    /// Cuts of the root, by feature, then position.
    pub cuts: Vec<RootCut<T>>,
    /// Usable features whose cuts are not all known.
    pub open: Vec<usize>,
    /// Why it ended.
    pub stop: Stop,
    /// Cuts evaluated for bounds.
    pub n_nodes: u64,
}

/// Count all trees up to a cost.
pub fn run<T: Cost>(
    instance: &Instance<T>,
    limit: T,
    n_threads: usize,
    limits: Limits,
    keep_going: KeepGoing<'_>,
) -> Counted<T> {
    Run::new(instance, limit, n_threads, limits).count(keep_going)
}

/// A walk over the cuts of the root, with its limits.
pub(crate) struct Run<'a, T> {
    instance: &'a Instance<T>,
    /// Most that a tree may cost.
    pub(crate) limit: T,
    n_threads: usize,
    supervision: Supervision,
    control: Control,
    /// All samples.
    pub(crate) root: View,
}

impl<'a, T: Cost> Run<'a, T> {
    /// A walk that begins now.
    pub(crate) fn new(instance: &'a Instance<T>, limit: T, n_threads: usize, limits: Limits) -> Self {
        let supervision = Supervision::new(limits);
        let control = Control::reading(supervision.flag());
        Self { instance, limit, n_threads: n_threads.max(1), supervision, control, root: View::root(&instance.samples) }
    }

    /// Why the walk ended.
    pub(crate) fn stop(&self) -> Stop {
        self.supervision.reason().unwrap_or(Stop::Finished)
    }

    /// Cuts evaluated for bounds.
    pub(crate) fn n_evaluated(&self) -> u64 {
        self.control.n_evaluated()
    }

    /// The cuts of the root that trees up to the limit may have, and the usable features whose cuts are not all known.
    pub(crate) fn root_cuts(&self, keep_going: KeepGoing<'_>) -> (Vec<Solved>, Vec<usize>) {
        let (n_features, depth) = (self.instance.samples.p, self.instance.depth);
        let by_feature = self.each(n_features, keep_going, |counter, f| {
            let whole = counter.shallower_bound(&self.root, depth, self.limit);
            counter.cuts(&self.root, depth, self.limit, whole, f..f + 1)
        });
        let open = (0..n_features).filter(|&f| by_feature[f].is_none()).collect();
        let mut cuts: Vec<Solved> = by_feature.into_iter().flatten().flatten().collect();
        cuts.sort_by_key(|cut| (cut.bounds[0] + cut.bounds[1], cut.feature, cut.position));
        (cuts, open)
    }

    fn count(&self, keep_going: KeepGoing<'_>) -> Counted<T> {
        let totals = self.instance.totals_of(&self.root);
        let leaves = Spectrum::new(Counts::new(), &totals, self.limit).entries;
        let (mut cuts, open) = if self.instance.depth == 1 {
            (self.stumps(), Vec::new())
        } else {
            let (cuts, open) = self.root_cuts(&mut *keep_going);
            (self.trees(cuts, keep_going), open)
        };
        cuts.sort_by_key(|known| (known.cut.feature, known.cut.position));
        Counted { leaves, cuts, open, stop: self.stop(), n_nodes: self.n_evaluated() }
    }

    /// The trees of every cut, in the order given.
    fn trees(&self, cuts: Vec<Solved>, keep_going: KeepGoing<'_>) -> Vec<RootCut<T>> {
        let trees = self.each(cuts.len(), keep_going, |counter, k| {
            let mut counts = Counts::new();
            counter.count_cut(&self.root, self.instance.depth, &cuts[k], self.limit, &mut counts);
            entries(counts)
        });
        let known = cuts.into_iter().zip(trees).map(|(cut, trees)| RootCut { cut, trees });
        known.filter(|known| known.trees.as_ref().is_none_or(|trees| !trees.is_empty())).collect()
    }

    /// The trees of one split, which have no cuts below.
    fn stumps(&self) -> Vec<RootCut<T>> {
        let (instance, root) = (self.instance, &self.root);
        let side = Side { totals: instance.totals_of(root), len: root.len, limit: self.limit };
        let mut by_cut = BTreeMap::<(usize, u32), Counts<T>>::new();
        let sides = [side, Side::empty(instance)];
        for f in (0..instance.samples.p).filter(|&f| instance.fits(instance.masks[f])) {
            stumps::walk(
                instance,
                f,
                root.list(f),
                |_| 0,
                &sides,
                |_, cut, _, cost| {
                    let counts = by_cut.entry((f, cut)).or_default();
                    add(counts, cost, instance.masks[f], 1);
                },
            );
        }
        let cut = |f: usize, cut: u32| {
            let ranks = instance.samples.ranks_of(f);
            let position = root.list(f).partition_point(|&i| ranks[i as usize] <= cut);
            Solved { feature: f, position, bounds: [0, 0] }
        };
        by_cut
            .into_iter()
            .map(|((f, rank), counts)| RootCut { cut: cut(f, rank), trees: Some(entries(counts)) })
            .collect()
    }

    /// Do numbered pieces of work in several threads; None where one was not done.
    pub(crate) fn each<R: Send>(
        &self,
        n: usize,
        keep_going: KeepGoing<'_>,
        work: impl Fn(&mut Counter<'_, T>, usize) -> R + Sync,
    ) -> Vec<Option<R>> {
        let next = AtomicUsize::new(0);
        let done = Mutex::new((0..n).map(|_| None).collect::<Vec<Option<R>>>());
        let one = || {
            let mut counter = Counter::new(self.instance, &self.control, &self.root);
            while !counter.is_stopped() {
                let k = next.fetch_add(1, Ordering::Relaxed);
                if k >= n {
                    break;
                }
                let result = work(&mut counter, k);
                if !counter.is_stopped()
                    && let Ok(mut done) = done.lock()
                {
                    done[k] = Some(result);
                }
            }
        };
        self.supervision.run_all(self.n_threads, one, || {
            let state = Progress { seconds: 0.0, objective: i64::MAX, bound: 0, n_nodes: self.control.n_evaluated() };
            self.supervision.poll(&mut *keep_going, state);
            if let Some(reason) = self.supervision.spent(self.control.n_evaluated(), 0.0) {
                self.supervision.stop(reason);
            }
        });
        done.into_inner().unwrap_or_default()
    }
}

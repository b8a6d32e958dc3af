//! Branch and bound to depth 2: intervals of cuts of the root for given labels of the children, the least bound first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

use crate::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use crate::drift::cut::{Prepared, RootCut};
use crate::drift::instance::{Bands, Instance};
use crate::drift::label_sets::LabelSets;
use crate::drift::pairs::close;
use crate::drift::reach::reach;
use crate::drift::shares::WHOLE;
use crate::drift::zones::Zones;
use crate::problem::Problem;
use crate::supervise::Supervision;
use crate::tree::Tree;

/// Bytes of an open interval, roughly.
const NODE_BYTES: f64 = 300.0;

/// The tree of least worst case to depth 2, and a bound. `floor` is a bound that is known beforehand.
pub fn solve(
    problem: &Problem,
    bands: &Bands,
    incumbent: Option<(i64, Tree)>,
    floor: i64,
    limits: Limits,
    n_threads: usize,
    keep_going: KeepGoing<'_>,
) -> Outcome {
    let instance = Instance::new(problem, bands);
    let prepared = Prepared::new(&instance);
    let supervision = Supervision::new(limits);
    let search = Search::new(&prepared, incumbent, floor, &supervision, n_threads.max(1));
    let work = || search.work();
    supervision.run_all(n_threads.max(1), work, || search.poll(&mut *keep_going));
    search.outcome()
}

/// Cuts `lo` to `hi` of a feature at the root, the labels of both children given.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Interval {
    bound: i64,
    sets: usize,
    feature: usize,
    lo: u32,
    hi: u32,
    /// What the left child costs at least at `lo`, and the right one at `hi`, in every mixture.
    children: [Vec<i64>; 2],
}

#[derive(Debug)]
struct State {
    open: BinaryHeap<Reverse<Interval>>,
    /// Bounds of the intervals that threads are at.
    busy: Vec<i64>,
    best: (i64, Tree),
}

struct Search<'a> {
    prepared: &'a Prepared<'a>,
    sets: Vec<([usize; 2], LabelSets)>,
    state: Mutex<State>,
    best: AtomicI64,
    floor: i64,
    n_nodes: AtomicU64,
    supervision: &'a Supervision,
}

impl<'a> Search<'a> {
    fn new(
        prepared: &'a Prepared<'a>,
        incumbent: Option<(i64, Tree)>,
        floor: i64,
        supervision: &'a Supervision,
        n_threads: usize,
    ) -> Self {
        let instance = prepared.instance;
        let (cost, label) = instance.best_leaf();
        let leaf = (cost, Tree::leaf(label as u32));
        let best = incumbent.filter(|(cost, _)| *cost < leaf.0).unwrap_or(leaf);
        let numbers = 0..prepared.pairs.len();
        let both = numbers.clone().flat_map(|a| numbers.clone().map(move |c| [a, c]));
        let sets: Vec<_> =
            both.map(|pairs| (pairs, LabelSets::new(instance, pairs.map(|k| prepared.pairs[k])))).collect();
        let nothing = vec![0; prepared.mixtures.len()];
        let mut open = BinaryHeap::new();
        for (number, (_, set)) in sets.iter().enumerate() {
            for (f, feature) in instance.features.iter().enumerate() {
                let Some((lo, hi)) = feature.window(instance.leaf_size, |_| true) else { continue };
                let children = [nothing.clone(), nothing.clone()];
                let bound = prepared.least_bound(set, prepared.band(set, f, lo, hi), [&nothing, &nothing]);
                open.push(Reverse(Interval { bound, sets: number, feature: f, lo, hi, children }));
            }
        }
        let best_cost = AtomicI64::new(best.0);
        let state = Mutex::new(State { open, busy: vec![i64::MAX; n_threads], best });
        Self { prepared, sets, state, best: best_cost, floor, n_nodes: AtomicU64::new(0), supervision }
    }

    /// What a bound, `WHOLE` times over, must exceed for all its trees to be no better than the best.
    fn target(&self) -> i64 {
        WHOLE * (self.best.load(Ordering::Relaxed) - 1)
    }

    /// Whether no tree of such a bound, `WHOLE` times over, is better than the best: costs are whole numbers.
    fn is_closed(&self, bound: i64) -> bool {
        bound > self.target()
    }

    fn work(&self) {
        let mut zones = Zones::default();
        let Some(place) = self.with_state(|state| {
            let place = state.busy.iter().position(|&bound| bound == i64::MAX)?;
            state.busy[place] = i64::MAX - 1;
            Some(place)
        }) else {
            return;
        };
        while !self.supervision.is_stopped() {
            match self.next(place) {
                Next::Interval(interval) => {
                    let parts = self.part(&interval, &mut zones);
                    if self.supervision.is_stopped() {
                        return; // its bound stays among the busy ones
                    }
                    self.with_state(|state| {
                        state.open.extend(parts.into_iter().map(Reverse));
                        state.busy[place] = i64::MAX - 1;
                    });
                }
                Next::Wait => std::thread::sleep(std::time::Duration::from_micros(50)),
                Next::Done => return,
            }
        }
    }

    fn with_state<T>(&self, look: impl FnOnce(&mut State) -> T) -> T {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        look(&mut state)
    }

    fn next(&self, place: usize) -> Next {
        self.with_state(|state| {
            if self.best.load(Ordering::Relaxed) <= self.floor {
                return Next::Done;
            }
            match state.open.pop() {
                Some(Reverse(interval)) if !self.is_closed(interval.bound) => {
                    state.busy[place] = interval.bound;
                    Next::Interval(interval)
                }
                Some(_) => {
                    state.open.clear();
                    Next::Done
                }
                None if state.busy.iter().all(|&bound| bound >= i64::MAX - 1) => Next::Done,
                None => Next::Wait,
            }
        })
    }

    /// Close the middle cut of an interval; what is left of it on both sides, unless closed too.
    fn part(&self, interval: &Interval, zones: &mut Zones) -> Vec<Interval> {
        let (pairs, sets) = &self.sets[interval.sets];
        let (feature, cut) = (interval.feature, interval.lo + (interval.hi - interval.lo) / 2);
        zones.set(self.prepared.instance, feature, cut);
        let root = RootCut { prepared: self.prepared, sets, pairs: *pairs, feature, cut, zones };
        let children = [0, 1].map(|side| root.child(side));
        self.n_nodes.fetch_add(1, Ordering::Relaxed);
        let costs = [&children[0][..], &children[1][..]];
        let (mut first, mut last) = (cut, cut);
        if self.is_closed(self.prepared.least_bound(sets, root.band(), costs)) {
            (first, last) = reach(&root, costs, self.target(), interval.lo, interval.hi);
        } else {
            let best = || self.best.load(Ordering::Relaxed);
            let is_done = close(&root, costs, &best, &|| self.supervision.is_stopped(), &mut |cost, tree| {
                self.take(cost, tree);
            });
            if !is_done {
                return Vec::new();
            }
        }
        let [left, right] = children;
        let mut parts = Vec::new();
        if first > interval.lo {
            parts.push((interval.lo, first - 1, [interval.children[0].clone(), right]));
        }
        if last < interval.hi {
            parts.push((last + 1, interval.hi, [left, interval.children[1].clone()]));
        }
        let made = parts.into_iter().map(|(lo, hi, children)| {
            let band = self.prepared.band(sets, feature, lo, hi);
            let bound = self.prepared.least_bound(sets, band, [&children[0], &children[1]]).max(interval.bound);
            Interval { bound, sets: interval.sets, feature, lo, hi, children }
        });
        made.filter(|part| !self.is_closed(part.bound)).collect()
    }

    fn take(&self, cost: i64, tree: Tree) {
        self.with_state(|state| {
            if cost < state.best.0 {
                state.best = (cost, tree);
                self.best.store(cost, Ordering::Relaxed);
            }
        });
    }

    /// The best cost, the proven bound and the number of open intervals.
    fn figures(&self) -> (i64, i64, usize) {
        self.with_state(|state| {
            let open = state.open.peek().map_or(i64::MAX, |Reverse(interval)| interval.bound);
            let least = state.busy.iter().copied().filter(|&bound| bound < i64::MAX - 1).fold(open, i64::min);
            let bound = if least == i64::MAX { state.best.0 } else { (least + WHOLE - 1).div_euclid(WHOLE) };
            (state.best.0, bound.max(self.floor).min(state.best.0), state.open.len())
        })
    }

    fn poll(&self, keep_going: KeepGoing<'_>) {
        let (objective, bound, n_open) = self.figures();
        let n_nodes = self.n_nodes.load(Ordering::Relaxed);
        self.supervision.poll(keep_going, Progress { seconds: 0.0, objective, bound, n_nodes });
        let gap = self.supervision.gap_reached((objective - bound) as f64, objective as f64);
        let bytes = n_open as f64 * NODE_BYTES;
        if let Some(reason) = gap.filter(|_| bound < objective).or_else(|| self.supervision.spent(n_nodes, bytes)) {
            self.supervision.stop(reason);
        }
    }

    fn outcome(&self) -> Outcome {
        let (objective, bound, _) = self.figures();
        let is_optimal = bound >= objective;
        let stop = if is_optimal { Stop::Optimal } else { self.supervision.reason().unwrap_or(Stop::Finished) };
        let tree = self.with_state(|state| state.best.1.clone());
        Outcome { tree, objective, bound, stop, n_nodes: self.n_nodes.load(Ordering::Relaxed) }
    }
}

enum Next {
    Interval(Interval),
    Wait,
    Done,
}

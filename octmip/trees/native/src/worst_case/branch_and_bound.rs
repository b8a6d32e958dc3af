//! Branch and bound over the trees of depth 2 of least worst case, the least bound first.
//!
//! A task is an interval `[lo, hi]` of cuts of one feature at the root, with the labels that each child may predict.
//!
//! Theorem (monotone cuts). When the root's cut moves up, the left child takes more samples and the right one fewer. So
//! what the left child costs at least at `lo`, and the right one at `hi`, bounds every tree of the task.
//!
//! 1. `bisected` bounds the middle cut. If no tree there beats the best known one, none does at any near cut that
//!    `reach` names, and both sides of these remain as tasks, with better bounds of one child each.
//! 2. If the middle cut stays open in a narrow interval, the task becomes pairs of intervals, one for each child.
//!    `pruned` drops the pairs that cannot beat the best tree and halves the rest together with the root's interval.
//! 3. `enumerated` looks at all trees of a narrow pair, one by one, and keeps the best.
//!
//! The search ends when the least bound of open and busy tasks reaches the best tree: docs/theory/worst-case.md.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

use crate::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use crate::problem::Problem;
use crate::supervise::Supervision;
use crate::tree::Tree;
use crate::worst_case::bounds::{Bounds, Children, Pair};
use crate::worst_case::boxes::{Cuts, Trees};
use crate::worst_case::cut::{Prepared, RootCut};
use crate::worst_case::instance::{Bands, Instance};
use crate::worst_case::label_sets::LabelSets;
use crate::worst_case::reach::{Losses, reach};
use crate::worst_case::shares::WHOLE;
use crate::worst_case::zones::Zones;

/// An interval of the root becomes pairs when it holds at most one in so many cuts of its feature.
const ROOT_CUTS_BY_CUTS_OF_PAIRS: u32 = 32;
/// Most cuts of an interval of the root whose trees are looked at one by one.
const MOST_ENUMERATED_CUTS: u32 = 24;
/// A child's interval is halved while it holds more than so many times the cuts of the root's.
const MOST_CHILD_CUTS_BY_ROOT_CUTS: u32 = 2;
/// The bound in `State::busy` of a thread that works on nothing, and of a place that no thread has taken.
const IDLE: i64 = i64::MAX - 1;
const UNTAKEN: i64 = i64::MAX;

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
    let children = Children::new(&instance);
    let search = Search::new(&prepared, &children, incumbent, floor, &supervision, n_threads.max(1));
    let work = || search.work();
    supervision.run_all(n_threads.max(1), work, || search.poll(&mut *keep_going));
    search.outcome()
}

/// An interval of cuts of the root, and what is known of the children there.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Task {
    /// `WHOLE` times over.
    bound: i64,
    sets: usize,
    root: Cuts,
    children: OfChildren,
}

/// What is known of the children.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum OfChildren {
    /// What the left child costs at least at the lowest cut, and the right one at the highest, in every mixture.
    Bounds([Vec<i64>; 2]),
    /// The pairs that are not closed.
    Pairs(Vec<Pair>),
}

impl Task {
    /// The number of its pairs, 1 for all.
    fn size(&self) -> usize {
        if let OfChildren::Pairs(pairs) = &self.children { pairs.len() } else { 1 }
    }
}

#[derive(Debug)]
struct State {
    open: BinaryHeap<Reverse<Task>>,
    /// For each thread the bound of the task that it works on, `IDLE` or `UNTAKEN`.
    busy: Vec<i64>,
    best: (i64, Tree),
    n_pairs: usize,
}

struct Search<'a> {
    prepared: &'a Prepared<'a>,
    children: &'a Children<'a>,
    /// All pairs of sets of two labels: their numbers, the sets, what moves of samples may lose.
    sets: Vec<([usize; 2], LabelSets, [Losses; 2])>,
    state: Mutex<State>,
    best: AtomicI64,
    floor: i64,
    n_nodes: AtomicU64,
    supervision: &'a Supervision,
}

impl<'a> Search<'a> {
    fn new(
        prepared: &'a Prepared<'a>,
        children: &'a Children<'a>,
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
        let of = |pairs: [usize; 2]| {
            let sets = LabelSets::new(instance, pairs.map(|k| prepared.pairs[k]));
            let losses = [false, true].map(|is_up| Losses::new(prepared, &sets, is_up));
            (pairs, sets, losses)
        };
        let sets: Vec<_> = both.map(of).collect();
        let mut open = BinaryHeap::new();
        for (number, (_, set, _)) in sets.iter().enumerate() {
            for (feature, own) in instance.features.iter().enumerate() {
                let Some((lo, hi)) = own.window(instance.leaf_size, |_| true) else { continue };
                let nothing = [0, 1].map(|_| vec![0; prepared.mixtures.len()]);
                let bound = prepared.least_bound(set, prepared.band(set, feature, lo, hi), [&nothing[0], &nothing[1]]);
                let root = Cuts { feature, lo, hi };
                open.push(Reverse(Task { bound, sets: number, root, children: OfChildren::Bounds(nothing) }));
            }
        }
        let best_cost = AtomicI64::new(best.0);
        let n_pairs = open.len();
        let state = Mutex::new(State { open, busy: vec![UNTAKEN; n_threads], best, n_pairs });
        Self { prepared, children, sets, state, best: best_cost, floor, n_nodes: AtomicU64::new(0), supervision }
    }

    /// What a bound, `WHOLE` times over, must exceed for all its trees to be no better than the best.
    fn target(&self) -> i64 {
        WHOLE * (self.best() - 1)
    }

    fn best(&self) -> i64 {
        self.best.load(Ordering::Relaxed)
    }

    /// Whether no tree of such a bound, `WHOLE` times over, is better than the best: costs are whole numbers.
    fn is_closed(&self, bound: i64) -> bool {
        bound > self.target()
    }

    fn work(&self) {
        let mut zones = Zones::default();
        let Some(place) = self.with_state(|state| {
            let place = state.busy.iter().position(|&bound| bound == UNTAKEN)?;
            state.busy[place] = IDLE;
            Some(place)
        }) else {
            return;
        };
        while !self.supervision.is_stopped() {
            match self.next(place) {
                Next::Task(task) => {
                    let parts = match task.children {
                        OfChildren::Bounds(ref children) => self.bisected(&task, children, &mut zones),
                        OfChildren::Pairs(ref pairs) => self.pruned(&task, pairs),
                    };
                    if self.supervision.is_stopped() {
                        return; // its bound stays among the busy ones
                    }
                    self.with_state(|state| {
                        state.n_pairs += parts.iter().map(Task::size).sum::<usize>();
                        state.open.extend(parts.into_iter().map(Reverse));
                        state.busy[place] = IDLE;
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
                Some(Reverse(task)) if !self.is_closed(task.bound) => {
                    state.busy[place] = task.bound;
                    state.n_pairs -= task.size();
                    Next::Task(task)
                }
                Some(_) => {
                    state.open.clear();
                    Next::Done
                }
                None if state.busy.iter().all(|&bound| bound >= IDLE) => Next::Done,
                None => Next::Wait,
            }
        })
    }

    /// The tasks that remain of an interval after its middle cut is bounded.
    fn bisected(&self, task: &Task, known: &[Vec<i64>; 2], zones: &mut Zones) -> Vec<Task> {
        let (pairs, sets, losses) = &self.sets[task.sets];
        let (feature, cut) = (task.root.feature, task.root.lo + (task.root.hi - task.root.lo) / 2);
        zones.set(self.prepared.instance, feature, cut);
        let root = RootCut { prepared: self.prepared, sets, pairs: *pairs, feature, cut, zones };
        let children = [0, 1].map(|side| root.child(side));
        self.n_nodes.fetch_add(1, Ordering::Relaxed);
        let costs = [&children[0][..], &children[1][..]];
        let Cuts { lo, hi, .. } = task.root;
        let mut ends = [Cuts { hi: cut, ..task.root }, Cuts { lo: cut + 1, ..task.root }]
            .map(|part| (part.lo <= part.hi).then_some(part));
        if self.is_closed(self.prepared.least_bound(sets, root.band(), costs)) {
            let (first, last) = reach(&root, losses, costs, self.target(), (lo, hi));
            ends[0] = (first > lo).then(|| Cuts { hi: first - 1, ..task.root });
            ends[1] = (last < hi).then(|| Cuts { lo: last + 1, ..task.root });
        } else if task.root.width() * ROOT_CUTS_BY_CUTS_OF_PAIRS
            <= self.prepared.instance.features[feature].n_ranks as u32
            || lo == hi
        {
            let pairs = self.children.pairs(feature, &sets.labels);
            return vec![Task { bound: task.bound, children: OfChildren::Pairs(pairs), ..*task }];
        }
        let [left, right] = children;
        let known = [[known[0].clone(), right], [left, known[1].clone()]];
        let parts = ends.into_iter().zip(known).filter_map(|(root, known)| root.map(|root| (root, known)));
        let made = parts.map(|(root, known)| {
            let band = self.prepared.band(sets, feature, root.lo, root.hi);
            let bound = self.prepared.least_bound(sets, band, [&known[0], &known[1]]).max(task.bound);
            Task { bound, sets: task.sets, root, children: OfChildren::Bounds(known) }
        });
        made.filter(|part| !self.is_closed(part.bound)).collect()
    }

    /// Both halves of the root's interval, with the pairs of children that may still hold a better tree.
    fn pruned(&self, task: &Task, pairs: &[Pair]) -> Vec<Task> {
        self.n_nodes.fetch_add(1, Ordering::Relaxed);
        let (root, labels) = (task.root, &self.sets[task.sets].1.labels);
        let mut bounds = Bounds::new(self.children, root, *labels);
        let mut stack = pairs.to_vec();
        let (mut open, mut least) = (Vec::new(), i64::MAX / WHOLE);
        while let Some(pair) = stack.pop() {
            let bound = bounds.of(pair, self.best());
            if bound >= self.best() {
                continue;
            }
            let widths = pair.map(|place| self.children.width(place));
            let wider = usize::from(widths[1] > widths[0]);
            if widths[wider] > MOST_CHILD_CUTS_BY_ROOT_CUTS * root.width() {
                stack.extend(self.children.halves(pair, wider));
            } else if root.width() > MOST_ENUMERATED_CUTS {
                open.push(pair);
                least = least.min(bound);
            } else {
                self.enumerated(self.children.trees(root, labels, pair));
            }
            if self.supervision.is_stopped() {
                return Vec::new();
            }
        }
        let bound = task.bound.max(WHOLE * least);
        let part = |root: Cuts| Task { bound, sets: task.sets, root, children: OfChildren::Pairs(open.clone()) };
        if open.is_empty() { Vec::new() } else { root.halves().map(part).into() }
    }

    /// Look at all trees of a box that may be better, until the search is stopped.
    fn enumerated(&self, trees: Trees) {
        let instance = self.prepared.instance;
        let mut stack = vec![trees];
        while let Some(trees) = stack.pop() {
            if self.supervision.is_stopped() {
                return;
            }
            if trees.bound(instance) >= self.best() {
                continue;
            }
            if let Some(halves) = trees.halves() {
                stack.extend(halves);
                continue;
            }
            let draft = trees.draft(instance);
            if let Some((cost, _)) = draft.cost(instance) {
                self.keep_better(cost, draft.to_tree(instance));
            }
        }
    }

    fn keep_better(&self, cost: i64, tree: Tree) {
        self.with_state(|state| {
            if cost < state.best.0 {
                state.best = (cost, tree);
                self.best.store(cost, Ordering::Relaxed);
            }
        });
    }

    /// The best cost, the proven bound and the number of open pairs.
    fn figures(&self) -> (i64, i64, usize) {
        self.with_state(|state| {
            let open = state.open.peek().map_or(i64::MAX, |Reverse(task)| task.bound);
            let least = state.busy.iter().copied().filter(|&bound| bound < IDLE).fold(open, i64::min);
            let bound = if least == i64::MAX { state.best.0 } else { (least + WHOLE - 1).div_euclid(WHOLE) };
            (state.best.0, bound.max(self.floor).min(state.best.0), state.n_pairs)
        })
    }

    fn poll(&self, keep_going: KeepGoing<'_>) {
        let (objective, bound, n_open) = self.figures();
        let n_nodes = self.n_nodes.load(Ordering::Relaxed);
        self.supervision.poll(keep_going, Progress { seconds: 0.0, objective, bound, n_nodes });
        let gap = self.supervision.gap_reached((objective - bound) as f64, objective as f64);
        let bytes = n_open as f64 * size_of::<Pair>() as f64;
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
    Task(Task),
    Wait,
    Done,
}

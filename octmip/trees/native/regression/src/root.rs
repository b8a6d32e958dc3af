//! The whole search: the cuts of all features at the root, those with the least bound first.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::axis::Axis;
use crate::node::{Children, Cut, Search, next_cut};
use crate::result::NodeResult;
use crate::samples::{Question, Samples};
use crate::view::View;
use octmip_frame::control::{KeepGoing, Limits, Progress, Stop};
use octmip_frame::effort::Control;
use octmip_frame::interval::{Interval, Open};
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;

/// Progress is reported in so many parts of the cost of the best leaf.
const PARTS: f64 = (1u64 << 50) as f64;

/// So many cuts of the root are solved before what they found is taken up: the same for any number of threads, so that
/// these do not change the tree.
const BATCH: usize = 8;

/// What a search ends with.
#[derive(Debug, Clone)]
pub struct Found {
    /// The best tree below the cost that was known, None without any.
    pub tree: Option<Tree>,
    /// No tree costs less.
    pub bound: f64,
    /// Why it stopped.
    pub stop: Stop,
    /// Evaluated cuts.
    pub n_cuts: u64,
}

/// A bound; no two are equal but those of the same digits.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bound(f64);

impl Eq for Bound {}

impl PartialOrd for Bound {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Bound {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Best cost and bound so far, for those who ask meanwhile.
#[derive(Debug, Clone, Copy)]
struct State {
    cost: f64,
    bound: f64,
}

/// The best tree of a question that costs less than `upper` (None: any), and a bound of all trees.
///
/// From three levels on, so many threads solve cuts of the root. Cost, bound and tree of a search that ends do not
/// depend on their number.
pub fn solve(
    question: &Question,
    upper: Option<f64>,
    n_threads: usize,
    limits: Limits,
    keep_going: KeepGoing<'_>,
) -> Found {
    let samples = Samples::new(question);
    let supervision = Supervision::new(limits);
    let control = Control::reading(supervision.flag());
    let view = View::root(&samples);
    let leaf = view.leaf(&samples);
    let upper = upper.unwrap_or(f64::INFINITY);
    let clusters = view.cluster_bound(&samples, 1 << question.depth.min(20));
    let state = Mutex::new(State { cost: upper, bound: clusters });
    let unit = if leaf > 0.0 { leaf / PARTS } else { 1.0 };
    let poll = || {
        let n_cuts = control.n_evaluated();
        if let Some(stop) = supervision.spent(n_cuts, 0.0) {
            supervision.stop(stop);
        }
        let State { cost, bound } = *state.lock().unwrap_or_else(PoisonError::into_inner);
        let objective = if cost.is_finite() { (cost / unit) as i64 } else { i64::MAX };
        let now = Progress { seconds: 0.0, objective, bound: (bound / unit) as i64, n_nodes: n_cuts };
        supervision.poll(&mut *keep_going, now);
    };
    let n_workers = if question.depth > 2 { n_threads.clamp(1, BATCH) } else { 1 };
    let worker = |_| Worker { search: Search::new(&samples, &control, question.depth), sides: Default::default() };
    let workers = (0..n_workers).map(worker).collect();
    let mut root = Root { samples: &samples, workers, supervision: &supervision, state: Some(&state) };
    let result = supervision.run(|| root.beside(&view, question.depth, upper, clusters), poll);
    let stop = supervision.reason().unwrap_or(Stop::Optimal);
    let tree = result.best.map(|(_, tree)| tree);
    Found { tree, bound: result.lower, stop, n_cuts: control.n_evaluated() }
}

/// One thread's search and buffers.
struct Worker<'a> {
    search: Search<'a>,
    sides: [View; 2],
}

/// A cut of the root that is being solved: place of its feature, interval and index.
type Job = (usize, Interval, usize, f64);

struct Root<'a> {
    samples: &'a Samples,
    workers: Vec<Worker<'a>>,
    supervision: &'a Supervision,
    /// Where progress is shown; None for a problem that stands beside the one that is asked.
    state: Option<&'a Mutex<State>>,
}

impl Root<'_> {
    /// The best tree, from three levels on after that with leaves of any size: its cost is a bound, and where its
    /// leaves are large enough it is the best one.
    fn beside(&mut self, view: &View, depth: usize, upper: f64, clusters: f64) -> NodeResult {
        let Some(samples) = self.samples.free.as_deref().filter(|_| depth > 2 && view.has_room(self.samples, depth))
        else {
            return self.solve(view, depth, upper, clusters);
        };
        let searches = self.workers.iter_mut().filter_map(|worker| worker.search.take_free());
        let workers = searches.map(|search| Worker { search, sides: Default::default() }).collect();
        let mut root = Root { samples, workers, supervision: self.supervision, state: None };
        let free = root.solve(view, depth, upper, clusters);
        let is_stopped = self.supervision.is_stopped();
        for (worker, free) in self.workers.iter_mut().zip(root.workers) {
            worker.search.put_back(free.search);
        }
        match free.best {
            Some((cost, tree)) if view.holds_leaves(self.samples, &tree, self.samples.leaf_size) => {
                let lower = if is_stopped { free.lower } else { cost };
                NodeResult { lower, relaxed: lower, best: Some((cost, tree)) }
            }
            Some(_) if !is_stopped => self.solve(view, depth, upper, free.lower),
            _ => NodeResult { best: None, ..free },
        }
    }

    fn solve(&mut self, view: &View, depth: usize, upper: f64, clusters: f64) -> NodeResult {
        if depth <= 2 {
            let mut result = self.workers[0].search.solve(view, depth, upper, clusters);
            if self.workers[0].search.is_stopped() {
                result.lower = clusters;
            }
            return result;
        }
        let leaf = view.leaf(self.samples);
        let mut best = NodeResult::cheapest(leaf, Tree::leaf(0), upper);
        let shallower = self.workers[0].search.solve(view, depth - 1, leaf, clusters);
        let whole = (shallower.lower, shallower.relaxed);
        if shallower.cost(f64::INFINITY) < best.cost(upper) {
            best.best = shallower.best;
        }
        best.lower = clusters;
        if !self.workers[0].search.is_stopped() {
            self.search_cuts(view, depth, whole, upper, &mut best);
        }
        best
    }

    /// Solve cuts of all features, the least bound first, until no open one may hold a better tree.
    fn search_cuts(&mut self, view: &View, depth: usize, whole: (f64, f64), upper: f64, best: &mut NodeResult) {
        let samples = self.samples;
        let mut axes: Vec<Axis> = (0..samples.p).map(|_| Axis::default()).collect();
        let order = self.workers[0].search.features_by_incumbent();
        let mut open = BinaryHeap::new();
        for (place, &f) in order.iter().enumerate() {
            axes[place].lay(samples, view, f, 1 << (depth - 1).min(20), whole);
            let bound = best.lower;
            open.extend(axes[place].whole().map(|interval| Reverse(Open { bound: Bound(bound), place, interval })));
        }
        loop {
            let current = best.cost(upper);
            let (jobs, cuts) = self.next_cuts(&mut open, &axes, &order, current, best);
            if jobs.is_empty() || self.supervision.is_stopped() {
                break;
            }
            let solved = solve_cuts(&mut self.workers, view, depth, &cuts);
            if self.supervision.is_stopped() {
                return;
            }
            for ((place, interval, k, bound), children) in jobs.into_iter().zip(solved) {
                let axis = &mut axes[place];
                (axis.solved[k], axis.relaxed[k]) = (children.bounds, children.relaxed);
                if let Some((cost, tree)) = children.tree.filter(|(cost, _)| *cost < best.cost(upper)) {
                    best.best = Some((cost, tree));
                }
                for half in interval.halves(k).into_iter().flatten() {
                    let bound = bound.max(axis.least(samples, &half) + samples.penalty);
                    open.push(Reverse(Open { bound: Bound(bound), place, interval: half }));
                }
            }
        }
        if !self.supervision.is_stopped() && open.is_empty() {
            best.lower = best.cost(upper);
        }
    }

    /// The cuts to solve next, those of the least bounds; none where no open one may hold a better tree.
    fn next_cuts(
        &self,
        open: &mut BinaryHeap<Reverse<Open<Bound>>>,
        axes: &[Axis],
        order: &[usize],
        current: f64,
        best: &mut NodeResult,
    ) -> (Vec<Job>, Vec<Cut>) {
        let (mut jobs, mut cuts) = (Vec::new(), Vec::new());
        while jobs.len() < BATCH
            && let Some(Reverse(Open { bound: Bound(bound), place, interval })) = open.pop()
        {
            if jobs.is_empty() {
                best.lower = bound.min(current);
                self.report(current, best.lower);
            }
            if bound >= current {
                break;
            }
            let target = current - self.samples.penalty;
            if let Some((interval, (k, cut))) = next_cut(self.samples, &axes[place], interval, target, order[place]) {
                jobs.push((place, interval, k, bound));
                cuts.push(cut);
            }
        }
        (jobs, cuts)
    }

    fn report(&self, cost: f64, bound: f64) {
        let Some(state) = self.state else { return };
        *state.lock().unwrap_or_else(PoisonError::into_inner) = State { cost, bound };
        if cost.is_finite()
            && let Some(gap) = self.supervision.gap_reached(cost - bound, cost)
        {
            self.supervision.stop(gap);
        }
    }
}

/// Solve the children of cuts, in turn or by several threads.
fn solve_cuts(workers: &mut [Worker<'_>], view: &View, depth: usize, cuts: &[Cut]) -> Vec<Children> {
    let next = AtomicUsize::new(0);
    let found: Mutex<Vec<(usize, Children)>> = Mutex::new(Vec::with_capacity(cuts.len()));
    let work = |worker: &mut Worker<'_>| {
        while let Some((place, cut)) = Some(next.fetch_add(1, Relaxed)).and_then(|i| cuts.get(i).map(|cut| (i, cut))) {
            let children = worker.search.children(view, depth, cut, &mut worker.sides);
            found.lock().unwrap_or_else(PoisonError::into_inner).push((place, children));
        }
    };
    let n_workers = workers.len().min(cuts.len());
    match &mut workers[..n_workers] {
        [worker] => work(worker),
        workers => thread::scope(|scope| workers.iter_mut().for_each(|worker| drop(scope.spawn(|| work(worker))))),
    }
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, children)| children).collect()
}

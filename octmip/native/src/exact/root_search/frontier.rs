//! The open intervals of the root, best bound first, worked by all threads.
//!
//! The least bound over the open intervals and those in work bounds every tree not yet seen: it rises during the
//! search.
//!
//! Work is handed out in rounds of a fixed number of cuts, chosen before the round and entered in order after it. So
//! what is searched, and which tree is found, does not depend on the number of threads or on their speed; but for cuts
//! in work when a tree turns up that none undercuts, which are counted and forgotten.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::exact::effort::Control;
use crate::exact::node::axis::{Axis, Interval};
use crate::exact::node::plan::Plan;
use crate::exact::node::result::{FeatureIncumbent, Solved};
use crate::exact::node::search::{Children, Cut, Search};
use crate::exact::root_search::known::Known;
use crate::exact::samples::Samples;
use crate::exact::switches::Switches;
use crate::exact::view::View;

/// An open interval of a feature; ordered by bound, then by the order of features, then by place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Open {
    bound: i64,
    place: usize,
    low: usize,
    high: usize,
    a: usize,
    b: usize,
}

impl Open {
    fn new(bound: i64, place: usize, interval: Interval) -> Self {
        let Interval { a, b, low, high } = interval;
        Self { bound, place, low, high, a, b }
    }

    fn interval(&self) -> Interval {
        Interval { a: self.a, b: self.b, low: self.low, high: self.high }
    }
}

/// Cuts of a round: enough to keep a few threads busy, few enough that an incumbent found in it costs little.
const ROUND: usize = 8;

/// Features whose best cut of one level fewer is solved first: its trees are near the best, and found at once.
const N_FIRST: usize = 3;

struct State {
    axes: Vec<Axis>,
    heap: BinaryHeap<Reverse<Open>>,
    /// The cuts of this round, those not yet handed out, and what came back.
    round: Vec<Task>,
    n_handed_out: usize,
    results: Vec<Option<Children>>,
    is_finished: bool,
    incumbents: Vec<FeatureIncumbent>,
    /// Places of the features and cuts that are entered.
    solved: Vec<(usize, usize)>,
    cost: i64,
    plan: Option<Plan>,
    /// What a log says of the cuts that are entered.
    records: Vec<String>,
}

/// The root's search, shared by the threads.
pub(crate) struct Frontier<'a> {
    samples: &'a Samples,
    switches: Switches,
    control: &'a Control,
    view: &'a View,
    depth: usize,
    features: Vec<usize>,
    /// Cuts of a round.
    round: usize,
    state: Mutex<State>,
    changed: Condvar,
}

/// A cut of a round.
#[derive(Debug, Clone, Copy)]
struct Task {
    place: usize,
    k: usize,
    interval: Interval,
    bound: i64,
    cut: Cut,
}

impl<'a> Frontier<'a> {
    /// All cuts of all features; trees below `upper` are wanted, and `incumbents` are those of one level fewer.
    /// `known`: what an earlier search of this level has proven.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn new(
        samples: &'a Samples,
        switches: Switches,
        control: &'a Control,
        view: &'a View,
        depth: usize,
        incumbents: &[FeatureIncumbent],
        whole: i64,
        upper: i64,
        known: Option<&Known>,
    ) -> Self {
        let mut features: Vec<usize> = (0..samples.p).collect();
        features.sort_by_key(|&f| incumbents.get(f).map_or(i64::MAX, |incumbent| incumbent.cost));
        let (mut heap, mut axes, mut round) = (BinaryHeap::new(), Vec::new(), Vec::new());
        let mut solved = Vec::new();
        for (place, &f) in features.iter().enumerate() {
            let mut axis = Axis::default();
            axis.lay(samples, view, f, 1 << (depth - 1).min(20), whole, &switches);
            let cuts = known.map_or(Vec::new(), |known| axis.take_up(f, &known.cuts));
            if !cuts.is_empty() {
                heap.extend(
                    axis.gaps(&cuts).map(|gap| Reverse(Open::new(samples.penalty + axis.least(&gap), place, gap))),
                );
                solved.extend(cuts.iter().map(|&k| (place, k)));
            } else if let Some(interval) = axis.whole() {
                let bound = samples.penalty + axis.least(&interval);
                let open = Open::new(bound, place, interval);
                let best = incumbents.get(f).filter(|_| place < N_FIRST && known.is_none());
                match best.and_then(|incumbent| axis.cut_at(incumbent.position)) {
                    Some(k) => round.push(Task {
                        place,
                        k,
                        interval,
                        bound,
                        cut: cut(&axis, f, &interval, k, upper - samples.penalty, &switches),
                    }),
                    None => heap.push(Reverse(open)),
                }
            }
            axes.push(axis);
        }
        let results = round.iter().map(|_| None).collect();
        let state = State {
            axes,
            heap,
            round,
            n_handed_out: 0,
            results,
            is_finished: false,
            incumbents: known
                .map_or_else(|| vec![FeatureIncumbent::NOTHING; samples.p], |known| known.incumbents.clone()),
            solved,
            cost: upper,
            plan: None,
            records: Vec::new(),
        };
        let changed = Condvar::new();
        Self { samples, switches, control, view, depth, features, round: ROUND, state: Mutex::new(state), changed }
    }

    /// The same with so many cuts in a round, at least as many as by default: other cuts are searched, and one of the
    /// best trees is found as ever.
    pub(crate) fn by_rounds_of(self, round: usize) -> Self {
        Self { round: round.max(ROUND), ..self }
    }

    /// Cuts of a round.
    pub(crate) fn round(&self) -> usize {
        self.round
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lowest cost so far (or the budget), and a bound of all trees not better than it.
    pub(crate) fn progress(&self) -> (i64, i64) {
        let state = self.lock();
        let open = state.heap.peek().map_or(i64::MAX, |Reverse(open)| open.bound);
        let in_work = state.round.iter().map(|task| task.bound).min();
        let bound = in_work.unwrap_or(i64::MAX).min(open);
        (state.cost, bound.min(state.cost))
    }

    /// Bytes of the queue.
    pub(crate) fn bytes(&self) -> usize {
        self.lock().heap.capacity() * size_of::<Reverse<Open>>()
    }

    /// The best tree below the budget, of the cuts of the round that are back included.
    pub(crate) fn best(&self) -> Option<(i64, Plan)> {
        let state = self.lock();
        let entered = state.plan.as_ref().map(|plan| (state.cost, plan));
        let back = state.results.iter().flatten().filter_map(|children| children.tree.as_ref());
        let below = back.map(|(cost, plan)| (*cost, plan)).filter(|(cost, _)| *cost < state.cost);
        let best = entered.into_iter().chain(below).min_by_key(|(cost, _)| *cost);
        best.map(|(cost, plan)| (cost, plan.clone()))
    }

    /// Incumbent of each feature at the root (`p`).
    pub(crate) fn incumbents(&self) -> Vec<FeatureIncumbent> {
        self.lock().incumbents.clone()
    }

    /// The solved cuts, those of the round that are back included.
    pub(crate) fn solved(&self) -> Vec<Solved> {
        let state = self.lock();
        let entered = state.solved.iter().map(|&(place, k)| {
            let axis = &state.axes[place];
            let bounds = [axis.left[k], axis.right[k]];
            Solved { feature: self.features[place], position: axis.positions[k] as usize, bounds }
        });
        let back = state.round.iter().zip(&state.results).filter_map(|(task, children)| {
            let bounds = children.as_ref()?.bounds;
            Some(Solved { feature: task.cut.feature, position: task.cut.position, bounds })
        });
        entered.chain(back).collect()
    }

    /// What a log says of the cuts that are entered, in their order: the same for any number of threads.
    pub(crate) fn records(&self) -> String {
        self.lock().records.concat()
    }

    /// Work until nothing is open or the search is stopped.
    pub(crate) fn work(&self, search: &mut Search<'_>) {
        let mut sides = [View::default(), View::default()];
        self.work_by(|cut| Some(search.root_children(self.view, self.depth, cut, &mut sides)));
    }

    /// The same with somebody else to solve the cuts; who returns None has stopped.
    pub(crate) fn work_by(&self, mut solve: impl FnMut(&Cut) -> Option<Children>) {
        while let Some((index, task)) = self.next() {
            let children = solve(&task.cut);
            if children.is_none() || self.control.is_stopped() {
                break; // what was found may be no proof: the round is never entered, its bounds stand
            }
            self.lock().results[index] = children;
            self.changed.notify_all();
        }
        self.changed.notify_all();
    }

    /// The next cut of the round, or of the next round once all of this one are back; None at the end.
    fn next(&self) -> Option<(usize, Task)> {
        let mut state = self.lock();
        loop {
            if self.control.is_stopped() || state.is_finished {
                return None;
            }
            self.drop_rest(&mut state);
            if let Some(&task) = state.round.get(state.n_handed_out) {
                state.n_handed_out += 1;
                return Some((state.n_handed_out - 1, task));
            }
            if state.results.iter().all(Option::is_some) {
                self.turn(&mut state);
                continue;
            }
            // Woken by results; looks up now and then, as nobody wakes it when the search is stopped.
            let waited = self.changed.wait_timeout(state, Duration::from_millis(20));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Once a cut of the round has a tree that costs no more than the price of its root, the rest of the round and the
    /// queue are dropped: no tree with a split costs less, and no leaf does, as its cost bounds what is searched for.
    ///
    /// Cuts are handed out in order, so all before it are handed out. Those after it are forgotten even where another
    /// thread has brought them back: the same is entered for any number of threads.
    fn drop_rest(&self, state: &mut State) {
        let is_least =
            |children: &Children| children.tree.as_ref().is_some_and(|(cost, _)| *cost <= self.samples.penalty);
        let Some(found) = state.results.iter().position(|result| result.as_ref().is_some_and(is_least)) else {
            return;
        };
        if state.results[..state.n_handed_out].iter().all(Option::is_some) {
            state.round.truncate(found + 1);
            state.results.truncate(found + 1);
            state.heap.clear();
        } else {
            state.round.truncate(state.n_handed_out);
            state.results.truncate(state.n_handed_out);
        }
        state.n_handed_out = state.round.len();
    }

    /// Enter a round's results and choose the next.
    fn turn(&self, state: &mut State) {
        let (round, results) = (std::mem::take(&mut state.round), std::mem::take(&mut state.results));
        for (task, children) in round.iter().zip(results.into_iter().flatten()) {
            self.enter(state, task, children);
        }
        while state.round.len() < self.round
            && let Some(task) = self.pop(state)
        {
            state.round.push(task);
        }
        state.results.resize_with(state.round.len(), || None);
        state.n_handed_out = 0;
        state.is_finished = state.round.is_empty();
    }

    fn pop(&self, state: &mut State) -> Option<Task> {
        let target = state.cost - self.samples.penalty;
        while let Some(Reverse(open)) = state.heap.pop() {
            let axis = &state.axes[open.place];
            let Some(interval) = axis.narrow(open.interval(), target) else {
                continue;
            };
            let Some(k) = axis.pick(&interval, target) else {
                continue;
            };
            return Some(Task {
                place: open.place,
                k,
                interval,
                bound: open.bound,
                cut: cut(axis, self.features[open.place], &interval, k, target, &self.switches),
            });
        }
        None
    }

    fn enter(&self, state: &mut State, task: &Task, children: Children) {
        state.solved.push((task.place, task.k));
        if !children.record.is_empty() {
            state.records.push(children.record);
        }
        let axis = &mut state.axes[task.place];
        [axis.left[task.k], axis.right[task.k]] = children.bounds;
        let Interval { a, b, low, high } = task.interval;
        let halves =
            [Interval { a, b: task.k, low, high: task.k - 1 }, Interval { a: task.k, b, low: task.k + 1, high }];
        let opened: Vec<Open> = halves
            .into_iter()
            .filter(|half| half.low <= half.high)
            .map(|half| {
                let bound = (axis.least(&half) + self.samples.penalty).max(task.bound);
                Open::new(bound, task.place, half)
            })
            .collect();
        state.heap.extend(opened.into_iter().map(Reverse));
        if let Some((cost, plan)) = children.tree {
            state.incumbents[task.cut.feature].see(cost, task.cut.position);
            if cost < state.cost {
                (state.cost, state.plan) = (cost, Some(plan));
            }
        }
    }
}

/// Cut `k` of an interval of feature `f`, to be solved.
fn cut(axis: &Axis, f: usize, interval: &Interval, k: usize, target: i64, switches: &Switches) -> Cut {
    Cut {
        feature: f,
        position: axis.positions[k] as usize,
        bounds: axis.bounds(interval, k).into(),
        target,
        slack: if switches.slack { axis.slack(interval, k) } else { 0 },
    }
}

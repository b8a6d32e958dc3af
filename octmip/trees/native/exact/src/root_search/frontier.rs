//! The open intervals of the root, best bound first, worked by all threads.
//!
//! The least bound over the open intervals and those in work bounds every tree not yet seen: it rises during the
//! search.
//!
//! Results are entered in the order in which their cuts were chosen, and a cut is chosen when all but the last few
//! before it are entered, always as many. So what is searched, and which tree is found, does not depend on the number
//! of threads or on their speed, and nobody waits for a slow cut until as many more are done; but cuts in work when a
//! tree is entered that none undercuts are counted and forgotten.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::node::axis::Axis;
use crate::node::children::Children;
use crate::node::kept::Shared;
use crate::node::plan::Plan;
use crate::node::price::at_all_levels;
use crate::node::result::{FeatureIncumbent, Solved};
use crate::node::search::{Cut, Search};
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::interval::{Interval, Open};

/// Cuts that are chosen and not yet entered: enough to keep a few threads busy, few enough that little is searched for
/// want of what they will show.
const WINDOW: usize = 5;

/// Features whose best cut of one level fewer is solved first: its trees are near the best, and found at once.
const N_FIRST: usize = 3;

struct State {
    axes: Vec<Axis>,
    heap: BinaryHeap<Reverse<Open<i64>>>,
    /// The cuts that are chosen and not yet entered, in order, and how many were entered before them.
    window: VecDeque<Task>,
    n_entered: usize,
    /// Cuts that were handed out.
    n_handed_out: usize,
    /// Cuts that are chosen before any result is there.
    n_first: usize,
    incumbents: Vec<FeatureIncumbent>,
    /// Places of the features and cuts that are entered.
    solved: Vec<(usize, usize)>,
    cost: i64,
    plan: Option<Plan>,
    /// What a log says of the cuts that are entered.
    records: Vec<String>,
}

/// What is asked of the root at one number of levels, and what is known beforehand.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Level<'l> {
    /// Levels of the trees that are known.
    pub(crate) before: usize,
    /// Levels that the trees may have.
    pub(crate) depth: usize,
    /// Trees below this are wanted.
    pub(crate) upper: i64,
    /// Each feature's incumbent of `before` levels; none: in no order.
    pub(crate) incumbents: &'l [FeatureIncumbent],
    /// Lower bound of the trees of `before` levels on all samples.
    pub(crate) whole: i64,
    /// Cuts solved for these.
    pub(crate) fewer: &'l [Solved],
    /// Cuts solved for `depth` levels with leaves of any size.
    pub(crate) free: &'l [Solved],
}

/// The root's search, shared by the threads.
pub(crate) struct Frontier<'a> {
    samples: &'a Samples,
    switches: Switches,
    control: &'a Control,
    view: &'a View,
    depth: usize,
    features: Vec<usize>,
    /// Most cuts in the window.
    size: usize,
    state: Mutex<State>,
    changed: Condvar,
    /// Results of nodes below the cuts that are entered.
    shared: Option<&'a Shared>,
}

/// A cut of the window, and what came back.
struct Task {
    place: usize,
    k: usize,
    interval: Interval,
    bound: i64,
    cut: Cut,
    /// Cuts whose results it sees.
    until: usize,
    result: Option<Children>,
}

impl<'a> Frontier<'a> {
    /// All cuts of all features. `known`: cuts that an earlier search of this level has closed, and its incumbents.
    pub(crate) fn new(
        samples: &'a Samples,
        switches: Switches,
        control: &'a Control,
        view: &'a View,
        level: &Level<'_>,
        known: Option<(&[Solved], &[FeatureIncumbent])>,
    ) -> Self {
        let &Level { before, depth, upper, incumbents, whole, fewer, free } = level;
        let whole = at_all_levels(whole, before, depth - 1, samples.penalty);
        let mut features: Vec<usize> = (0..samples.p).collect();
        features.sort_by_key(|&f| incumbents.get(f).map_or(i64::MAX, |incumbent| incumbent.cost));
        let (mut heap, mut axes, mut window) = (BinaryHeap::new(), Vec::new(), VecDeque::new());
        let mut solved = Vec::new();
        for (place, &f) in features.iter().enumerate() {
            let mut axis = Axis::default();
            axis.lay(samples, view, (f, samples.leaf_size), 1 << (depth - 1).min(20), whole, &switches);
            if samples.free.is_none() {
                axis.want_levels(samples, before);
                axis.take_up_fewer(f, fewer);
            }
            axis.take_up_free(f, free);
            let cuts = known.map_or(Vec::new(), |(cuts, _)| axis.take_up(f, cuts));
            if !cuts.is_empty() {
                heap.extend(
                    axis.gaps(&cuts)
                        .map(|gap| Reverse(Open { bound: samples.penalty + axis.least(&gap), place, interval: gap })),
                );
                solved.extend(cuts.iter().map(|&k| (place, k)));
            } else if let Some(interval) = axis.whole() {
                let bound = samples.penalty + axis.least(&interval);
                let open = Open { bound, place, interval };
                let best = incumbents.get(f).filter(|_| place < N_FIRST && known.is_none());
                match best.and_then(|incumbent| axis.cut_at(incumbent.position)) {
                    Some(k) => window.push_back(Task {
                        place,
                        k,
                        interval,
                        bound,
                        cut: cut(&axis, f, &interval, k, upper - samples.penalty, &switches),
                        until: 0,
                        result: None,
                    }),
                    None => heap.push(Reverse(open)),
                }
            }
            axes.push(axis);
        }
        let n_first = window.len();
        let state = State {
            axes,
            heap,
            window,
            n_entered: 0,
            n_handed_out: 0,
            n_first,
            incumbents: known.map_or_else(|| vec![FeatureIncumbent::NOTHING; samples.p], |known| known.1.to_vec()),
            solved,
            cost: upper,
            plan: None,
            records: Vec::new(),
        };
        let changed = Condvar::new();
        Self {
            samples,
            switches,
            control,
            view,
            depth,
            features,
            size: WINDOW,
            state: Mutex::new(state),
            changed,
            shared: None,
        }
    }

    /// The same where results of nodes are shared.
    pub(crate) fn sharing(self, shared: &'a Shared) -> Self {
        let until = shared.n_entered();
        self.lock().window.iter_mut().for_each(|task| task.until = until);
        Self { shared: Some(shared), ..self }
    }

    /// The same with so many cuts in work at once, at least as many as by default: other cuts are searched, and one of
    /// the best trees is found as ever.
    pub(crate) fn by_windows_of(self, size: usize) -> Self {
        Self { size: size.max(WINDOW), ..self }
    }

    /// Most cuts in work at once.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lowest cost so far (or the budget), and a bound of all trees not better than it.
    pub(crate) fn progress(&self) -> (i64, i64) {
        let state = self.lock();
        let open = state.heap.peek().map_or(i64::MAX, |Reverse(open)| open.bound);
        let in_work = state.window.iter().map(|task| task.bound).min();
        let bound = in_work.unwrap_or(i64::MAX).min(open);
        (state.cost, bound.min(state.cost))
    }

    /// Bytes of the queue.
    pub(crate) fn bytes(&self) -> usize {
        self.lock().heap.capacity() * size_of::<Reverse<Open<i64>>>()
    }

    /// The best tree below the budget, of the cuts that are back and not yet entered included.
    pub(crate) fn best(&self) -> Option<(i64, Plan)> {
        let state = self.lock();
        let entered = state.plan.as_ref().map(|plan| (state.cost, plan));
        let back = state.window.iter().filter_map(|task| task.result.as_ref()?.tree.as_ref());
        let below = back.map(|(cost, plan)| (*cost, plan)).filter(|(cost, _)| *cost < state.cost);
        let best = entered.into_iter().chain(below).min_by_key(|(cost, _)| *cost);
        best.map(|(cost, plan)| (cost, plan.clone()))
    }

    /// Incumbent of each feature at the root (`p`).
    pub(crate) fn incumbents(&self) -> Vec<FeatureIncumbent> {
        self.lock().incumbents.clone()
    }

    /// The solved cuts that are entered, with the bounds of leaves of any size.
    pub(crate) fn free(&self) -> Vec<Solved> {
        let state = self.lock();
        let entered = state.solved.iter().map(|&(place, k)| {
            let axis = &state.axes[place];
            Solved { feature: self.features[place], position: axis.positions[k] as usize, bounds: axis.free_at(k) }
        });
        entered.collect()
    }

    /// The solved cuts, those that are back and not yet entered included.
    pub(crate) fn solved(&self) -> Vec<Solved> {
        let state = self.lock();
        let entered = state.solved.iter().map(|&(place, k)| {
            let axis = &state.axes[place];
            let bounds = [axis.left[k], axis.right[k]];
            Solved { feature: self.features[place], position: axis.positions[k] as usize, bounds }
        });
        let back = state.window.iter().filter_map(|task| {
            let bounds = task.result.as_ref()?.bounds;
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
        self.work_by(|until, cut| Some(search.root_children(self.view, self.depth, (until, cut), &mut sides)));
    }

    /// The same with somebody else to solve the cuts; who returns None has stopped.
    pub(crate) fn work_by(&self, mut solve: impl FnMut(usize, &Cut) -> Option<Children>) {
        while let Some((number, until, cut)) = self.next() {
            let Some(children) = solve(until, &cut) else { break };
            if self.control.is_stopped() {
                break; // what was found may be no proof: it is never entered, the cut's bounds stand
            }
            self.take(number, children);
        }
        self.changed.notify_all();
    }

    /// The number and place of the next cut, once there is one; None at the end.
    fn next(&self) -> Option<(usize, usize, Cut)> {
        let mut state = self.lock();
        loop {
            if state.n_first == 0 {
                self.fill(&mut state);
            }
            if self.control.is_stopped() || state.window.is_empty() {
                return None;
            }
            let number = state.n_handed_out;
            if let Some(task) = state.window.get(number - state.n_entered) {
                let (until, cut) = (task.until, task.cut);
                state.n_handed_out += 1;
                return Some((number, until, cut));
            }
            // Woken by results; looks up now and then, as nobody wakes it when the search is stopped.
            let waited = self.changed.wait_timeout(state, Duration::from_millis(20));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Take a result, and enter those that are next in order. After each of them the window is filled again, so that
    /// what is known when a cut is chosen depends on its number alone. The first cuts, whose trees are near the best,
    /// are all entered before others are chosen.
    fn take(&self, number: usize, children: Children) {
        let mut state = self.lock();
        let index = number - state.n_entered;
        let Some(task) = state.window.get_mut(index) else {
            return; // forgotten
        };
        task.result = Some(children);
        while let Some(Task { result: Some(_), .. }) = state.window.front() {
            let Some(task) = state.window.pop_front() else { break };
            state.n_entered += 1;
            self.enter(&mut state, task);
            if state.n_entered >= state.n_first {
                self.fill(&mut state);
            }
        }
        self.changed.notify_all();
    }

    fn fill(&self, state: &mut State) {
        while state.window.len() < self.size
            && let Some(task) = self.pop(state)
        {
            state.window.push_back(task);
        }
    }

    fn pop(&self, state: &mut State) -> Option<Task> {
        let target = state.cost - self.samples.penalty;
        while let Some(Reverse(open)) = state.heap.pop() {
            let axis = &state.axes[open.place];
            let Some(interval) = axis.narrow(open.interval, target) else {
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
                until: self.shared.map_or(0, Shared::n_entered),
                result: None,
            });
        }
        None
    }

    fn enter(&self, state: &mut State, task: Task) {
        let Some(children) = task.result else { return };
        state.solved.push((task.place, task.k));
        if let Some(shared) = self.shared {
            shared.enter(children.kept);
        }
        if !children.record.is_empty() {
            state.records.push(children.record);
        }
        let axis = &mut state.axes[task.place];
        axis.enter(task.k, children.bounds, children.free);
        let halves = task.interval.halves(task.k).into_iter().flatten();
        let opened: Vec<Open<i64>> = halves
            .map(|interval| {
                let bound = (axis.least(&interval) + self.samples.penalty).max(task.bound);
                Open { bound, place: task.place, interval }
            })
            .collect();
        state.heap.extend(opened.into_iter().map(Reverse));
        if let Some((cost, plan)) = children.tree {
            state.incumbents[task.cut.feature].see(cost, task.cut.position);
            if cost < state.cost {
                (state.cost, state.plan) = (cost, Some(plan));
            }
            if cost <= self.samples.penalty {
                // No tree with a split costs less than the price of one, and no leaf does, as its cost bounds what is
                // searched for: the other cuts, in work or not, are forgotten.
                state.window.clear();
                state.heap.clear();
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
        free: axis.free_bounds(interval, k),
        sizes: axis.sizes(interval, k),
        target,
        is_free: false,
        slack: if switches.slack { axis.slack(interval, k) } else { 0 },
    }
}

//! The open intervals of the root, best bound first, worked by all threads.
//!
//! The least bound over the open intervals and those in work bounds every tree not yet seen: it rises while one watches.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::exact::Switches;
use crate::exact::axis::{Axis, Interval};
use crate::exact::branch::{Children, Cut, Search};
use crate::exact::effort::Control;
use crate::exact::plan::Plan;
use crate::exact::samples::Samples;
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
    fn interval(&self) -> Interval {
        Interval {
            a: self.a,
            b: self.b,
            low: self.low,
            high: self.high,
        }
    }
}

#[derive(Debug)]
struct State {
    axes: Vec<Axis>,
    heap: BinaryHeap<Reverse<Open>>,
    in_work: Vec<i64>,
    attained: Vec<i64>,
    cost: i64,
    plan: Option<Plan>,
}

/// The root's search, shared by the threads.
pub struct Frontier<'a> {
    samples: &'a Samples,
    switches: Switches,
    control: &'a Control,
    view: &'a View,
    depth: usize,
    features: Vec<usize>,
    state: Mutex<State>,
    changed: Condvar,
}

/// A cut handed to a thread.
struct Task {
    place: usize,
    k: usize,
    interval: Interval,
    bound: i64,
    cut: Cut,
}

impl<'a> Frontier<'a> {
    /// All cuts of all features, in the order of `features`; trees below `upper` are wanted.
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        samples: &'a Samples,
        switches: Switches,
        control: &'a Control,
        view: &'a View,
        depth: usize,
        features: Vec<usize>,
        whole: i64,
        upper: i64,
    ) -> Self {
        let mut heap = BinaryHeap::new();
        let mut axes = Vec::new();
        for (place, &f) in features.iter().enumerate() {
            let mut axis = Axis::default();
            axis.lay(samples, view, f, 1 << (depth - 1).min(20), whole, &switches);
            if let Some(Interval { a, b, low, high }) = axis.whole() {
                let bound = samples.penalty + axis.least(&Interval { a, b, low, high });
                heap.push(Reverse(Open {
                    bound,
                    place,
                    low,
                    high,
                    a,
                    b,
                }));
            }
            axes.push(axis);
        }
        let attained = vec![i64::MAX; samples.p];
        let state = State {
            axes,
            heap,
            in_work: Vec::new(),
            attained,
            cost: upper,
            plan: None,
        };
        let changed = Condvar::new();
        Self {
            samples,
            switches,
            control,
            view,
            depth,
            features,
            state: Mutex::new(state),
            changed,
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lowest cost so far (or the budget), and a bound of all trees not better than it.
    pub fn progress(&self) -> (i64, i64) {
        let state = self.lock();
        let open = state
            .heap
            .peek()
            .map_or(i64::MAX, |Reverse(open)| open.bound);
        let bound = state
            .in_work
            .iter()
            .copied()
            .min()
            .unwrap_or(i64::MAX)
            .min(open);
        (state.cost, bound.min(state.cost))
    }

    /// The best tree below the budget.
    pub fn best(&self) -> Option<(i64, Plan)> {
        let state = self.lock();
        state.plan.clone().map(|plan| (state.cost, plan))
    }

    /// Best cost seen with each feature at the root (`p`).
    pub fn attained(&self) -> Vec<i64> {
        self.lock().attained.clone()
    }

    /// Work until nothing is open or someone says stop.
    pub fn work(&self, search: &mut Search<'_>) {
        let mut sides = [View::default(), View::default()];
        while let Some(task) = self.next() {
            let children = search.children(self.view, self.depth, &task.cut, &mut sides);
            search.report_effort();
            self.record(&task, children);
        }
        self.changed.notify_all();
    }

    fn next(&self) -> Option<Task> {
        let mut state = self.lock();
        loop {
            if self.control.is_stopped() {
                return None;
            }
            if let Some(task) = self.pop(&mut state) {
                state.in_work.push(task.bound);
                return Some(task);
            }
            if state.in_work.is_empty() {
                return None;
            }
            // Woken by `record`; looks up now and then, as nobody wakes it when the word to stop is given.
            let waited = self.changed.wait_timeout(state, Duration::from_millis(20));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
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
            let slack = if self.switches.slack {
                axis.slack(&interval, k)
            } else {
                0
            };
            let cut = Cut {
                feature: self.features[open.place],
                position: axis.positions[k] as usize,
                bounds: axis.bounds(&interval, k).into(),
                target,
                slack,
            };
            return Some(Task {
                place: open.place,
                k,
                interval,
                bound: open.bound,
                cut,
            });
        }
        None
    }

    fn record(&self, task: &Task, children: Children) {
        let mut state = self.lock();
        if self.control.is_stopped() {
            return; // what was found is no proof: the interval stays in work, its bound stands
        }
        if let Some(index) = state.in_work.iter().position(|&bound| bound == task.bound) {
            state.in_work.swap_remove(index);
        }
        let axis = &mut state.axes[task.place];
        [axis.left[task.k], axis.right[task.k]] = children.bounds;
        let Interval { a, b, low, high } = task.interval;
        let halves = [
            Interval {
                a,
                b: task.k,
                low,
                high: task.k - 1,
            },
            Interval {
                a: task.k,
                b,
                low: task.k + 1,
                high,
            },
        ];
        let opened: Vec<Open> = halves
            .into_iter()
            .filter(|half| half.low <= half.high)
            .map(|half| {
                let bound = (axis.least(&half) + self.samples.penalty).max(task.bound);
                Open {
                    bound,
                    place: task.place,
                    low: half.low,
                    high: half.high,
                    a: half.a,
                    b: half.b,
                }
            })
            .collect();
        state.heap.extend(opened.into_iter().map(Reverse));
        if let Some((cost, plan)) = children.tree {
            let seen = &mut state.attained[task.cut.feature];
            *seen = cost.min(*seen);
            if cost < state.cost {
                (state.cost, state.plan) = (cost, Some(plan));
            }
        }
        drop(state);
        self.changed.notify_all();
    }
}

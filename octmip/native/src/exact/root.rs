//! The whole search: incumbent, shallower depths, the root's frontier, limits.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use crate::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use crate::exact::Switches;
use crate::exact::answer::Reached;
use crate::exact::branch::Search;
use crate::exact::budget::{Sets, is_within};
use crate::exact::effort::Control;
use crate::exact::frontier::Frontier;
use crate::exact::memory;
use crate::exact::plan::Plan;
use crate::exact::samples::Samples;
use crate::exact::view::View;
use crate::problem::Problem;
use crate::tree::Tree;

/// How to search.
#[derive(Debug, Clone)]
pub struct Options {
    /// When to stop early.
    pub limits: Limits,
    /// Worker threads.
    pub n_threads: usize,
    /// A feasible tree and its objective.
    pub incumbent: Option<(i64, Tree)>,
    /// Which prunes are on.
    pub switches: Switches,
}

/// The state of a search that is asked for progress.
struct Run<'a> {
    samples: &'a Samples,
    view: &'a View,
    options: &'a Options,
    control: Control,
    started: Instant,
    /// Bytes of the tables that do not grow.
    tables: f64,
    base: i64,
    /// Objective (above the base) and plan of the best tree; no plan: the incumbent that was given.
    best: (i64, Option<Plan>),
    bound: i64,
    /// The best tree, when it came from the search over sensor sets.
    tree: Option<Tree>,
    stop: Option<Stop>,
}

/// The best tree of the problem, and a bound.
pub fn solve(problem: &Problem, options: &Options, keep_going: KeepGoing<'_>) -> Outcome {
    let started = Instant::now();
    let tables = memory::bytes(problem, options.n_threads.max(1), &options.switches);
    if tables > options.limits.memory {
        return without_search(problem, options);
    }
    let samples = Samples::new(problem);
    let view = View::root(&samples);
    let base: i64 = samples.base.iter().sum();
    let mut run = Run {
        samples: &samples,
        view: &view,
        options,
        control: Control::new(),
        started,
        tables,
        base,
        best: (view.leaf(), Some(Plan::Leaf)),
        bound: 0,
        tree: None,
        stop: None,
    };
    if let Some((objective, _)) = &options.incumbent
        && objective - base <= run.best.0
    {
        run.best = (objective - base, None);
    }
    run.search(problem.depth, keep_going);
    let all: f64 = problem.sensor_cost.iter().sum();
    if all > problem.sensor_limit {
        run.keep_budget(problem, keep_going);
    }
    run.outcome()
}

/// The incumbent or the best leaf, and the cost that no tree avoids: what is known where memory is too small to search.
fn without_search(problem: &Problem, options: &Options) -> Outcome {
    let paid = |i: usize, k: usize| problem.weights[i] * problem.cost(problem.labels[i] as usize, k);
    let leaf = |k: usize| (0..problem.n).map(|i| paid(i, k)).sum::<i64>();
    let least = |i: usize| (0..problem.n_classes).map(|k| paid(i, k)).min().unwrap_or(0);
    let label = (0..problem.n_classes).min_by_key(|&k| leaf(k)).unwrap_or(0);
    let best = (leaf(label), Tree::leaf(label as u32));
    let (objective, tree) = match &options.incumbent {
        Some(given) if given.0 <= best.0 => given.clone(),
        _ => best,
    };
    let bound = (0..problem.n).map(least).sum();
    let stop = if bound >= objective { Stop::Optimal } else { Stop::Memory };
    Outcome { tree, objective, bound, stop, n_nodes: 0 }
}

impl Run<'_> {
    fn search(&mut self, depth: usize, keep_going: KeepGoing<'_>) {
        if self.best.0 <= self.samples.penalty || self.samples.p == 0 || self.samples.n_columns == 1 {
            self.bound = self.best.0;
            return;
        }
        let shallow = depth.min(2);
        let (mut whole, mut attained) = self.shallow(shallow, keep_going);
        if depth <= 2 {
            self.bound = whole;
            return;
        }
        for level in 3..=depth {
            if self.stop.is_some() {
                return;
            }
            (whole, attained) = self.deep(level, level == depth, &attained, whole, keep_going);
        }
    }

    /// Depth one or two, by one thread; a bound of that depth's trees, and what each feature reached.
    fn shallow(&mut self, depth: usize, keep_going: KeepGoing<'_>) -> (i64, Vec<Reached>) {
        let upper = self.view.leaf() + 1;
        let mut result = None;
        std::thread::scope(|scope| {
            let (sender, receiver) = channel::<()>();
            let (samples, view, control, switches) = (self.samples, self.view, &self.control, self.options.switches);
            let worker = scope.spawn(move || {
                let _sender = sender;
                let mut search = Search::new(samples, switches, control, depth);
                let answer = search.solve(view, depth, upper, 0);
                (answer, search.attained)
            });
            self.stop = watch(self.started, &self.options.limits, control, &receiver, keep_going, || {
                (self.best.0 + self.base, self.base, self.tables)
            });
            result = worker.join().ok();
        });
        let Some((answer, attained)) = result else {
            return (0, Vec::new());
        };
        if let Some((cost, plan)) = answer.best
            && cost < self.best.0
        {
            self.best = (cost, Some(plan));
        }
        (if self.stop.is_some() { 0 } else { answer.lower }, attained)
    }

    /// Depth three or more, by all threads.
    fn deep(
        &mut self,
        depth: usize,
        is_last: bool,
        attained: &[Reached],
        whole: i64,
        keep_going: KeepGoing<'_>,
    ) -> (i64, Vec<Reached>) {
        let (samples, view, switches) = (self.samples, self.view, self.options.switches);
        // The incumbent may be deeper than this level: the level's own trees are asked for up to the last level's cost.
        let upper = self.best.0;
        let frontier = Frontier::new(samples, switches, &self.control, view, depth, attained, whole, upper);
        let (base, tables) = (self.base, self.tables);
        std::thread::scope(|scope| {
            let (sender, receiver) = channel::<()>();
            for _ in 0..self.options.n_threads.max(1) {
                let sender: Sender<()> = sender.clone();
                let (frontier, control) = (&frontier, &self.control);
                scope.spawn(move || {
                    let _sender = sender;
                    let mut search = Search::new(samples, switches, control, depth);
                    if depth == 3 {
                        search.prepare(view);
                    }
                    frontier.work(&mut search);
                });
            }
            drop(sender);
            self.stop = watch(self.started, &self.options.limits, &self.control, &receiver, keep_going, || {
                let (cost, bound) = frontier.progress();
                let bytes = tables + frontier.bytes() as f64;
                (cost + base, if is_last { bound + base } else { base }, bytes)
            });
        });
        let (cost, bound) = frontier.progress();
        if let Some((cost, plan)) = frontier.best() {
            self.best = (cost, Some(plan));
        }
        if is_last {
            self.bound = bound;
        }
        (bound.min(cost), frontier.attained())
    }

    /// After the search without the budget, whose bound stands: the best tree within it.
    fn keep_budget(&mut self, problem: &Problem, keep_going: KeepGoing<'_>) {
        let Some(plan) = &self.best.1 else { return };
        let relaxed = plan.tree(self.samples, self.view);
        if is_within(problem, &relaxed) {
            return;
        }
        let given = self.options.incumbent.as_ref().map(|(objective, _)| objective - self.base);
        let leaf = self.view.leaf();
        self.best = match given {
            Some(cost) if cost <= leaf => (cost, None),
            _ => (leaf, Some(Plan::Leaf)),
        };
        if self.stop.is_some() {
            return;
        }
        let (samples, upper, tables) = (self.samples, self.best.0, self.tables);
        let (base, bound) = (self.base, self.bound);
        let sets = Sets::new(problem, samples, self.options.switches, &self.control, Some(&relaxed), upper);
        std::thread::scope(|scope| {
            let (sender, receiver) = channel::<()>();
            for _ in 0..self.options.n_threads.max(1) {
                let (sender, sets) = (sender.clone(), &sets);
                scope.spawn(move || {
                    let _sender = sender;
                    sets.work();
                });
            }
            drop(sender);
            self.stop = watch(self.started, &self.options.limits, &self.control, &receiver, keep_going, || {
                let bytes = tables + sets.bytes() as f64;
                (sets.best().0 + base, bound + base, bytes)
            });
        });
        let (cost, tree) = sets.best();
        if let Some(tree) = tree {
            self.best = (cost, None);
            self.tree = Some(tree);
        }
        if self.stop.is_none() {
            self.bound = cost;
        }
    }

    fn outcome(self) -> Outcome {
        let objective = self.base + self.best.0;
        let bound = self.base + self.bound.min(self.best.0);
        let tree = match (self.tree, &self.best.1, &self.options.incumbent) {
            (Some(tree), _, _) => tree,
            (None, Some(plan), _) => plan.tree(self.samples, self.view),
            (None, None, Some((_, tree))) => tree.clone(),
            (None, None, None) => Tree::leaf(self.samples.labels[self.view.best_column()]),
        };
        let stop = if bound >= objective { Stop::Optimal } else { self.stop.unwrap_or(Stop::Interrupted) };
        Outcome { tree, objective, bound, stop, n_nodes: self.control.n_evaluated() }
    }
}

/// Wait for the workers, looking at the limits and asking the caller meanwhile; why they were stopped, if they were.
/// `progress` says objective, bound and bytes taken.
fn watch(
    started: Instant,
    limits: &Limits,
    control: &Control,
    workers: &std::sync::mpsc::Receiver<()>,
    keep_going: KeepGoing<'_>,
    progress: impl Fn() -> (i64, i64, f64),
) -> Option<Stop> {
    let mut stop = None;
    loop {
        let left = limits.seconds - started.elapsed().as_secs_f64();
        let wait = Duration::from_secs_f64(left.clamp(0.0, 0.02));
        if workers.recv_timeout(wait) == Err(RecvTimeoutError::Disconnected) {
            return stop;
        }
        let (objective, bound, bytes) = progress();
        let n_nodes = control.n_evaluated();
        let seconds = started.elapsed().as_secs_f64();
        let has_gap = limits.gap > 0.0 && (objective - bound) as f64 <= limits.gap * objective as f64;
        let reason = if !keep_going(Progress { seconds, objective, bound, n_nodes }) {
            Some(Stop::Interrupted)
        } else if seconds >= limits.seconds {
            Some(Stop::Time)
        } else if n_nodes as f64 >= limits.nodes {
            Some(Stop::Nodes)
        } else if bytes > limits.memory {
            Some(Stop::Memory)
        } else if has_gap {
            Some(Stop::Gap)
        } else {
            None
        };
        if let Some(reason) = reason {
            stop = stop.or(Some(reason));
            control.stop();
        }
    }
}

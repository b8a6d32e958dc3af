//! The whole search: incumbent, shallower depths, the root's frontier, limits.

pub(crate) mod frontier;
pub(crate) mod known;
pub(crate) mod memory;
pub(crate) mod sensor_sets;

use crate::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use crate::costs::{base_cost, best_leaf};
use crate::exact::effort::Control;
use crate::exact::node::plan::Plan;
use crate::exact::node::result::FeatureIncumbent;
use crate::exact::node::search::Search;
use crate::exact::samples::Samples;
use crate::exact::switches::Switches;
use crate::exact::view::View;
use crate::problem::Problem;
use crate::supervise::Supervision;
use crate::tree::Tree;

use frontier::Frontier;
use known::{Due, Known, Saver};
use sensor_sets::{Sets, is_within};

/// Options of the search.
#[derive(Debug, Clone)]
pub struct Options {
    /// When to stop early.
    pub limits: Limits,
    /// Worker threads.
    pub n_threads: usize,
    /// A feasible tree and its objective.
    pub incumbent: Option<(i64, Tree)>,
    /// Prunes that are on.
    pub switches: Switches,
}

/// Origin of the best tree.
#[derive(Debug, Clone)]
enum Best {
    /// The incumbent that was given.
    Given,
    /// A plan of this search.
    Plan(Plan),
    /// An earlier search, or the one over sensor sets.
    Tree(Tree),
}

/// The state of a search that is asked for progress.
struct Run<'a, 's> {
    problem: &'a Problem,
    samples: &'a Samples,
    view: &'a View,
    options: &'a Options,
    control: Control,
    supervision: Supervision,
    /// Bytes of the tables that do not grow.
    tables: f64,
    base: i64,
    /// Objective (above the base) of the best tree, and where it comes from.
    best: (i64, Best),
    bound: i64,
    known: Option<Known>,
    due: Due<'s>,
}

/// The best tree of the problem, and a bound.
pub fn solve(problem: &Problem, options: &Options, keep_going: KeepGoing<'_>) -> Outcome {
    go_on(problem, options, None, None, keep_going).unwrap_or_else(|_| without_search(problem, options))
}

/// The same from what an earlier search has proven, handing out what is known every so often.
///
/// An error says why what is known cannot be.
pub(crate) fn go_on(
    problem: &Problem,
    options: &Options,
    known: Option<Known>,
    saver: Option<Saver<'_>>,
    keep_going: KeepGoing<'_>,
) -> Result<Outcome, String> {
    let supervision = Supervision::new(options.limits);
    let tables = memory::bytes(problem, options.n_threads.max(1), &options.switches);
    if tables > options.limits.memory {
        return Ok(without_search(problem, options));
    }
    let samples = Samples::new(problem);
    let view = View::root(&samples);
    let base: i64 = samples.base.iter().sum();
    if let Some(known) = &known {
        known.check(&samples, &view, problem.depth, problem.sensor_cost.len())?;
    }
    let mut run = Run {
        problem,
        samples: &samples,
        view: &view,
        options,
        control: Control::reading(supervision.flag()),
        supervision,
        tables,
        base,
        best: (view.leaf(), Best::Plan(Plan::Leaf)),
        bound: 0,
        known,
        due: Due::new(saver),
    };
    if let Some((objective, _)) = &options.incumbent
        && objective - base <= run.best.0
    {
        run.best = (objective - base, Best::Given);
    }
    if let Some(Known { best: (cost, tree), .. }) = &run.known
        && *cost < run.best.0
    {
        run.best = (*cost, Best::Tree(tree.clone()));
    }
    run.search(problem.depth, keep_going);
    let all: f64 = problem.sensor_cost.iter().sum();
    if all > problem.sensor_limit {
        run.keep_budget(keep_going);
    }
    Ok(run.outcome())
}

/// The incumbent or the best leaf, and the cost that no tree avoids: what is known where memory is too small to search.
fn without_search(problem: &Problem, options: &Options) -> Outcome {
    let (cost, label) = best_leaf(problem);
    let (objective, tree) = match &options.incumbent {
        Some(given) if given.0 <= cost => given.clone(),
        _ => (cost, Tree::leaf(label as u32)),
    };
    let bound = base_cost(problem);
    let stop = if bound >= objective { Stop::Optimal } else { Stop::Memory };
    Outcome { tree, objective, bound, stop, n_nodes: 0 }
}

impl Run<'_, '_> {
    fn search(&mut self, depth: usize, keep_going: KeepGoing<'_>) {
        if self.best.0 <= self.samples.penalty || self.samples.p == 0 || self.samples.n_labels == 1 {
            self.bound = self.best.0;
            return;
        }
        let ((mut whole, mut incumbents), first) = match &self.known {
            Some(known) => ((known.whole, known.order.clone()), known.level),
            None => (self.shallow(depth.min(2), keep_going), 3),
        };
        if depth <= 2 {
            self.bound = whole;
            return;
        }
        if self.known.as_ref().is_some_and(|known| known.sets.is_some()) {
            self.bound = self.known.as_ref().map_or(0, |known| known.bound);
            return;
        }
        for level in first..=depth {
            if self.supervision.reason().is_some() {
                return;
            }
            (whole, incumbents) = self.deep(level, level == depth, &incumbents, whole, keep_going);
            self.known = None;
        }
    }

    /// Depth one or two, by one thread; a bound of that depth's trees, and each feature's incumbent.
    fn shallow(&mut self, depth: usize, keep_going: KeepGoing<'_>) -> (i64, Vec<FeatureIncumbent>) {
        let upper = self.view.leaf() + 1;
        let work = || {
            let mut search = Search::new(self.samples, self.options.switches, &self.control, depth);
            let result = search.solve(self.view, depth, upper, 0);
            (result, search.incumbents)
        };
        let (result, incumbents) = self.supervision.run(work, || {
            self.poll(keep_going, self.progress(self.best.0 + self.base, self.base), self.tables);
        });
        if let Some((cost, plan)) = result.best
            && cost < self.best.0
        {
            self.best = (cost, Best::Plan(plan));
        }
        (if self.supervision.reason().is_some() { 0 } else { result.lower }, incumbents)
    }

    /// Depth three or more, by all threads.
    fn deep(
        &mut self,
        depth: usize,
        is_last: bool,
        incumbents: &[FeatureIncumbent],
        whole: i64,
        keep_going: KeepGoing<'_>,
    ) -> (i64, Vec<FeatureIncumbent>) {
        let (samples, view, switches) = (self.samples, self.view, self.options.switches);
        // The incumbent may be deeper than this level: the level's own trees are asked for up to the last level's cost.
        let upper = self.best.0;
        let known = self.known.take();
        let frontier =
            Frontier::new(samples, switches, &self.control, view, depth, incumbents, whole, upper, known.as_ref());
        let (base, tables, before, control) = (self.base, self.tables, self.tree(), &self.control);
        let state_now = || {
            let (_, bound) = frontier.progress();
            let best = frontier.best().map(|(cost, plan)| (cost, plan.tree(samples, view)));
            Known {
                level: depth,
                whole,
                order: incumbents.to_vec(),
                incumbents: frontier.incumbents(),
                cuts: frontier.solved(),
                bound: if is_last { bound } else { 0 },
                best: best.unwrap_or_else(|| (upper, before.clone())),
                n_nodes: control.n_evaluated(),
                sets: None,
            }
        };
        let work = || {
            let mut search = Search::new(samples, switches, control, depth);
            if depth == 3 {
                search.prepare(view);
            }
            frontier.work(&mut search);
        };
        let mut due = std::mem::take(&mut self.due);
        self.supervision.run_all(self.options.n_threads.max(1), work, || {
            let (cost, bound) = frontier.progress();
            let progress = self.progress(cost + base, if is_last { bound + base } else { base });
            self.poll(
                &mut |state| keep_going(state) && due.save(false, &state_now),
                progress,
                tables + frontier.bytes() as f64,
            );
        });
        if is_last || self.supervision.reason().is_some() {
            due.save(true, &state_now);
        }
        self.due = due;
        let (cost, bound) = frontier.progress();
        if let Some((cost, plan)) = frontier.best() {
            self.best = (cost, Best::Plan(plan));
        }
        if is_last {
            self.bound = bound;
        }
        (bound.min(cost), frontier.incumbents())
    }

    /// After the search without the budget, whose bound stands: the best tree within it.
    fn keep_budget(&mut self, keep_going: KeepGoing<'_>) {
        let (problem, relaxed) = (self.problem, self.tree());
        let open = self.known.as_mut().and_then(|known| known.sets.take());
        if is_within(problem, &relaxed) {
            if open.is_none() {
                return;
            }
        } else {
            let given = self.options.incumbent.as_ref().map(|(objective, _)| objective - self.base);
            let leaf = self.view.leaf();
            self.best = match given {
                Some(cost) if cost <= leaf => (cost, Best::Given),
                _ => (leaf, Best::Plan(Plan::Leaf)),
            };
        }
        if self.supervision.reason().is_some() {
            return;
        }
        let (samples, upper, tables) = (self.samples, self.best.0, self.tables);
        let (base, bound) = (self.base, self.bound);
        let mut sets = Sets::new(problem, samples, self.options.switches, &self.control, Some(&relaxed), upper);
        if let Some(open) = &open {
            sets = sets.go_on(open);
        }
        let (before, p, control) = (self.tree(), samples.p, &self.control);
        let state_now = || {
            let (cost, tree) = sets.best();
            Known {
                level: problem.depth,
                whole: 0,
                order: vec![FeatureIncumbent::NOTHING; p],
                incumbents: vec![FeatureIncumbent::NOTHING; p],
                cuts: Vec::new(),
                bound: bound.min(cost),
                best: (cost, tree.unwrap_or_else(|| before.clone())),
                n_nodes: control.n_evaluated(),
                sets: Some(sets.open()),
            }
        };
        let mut due = std::mem::take(&mut self.due);
        self.supervision.run_all(
            self.options.n_threads.max(1),
            || sets.work(),
            || {
                let progress = self.progress(sets.best().0 + base, bound + base);
                self.poll(
                    &mut |state| keep_going(state) && due.save(false, &state_now),
                    progress,
                    tables + sets.bytes() as f64,
                );
            },
        );
        due.save(true, &state_now);
        self.due = due;
        let (cost, tree) = sets.best();
        if let Some(tree) = tree {
            self.best = (cost, Best::Tree(tree));
        }
        if self.supervision.reason().is_none() {
            self.bound = cost;
        }
    }

    /// Progress with a bound, the evaluated cuts counted so far.
    fn progress(&self, objective: i64, bound: i64) -> Progress {
        Progress { seconds: 0.0, objective, bound, n_nodes: self.control.n_evaluated() }
    }

    /// Report to the caller and compare a state with all limits.
    fn poll(&self, keep_going: KeepGoing<'_>, state: Progress, bytes: f64) {
        self.supervision.poll(keep_going, state);
        let gap = self.supervision.gap_reached((state.objective - state.bound) as f64, state.objective as f64);
        if let Some(reason) = self.supervision.spent(state.n_nodes, bytes).or(gap) {
            self.supervision.stop(reason);
        }
    }

    fn tree(&self) -> Tree {
        match (&self.best.1, &self.options.incumbent) {
            (Best::Tree(tree), _) | (Best::Given, Some((_, tree))) => tree.clone(),
            (Best::Plan(plan), _) => plan.tree(self.samples, self.view),
            (Best::Given, None) => Plan::Leaf.tree(self.samples, self.view),
        }
    }

    fn outcome(self) -> Outcome {
        let objective = self.base + self.best.0;
        let bound = self.base + self.bound.min(self.best.0);
        let tree = self.tree();
        let stop =
            if bound >= objective { Stop::Optimal } else { self.supervision.reason().unwrap_or(Stop::Interrupted) };
        Outcome { tree, objective, bound, stop, n_nodes: self.control.n_evaluated() }
    }
}

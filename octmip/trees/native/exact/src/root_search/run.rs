//! State of the whole search, and its levels one after the other.

use crate::node::kept::{Shared, keeps};
use crate::node::plan::Plan;
use crate::node::result::{FeatureIncumbent, Solved};
use crate::node::search::Search;
use crate::root_search::elsewhere::Elsewhere;
use crate::root_search::frontier::{Frontier, Level};
use crate::root_search::known::{Due, Known, Saver};
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_check::problem::Problem;
use octmip_frame::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use octmip_frame::effort::Control;
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;

/// Values of a table whose lists are worth less than their memory, and whose bound is raised step by step.
pub(crate) const LARGE: usize = 1 << 22;

/// Percent of the incumbent's cost that a large table is asked for first.
const SHARES: [i64; 2] = [75, 96];

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
pub(crate) enum Best {
    /// The incumbent that was given.
    Given,
    /// A plan of this search.
    Plan(Plan),
    /// An earlier search, or the one over sensor sets.
    Tree(Tree),
}

/// Of the trees of one level fewer: a bound, each feature's incumbent at the root, the cuts that were solved.
pub(crate) type Below = (i64, Vec<FeatureIncumbent>, Vec<Solved>);

/// State of a search.
pub(crate) struct Run<'a, 's> {
    pub(crate) problem: &'a Problem,
    pub(crate) samples: &'a Samples,
    pub(crate) view: &'a View,
    pub(crate) options: &'a Options,
    pub(crate) control: Control,
    pub(crate) supervision: Supervision,
    /// Bytes of the tables that do not grow.
    pub(crate) tables: f64,
    /// What no tree avoids, in the problem's unit; every other cost here is in that of the samples.
    pub(crate) base: i64,
    /// Objective (above the base) of the best tree, and where it comes from.
    pub(crate) best: (i64, Best),
    pub(crate) bound: i64,
    pub(crate) known: Option<Known>,
    pub(crate) due: Due<'s>,
    /// Who solves the cuts of the root; None: the threads of this process.
    pub(crate) elsewhere: Option<&'s Elsewhere<'s>>,
    /// Results of nodes below the cuts that are entered.
    pub(crate) shared: Shared,
    /// Cuts evaluated by the free problem that was searched first.
    pub(crate) n_free: u64,
    /// Cost of the tree to show in the place of those found here, if this is the free problem of another one.
    pub(crate) shown: Option<i64>,
    /// What the last level has shown: the bound of one level fewer, the others its own.
    pub(crate) last: Below,
}

impl<'a, 's> Run<'a, 's> {
    /// A search that begins with the best of leaf, incumbent and what is known.
    pub(crate) fn new(
        problem: &'a Problem,
        (samples, view): (&'a Samples, &'a View),
        options: &'a Options,
        supervision: Supervision,
        tables: f64,
        known: Option<Known>,
        saver: Option<Saver<'s>>,
    ) -> Self {
        let base = samples.base_cost();
        let mut run = Run {
            problem,
            samples,
            view,
            options,
            control: Control::reading(supervision.flag()),
            supervision,
            tables,
            base,
            best: (view.leaf(), Best::Plan(Plan::Leaf)),
            bound: 0,
            known,
            due: Due::new(saver),
            elsewhere: None,
            shared: Shared::default(),
            n_free: 0,
            shown: None,
            last: Below::default(),
        };
        if let Some((objective, _)) = &options.incumbent
            && samples.counted(objective - base) <= run.best.0
        {
            run.best = (samples.counted(objective - base), Best::Given);
        }
        if let Some(Known { best: (cost, tree), .. }) = &run.known
            && *cost < run.best.0
        {
            run.best = (*cost, Best::Tree(tree.clone()));
        }
        run
    }

    /// The same with somebody else to solve the cuts of the root, if there is one.
    pub(crate) fn helped_by(self, elsewhere: Option<&'s Elsewhere<'s>>) -> Self {
        Self { elsewhere, ..self }
    }
}

impl Run<'_, '_> {
    /// Level after level; the bound of the last, without the budget of sensors.
    pub(crate) fn search(&mut self, depth: usize, keep_going: KeepGoing<'_>) {
        if self.best.0 <= self.samples.penalty || self.samples.p == 0 || self.samples.n_labels == 1 {
            self.bound = self.best.0;
            return;
        }
        if self.known.as_ref().is_some_and(|known| known.sets.is_some()) {
            self.bound = self.known.as_ref().map_or(0, |known| known.bound);
            return;
        }
        if self.samples.free.is_some() && depth > 2 {
            return self.search_beside(depth, keep_going);
        }
        let ((mut whole, mut incumbents, mut fewer), first) = match &self.known {
            Some(known) => ((known.whole, known.order.clone(), Vec::new()), known.level),
            None => (self.shallow(depth.min(2), keep_going), 3),
        };
        if depth <= 2 {
            self.bound = whole;
            return;
        }
        let levels: Vec<usize> = (first..=depth).filter(|&level| self.is_searched(level, first)).collect();
        for level in levels {
            let before = self.level_before(level);
            self.bound = self.bound.max(self.deeper(whole, before, depth));
            if self.supervision.reason().is_some() || self.bound >= self.best.0 {
                return;
            }
            // The incumbent may be deeper than this level: the level's own trees are asked for up to its cost.
            let (upper, shown) = (self.best.0, if before + 1 == level { whole } else { 0 });
            let asked = Level { before, depth: level, upper, incumbents: &incumbents, whole, fewer: &fewer, free: &[] };
            let known = self.known.take();
            let known = known.as_ref().map(|known| (&known.cuts[..], &known.incumbents[..]));
            let (found, _) = self.deep(&asked, depth, known, keep_going);
            (whole, incumbents, fewer) = found;
            self.last = (shown, incumbents.clone(), fewer.clone());
        }
    }

    /// Whether trees of this level are searched by themselves: the levels in between only repeat each other where sets
    /// of samples are few.
    fn is_searched(&self, level: usize, first: usize) -> bool {
        level == first || level == 3 || level == self.problem.depth || !self.skips_levels()
    }

    /// The level that is searched before this one.
    fn level_before(&self, level: usize) -> usize {
        if level > 4 && self.skips_levels() { 3 } else { level - 1 }
    }

    fn skips_levels(&self) -> bool {
        keeps(self.samples, &self.options.switches, self.problem.depth) && self.samples.has_few_boxes()
    }

    /// What no tree of `depth` avoids, where none of `level` costs less than `bound`.
    fn deeper(&self, bound: i64, level: usize, depth: usize) -> i64 {
        if level < depth && !self.options.switches.level_below {
            return 0;
        }
        let next = |bound, level| one_level_deeper(bound, level, self.view.total_range, self.samples.penalty);
        let by_halves = (level..depth).fold(bound, next).max(0);
        if !self.options.switches.price {
            return by_halves;
        }
        // Deeper trees pay for as many splits as they have levels.
        by_halves.max(bound.min(self.samples.penalty.saturating_mul(level as i64 + 1)))
    }

    /// Depth one or two, by one thread; a bound of that depth's trees, and each feature's incumbent.
    ///
    /// Deeper levels build on the best cost itself. The last one is asked for what undercuts the incumbent.
    fn shallow(&mut self, depth: usize, keep_going: KeepGoing<'_>) -> Below {
        let is_tight = self.problem.sensor_cost.iter().sum::<f64>() > self.problem.sensor_limit;
        let is_last = depth == self.problem.depth && !is_tight;
        if is_last && depth == 2 && self.samples.n * self.samples.p >= LARGE {
            self.raise(keep_going);
        }
        let whole = self.view.leaf() + 1;
        let upper = if is_last { whole.min(self.best.0) } else { whole };
        let (lower, incumbents, solved) = self.asked(depth, upper, keep_going);
        (lower.max(self.bound), incumbents, solved)
    }

    /// Raise the bound of a large table step by step: few neighbours close the cuts whose trees cost far more than the
    /// upper limit, and few buckets are walked.
    fn raise(&mut self, keep_going: KeepGoing<'_>) {
        for percent in SHARES {
            let upper = self.best.0 / 100 * percent;
            if upper > self.bound && self.supervision.reason().is_none() {
                self.bound = self.bound.max(self.asked(2, upper, keep_going).0);
            }
        }
    }

    /// Search for trees of one or two levels below `upper`; the best is taken up. The bound is 0 where the search is
    /// stopped.
    fn asked(&mut self, depth: usize, upper: i64, keep_going: KeepGoing<'_>) -> Below {
        let work = || {
            let mut search = Search::new(self.samples, self.options.switches, &self.control, depth);
            let result = search.solve(self.view, depth, upper, self.bound);
            (result, search.incumbents, search.solved)
        };
        let (result, incumbents, solved) = self.supervision.run(work, || {
            self.poll(keep_going, self.progress(self.best.0, self.bound), self.tables);
        });
        if let Some((cost, plan)) = result.best
            && cost < self.best.0
        {
            self.best = (cost, Best::Plan(plan));
        }
        (if self.supervision.reason().is_some() { 0 } else { result.lower }, incumbents, solved)
    }

    /// Depth three or more, by all threads; and the solved cuts with the bounds of leaves of any size. `last`: the
    /// level that is wanted in the end.
    pub(crate) fn deep(
        &mut self,
        level: &Level<'_>,
        last: usize,
        known: Option<(&[Solved], &[FeatureIncumbent])>,
        keep_going: KeepGoing<'_>,
    ) -> (Below, Vec<Solved>) {
        let &Level { depth, upper, incumbents, whole, .. } = level;
        let is_last = depth == last;
        let (samples, view, switches) = (self.samples, self.view, self.options.switches);
        let shared = std::mem::take(&mut self.shared);
        let frontier = Frontier::new(samples, switches, &self.control, view, level, known)
            .sharing(&shared)
            .by_windows_of(self.elsewhere.map_or(0, |elsewhere| elsewhere.round));
        let (tables, before, control) = (self.tables, (self.best.0, self.tree()), &self.control);
        let n_free = self.n_free;
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
                best: best.unwrap_or_else(|| before.clone()),
                n_nodes: control.n_evaluated() - n_free,
                sets: None,
            }
            .map_costs(|cost| samples.cost(cost))
            .without(-samples.base_cost())
        };
        let elsewhere = self.elsewhere;
        let work = || match elsewhere {
            Some(elsewhere) => frontier.work_by(|_, cut| elsewhere.solve(depth, cut, control)),
            None => {
                let mut search = Search::new(samples, switches, control, depth).sharing(&shared, last);
                if depth == 3 {
                    search.prepare(view);
                }
                frontier.work(&mut search);
            }
        };
        let n_threads = if elsewhere.is_some() { frontier.size() } else { self.options.n_threads.max(1) };
        let mut due = std::mem::take(&mut self.due);
        let shown = |(cost, bound): (i64, i64)| self.deeper(bound, depth, last).max(self.bound).min(cost);
        self.supervision.run_all(n_threads, work, || {
            let (cost, bound) = frontier.progress();
            let progress = self.progress(if cost < upper { cost } else { self.best.0 }, shown((cost, bound)));
            self.poll(
                &mut |state| keep_going(state) && due.save(false, &state_now),
                progress,
                tables + frontier.bytes() as f64,
            );
        });
        if is_last || self.supervision.reason().is_some() {
            due.save(true, &state_now);
        }
        let (cost, bound) = frontier.progress();
        self.bound = shown((cost, bound));
        self.due = due;
        if let Some((cost, plan)) = frontier.best() {
            self.best = (cost, Best::Plan(plan));
        }
        let below = (bound.min(cost), frontier.incumbents(), frontier.solved());
        let free = frontier.free();
        drop(frontier);
        self.shared = shared;
        (below, free)
    }

    /// Progress with an objective and a bound above the base, the evaluated cuts counted so far.
    pub(crate) fn progress(&self, objective: i64, bound: i64) -> Progress {
        let objective = self.shown.unwrap_or(objective);
        let [objective, bound] = [objective, bound].map(|cost| self.base + self.samples.cost(cost));
        Progress { seconds: 0.0, objective, bound, n_nodes: self.control.n_evaluated() }
    }

    /// Report to the caller and compare a state with all limits.
    pub(crate) fn poll(&self, keep_going: KeepGoing<'_>, state: Progress, bytes: f64) {
        self.supervision.poll(keep_going, state);
        let gap = self.supervision.gap_reached((state.objective - state.bound) as f64, state.objective as f64);
        if let Some(reason) = self.supervision.spent(state.n_nodes, bytes).or(gap) {
            self.supervision.stop(reason);
        }
    }

    /// The best tree.
    pub(crate) fn tree(&self) -> Tree {
        match (&self.best.1, &self.options.incumbent) {
            (Best::Tree(tree), _) | (Best::Given, Some((_, tree))) => tree.clone(),
            (Best::Plan(plan), _) => plan.tree(self.samples, self.view),
            (Best::Given, None) => Plan::Leaf.tree(self.samples, self.view),
        }
    }

    /// Tree, bound and reason at the end.
    pub(crate) fn outcome(self) -> Outcome {
        let objective = self.base + self.samples.cost(self.best.0);
        let bound = self.base + self.samples.cost(self.bound.min(self.best.0));
        let tree = self.tree();
        let stop =
            if bound >= objective { Stop::Optimal } else { self.supervision.reason().unwrap_or(Stop::Interrupted) };
        Outcome { tree, objective, bound, stop, n_nodes: self.control.n_evaluated() }
    }
}

/// What no tree of `level + 1` costs less than, where none of `level` costs less than `bound`; may be negative.
///
/// Put the better leaf in the place of each split of the last level: what those leaves gain is halved at most, no other
/// leaf loses, and the tree is one level less deep. So cost(level) <= (cost(level + 1) + range) / 2, and half a penalty
/// more for each split above the last level, of which there are fewer than 2^level.
pub fn one_level_deeper(bound: i64, level: usize, range: i64, penalty: i64) -> i64 {
    let splits = penalty.saturating_mul((1 << level.min(20)) - 1);
    bound.saturating_mul(2).saturating_sub(range).saturating_sub(splits)
}

//! A problem of leaves of a least size, from three levels on: its free problem first, then trees a little above the
//! cost of that (`node::beside`).

use crate::node::beside::first_step;
use crate::node::plan::Plan;
use crate::node::result::Solved;
use crate::node::search::{Cut, Search};
use crate::root_search::elsewhere::Elsewhere;
use crate::root_search::frontier::Level;
use crate::root_search::run::{Below, Best, Options, Run};
use octmip_check::problem::Problem;
use octmip_frame::control::KeepGoing;
use octmip_frame::effort::Control;
use octmip_frame::supervise::Supervision;

impl Run<'_, '_> {
    /// The best tree of `depth` levels, and its bound.
    pub(crate) fn search_beside(&mut self, depth: usize, keep_going: KeepGoing<'_>) {
        let (whole, order, mut free) = self.search_free(depth, keep_going);
        let (least, mut step) = (self.bound, first_step(self.bound, self.view));
        let known = self.known.take();
        self.bound = self.bound.max(known.as_ref().map_or(0, |known| known.bound));
        let (mut cuts, mut incumbents) = known.map_or_else(Default::default, |known| (known.cuts, known.incumbents));
        while self.bound < self.best.0 && self.supervision.reason().is_none() {
            // What was closed below less is open again, unless it costs as much as is asked for now.
            let upper = self.best.0.min(least.saturating_add(step));
            step = step.saturating_mul(2);
            if upper <= self.bound {
                continue;
            }
            let target = upper - self.samples.penalty;
            let closed: Vec<Solved> =
                cuts.iter().filter(|cut| cut.bounds[0] + cut.bounds[1] >= target).copied().collect();
            let known = (!closed.is_empty()).then_some((&closed[..], &incumbents[..]));
            let asked = Level { before: depth - 1, depth, upper, incumbents: &order, whole, fewer: &[], free: &free };
            let ((_, found, solved), bounds) = self.deep(&asked, depth, known, keep_going);
            (incumbents, cuts) = (found, solved);
            free.extend(bounds);
        }
    }

    /// Search the free problem, and take up what it shows: a bound, and its tree where its leaves can be made large
    /// enough. A bound of one level fewer, each feature's incumbent, and the cuts that were solved.
    fn search_free(&mut self, depth: usize, keep_going: KeepGoing<'_>) -> Below {
        let Some(samples) = self.samples.free.as_deref() else { return Below::default() };
        let problem = Problem { leaf_size: 1, ..self.problem.clone() };
        let incumbent = Some((self.base + self.samples.cost(self.best.0), self.tree()));
        let options = Options { incumbent, ..self.options.clone() };
        let asks = self.elsewhere.map(|elsewhere| {
            let ask = |level: usize, cut: &Cut, control: &Control| {
                (elsewhere.ask)(level, &Cut { is_free: true, ..*cut }, control)
            };
            (ask, elsewhere.round)
        });
        let elsewhere = asks.as_ref().map(|(ask, round)| Elsewhere { ask, round: *round });
        // Time, stop flag and limits are those of the whole search.
        let supervision = std::mem::replace(&mut self.supervision, Supervision::new(self.options.limits));
        let mut run = Run::new(&problem, (samples, self.view), &options, supervision, self.tables, None, None)
            .helped_by(elsewhere.as_ref());
        run.shown = Some(self.best.0);
        run.search(depth, keep_going);
        let is_given = matches!(run.best.1, Best::Given);
        let (bound, tree, last) = (run.bound.min(run.best.0), run.tree(), std::mem::take(&mut run.last));
        self.n_free = run.control.n_evaluated();
        self.control.add(self.n_free);
        self.supervision = run.supervision;
        self.bound = self.bound.max(bound);
        if let Some(plan) = Plan::of(self.samples, &tree).filter(|_| !is_given) {
            let mut search = Search::new(self.samples, self.options.switches, &self.control, depth);
            if let Some((cost, plan)) = search.fitted(self.view, &plan).filter(|found| found.0 < self.best.0) {
                self.best = (cost, Best::Plan(plan));
            }
        }
        last
    }
}

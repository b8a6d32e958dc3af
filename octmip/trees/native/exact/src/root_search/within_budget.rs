//! The search over sensor sets as the last part of a run.

use crate::node::plan::Plan;
use crate::node::result::FeatureIncumbent;
use crate::root_search::known::Known;
use crate::root_search::run::{Best, Run};
use crate::root_search::sensor_sets::{Sets, is_within};
use octmip_frame::control::KeepGoing;

impl Run<'_, '_> {
    /// After the search without the budget, whose bound stands: the best tree within it.
    pub(crate) fn keep_budget(&mut self, keep_going: KeepGoing<'_>) {
        let (problem, relaxed) = (self.problem, self.tree());
        let open = self.known.as_mut().and_then(|known| known.sets.take());
        if is_within(problem, &relaxed) {
            if open.is_none() {
                return;
            }
        } else {
            let given =
                self.options.incumbent.as_ref().map(|(objective, _)| self.samples.counted(objective - self.base));
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
        let bound = self.bound;
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
            .map_costs(|cost| samples.cost(cost))
            .without(-samples.base_cost())
        };
        let mut due = std::mem::take(&mut self.due);
        self.supervision.run_all(
            self.options.n_threads.max(1),
            || sets.work(),
            || {
                let progress = self.progress(sets.best().0, bound);
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
}

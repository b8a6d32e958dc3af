//! Exact subtrees on a subset of the samples: what a local search asks for.

use crate::exact::Switches;
use crate::exact::branch::Search;
use crate::exact::effort::Control;
use crate::exact::samples::Samples;
use crate::exact::view::View;
use crate::tree::Tree;

/// A solver of subtrees; one per thread, as it holds workspaces.
pub struct Subtree<'a> {
    samples: &'a Samples,
    control: &'a Control,
    search: Search<'a>,
}

impl<'a> Subtree<'a> {
    /// A solver that gives up (with None) as soon as `control` says stop.
    pub fn new(samples: &'a Samples, control: &'a Control) -> Self {
        Self {
            samples,
            control,
            search: Search::new(samples, Switches::default(), control, 8),
        }
    }

    /// Objective and tree of at most `depth` levels on the samples `ids` if one costs less than `upper`.
    ///
    /// `ids` are indices of the problem's samples, none twice. None is the proof that there is no such tree, unless
    /// the solver was stopped. The objective counts `ids` alone.
    pub fn best(&mut self, ids: &[u32], depth: usize, upper: i64) -> Option<(i64, Tree)> {
        if ids.is_empty() {
            return None;
        }
        let view = View::subset(self.samples, ids);
        let base: i64 = ids.iter().map(|&i| self.samples.base[i as usize]).sum();
        self.search.deepen(depth);
        self.search.forget();
        let answer = self
            .search
            .solve(&view, depth, upper.saturating_sub(base), 0);
        if self.control.is_stopped() {
            return None;
        }
        answer
            .best
            .map(|(cost, plan)| (base + cost, plan.tree(self.samples, &view)))
    }
}

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
        // What an earlier call has laid out, for each width of numbers, knows nothing of the samples of this one.
        self.search = Search::new(self.samples, Switches::default(), self.control, 8);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Problem;

    fn problem(n: usize, p: usize) -> Problem {
        let mut state = 1_u64;
        let mut next = |most: u32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u32 % most
        };
        Problem {
            n,
            p,
            n_classes: 3,
            ranks: (0..n * p).map(|_| next(40)).collect(),
            n_ranks: vec![40; p],
            labels: (0..n).map(|_| next(3)).collect(),
            weights: vec![1; n],
            costs: vec![0, 1, 1, 1, 0, 1, 1, 1, 0],
            penalty: 0,
            depth: 3,
            leaf_size: 1,
            sensor_of_feature: (0..p as u32).collect(),
            sensor_cost: vec![1.0; p],
            sensor_limit: f64::INFINITY,
            allowed: vec![true; p],
            planes: None,
        }
    }

    #[test]
    fn one_solver_answers_on_other_samples_as_a_new_one_does() {
        let problem = problem(300, 4);
        let (samples, control) = (Samples::new(&problem), Control::new());
        let mut kept = Subtree::new(&samples, &control);
        let (first, second): (Vec<u32>, Vec<u32>) = ((0..150).collect(), (150..300).collect());
        for (ids, depth) in [
            (&first, 3),
            (&second, 2),
            (&first, 2),
            (&second, 3),
            (&first, 1),
        ] {
            let cost = |found: Option<(i64, Tree)>| found.map(|found| found.0);
            let fresh = Subtree::new(&samples, &control).best(ids, depth, i64::MAX);
            assert_eq!(cost(kept.best(ids, depth, i64::MAX)), cost(fresh));
        }
    }
}

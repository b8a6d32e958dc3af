//! Branch and bound for trees of a wanted shape: at most so many splits, predictions that keep the order of a feature,
//! parts that are given, ruled out or kept.
//!
//! ```text
//! wanted     the shape that is asked for, and what is known so far
//! few        the best tree of at most so many splits: the splits are shared out between both sides of every cut
//! boxes      what a node holds of the space of ranks, and which two leaves must be in order
//! monotone   the best tree that keeps the order, from the best one that need not as a bound
//! stump      the same of one split
//! coupled    a cut of a monotone feature: one side leaf by leaf, the other solved beside it
//! last_cuts  cuts whose sides are leaves
//! rules      given splits, features that may not follow each other, an old tree
//! left       the features that are left beside those that a path has banned
//! obeys      whether trees and cuts have those parts
//! old_tree   what its splits cost where they stay
//! changes    bounds for trees that change few splits of an old one
//! parts      the best tree that obeys them, from the best one that need not as a bound
//! ```

mod boxes;
mod changes;
mod coupled;
mod few;
mod last_cuts;
mod left;
mod monotone;
mod obeys;
mod old_tree;
mod parts;
mod rules;
mod stump;
mod wanted;

use crate::root_search::memory;
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_check::problem::Problem;
use octmip_frame::control::{KeepGoing, Outcome, Progress, Stop};
use octmip_frame::effort::Control;
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;

use few::Few;
use left::sets_of_features;
use monotone::Monotone;
use parts::Parts;
use wanted::Known;

pub use rules::{NO_LIMIT, Named, Rules};
pub use wanted::Options;

/// The best tree of the shape, and a bound; `i64::MAX` is the objective where no tree was found.
pub fn solve(problem: &Problem, options: &Options, keep_going: KeepGoing<'_>) -> Outcome {
    let supervision = Supervision::new(options.limits);
    let switches = Switches::default();
    let is_ordered = options.directions.iter().any(|&direction| direction != 0);
    // Merged samples have fewer places for a threshold, and for the order a place counts that parts no samples; a given
    // split counts every sample that it parts.
    let is_whole = is_ordered || options.rules.is_some();
    let samples =
        if is_whole { Samples::new(problem).in_units_of(problem) } else { Samples::in_few_rows(problem, &switches) };
    let samples = samples.beside_free(&switches);
    let view = View::root(&samples);
    let base = samples.base_cost();
    let counted = |(objective, tree): &(i64, Tree)| (samples.counted(objective - base), tree.clone());
    let given = options.incumbent.as_ref().map(counted);
    // One above the leaf, so that the search finds the leaf itself where nothing is better.
    let beyond = options.rules.as_ref().map_or(view.leaf() + 1, |rules| Parts::beyond(&samples, &view, rules));
    let start = given.map_or((beyond, None), |(cost, tree)| (cost, Some(tree)));
    let known = Known::new(start);
    let control = Control::reading(supervision.flag());
    let tables = memory::bytes(problem, 1, &switches);
    let lefts = options.rules.as_ref().map_or_else(Vec::new, |rules| sets_of_features(&samples, rules));
    let work = || {
        let upper = known.best().0;
        if let Some(rules) = &options.rules {
            let size = (problem.depth, options.max_splits);
            return Parts::new(&samples, rules, &lefts, &control, size).search(&view, size, &known);
        }
        let few = Few::new(&samples, &control, problem.depth, options.max_splits);
        if is_ordered {
            Monotone::new(problem, options, few, &known).search(&view, options.free.as_ref().map(counted));
        } else {
            few.search(&view, upper, &known);
        }
    };
    supervision.run(work, || {
        let (cost, bound) = (known.best().0, known.bound());
        let [objective, bound] = [cost, bound.min(cost)].map(|cost| base + samples.cost(cost));
        let n_nodes = control.n_evaluated();
        supervision.poll(keep_going, Progress { seconds: 0.0, objective, bound, n_nodes });
        let gap = supervision.gap_reached((objective - bound) as f64, objective as f64);
        if let Some(reason) = supervision.spent(n_nodes, tables).or(gap) {
            supervision.stop(reason);
        }
    });
    let reason = supervision.reason();
    if options.rules.is_some() && known.best().1.is_none() {
        return no_tree(&view, &samples, reason, control.n_evaluated());
    }
    outcome(&samples, &view, &known, reason, control.n_evaluated())
}

/// No tree was found: there is none, unless the search was stopped.
fn no_tree(view: &View, samples: &Samples, reason: Option<Stop>, n_nodes: u64) -> Outcome {
    let tree = Tree::leaf(samples.labels[view.best_label()]);
    let stop = reason.unwrap_or(Stop::Optimal);
    Outcome { tree, objective: i64::MAX, bound: samples.base_cost(), stop, n_nodes }
}

fn outcome(samples: &Samples, view: &View, known: &Known, reason: Option<Stop>, n_nodes: u64) -> Outcome {
    let (cost, tree) = known.best();
    let (cost, tree) = match tree {
        Some(tree) => (cost, tree),
        None => (view.leaf(), Tree::leaf(samples.labels[view.best_label()])),
    };
    let bound = known.bound().min(cost);
    let [objective, bound] = [cost, bound].map(|cost| samples.base_cost() + samples.cost(cost));
    let stop = if bound >= objective { Stop::Optimal } else { reason.unwrap_or(Stop::Interrupted) };
    Outcome { tree, objective, bound, stop, n_nodes }
}

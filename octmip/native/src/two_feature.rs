//! Optimal trees whose splits use up to two features, proven by branch and bound over cells of lines.

pub mod bounds;
pub mod boxes;
pub mod budget;
pub mod cell;
pub mod chart;
pub mod ends;
pub mod extract;
pub mod ground;
pub mod known;
pub mod labels;
pub mod loss;
pub mod margin;
pub mod pair;
pub mod plane;
pub mod proof;
pub mod queue;
pub mod realise;
pub mod refine;
pub mod scan;
pub mod single;
pub mod start;
pub mod strips;
pub mod stump;
pub mod sweep;
pub mod switches;
pub mod view;
pub mod wide;

use crate::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use crate::problem::Problem;
use crate::supervise::Supervision;
use crate::tree::Tree;

use extract::{Sketch, draw};
use ground::Ground;
use loss::INFEASIBLE;
use switches::Switches;

/// How to search.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// When to stop early.
    pub limits: Limits,
    /// Threads; the result does not depend on them.
    pub n_threads: usize,
    /// Trees of this cost and more are of no interest.
    pub known: Option<i64>,
    /// Of the first trees' random choices.
    pub seed: u64,
    /// What to do without.
    pub switches: Switches,
    /// Coefficients become whole numbers of at most this size where some part the samples alike.
    pub whole_coefficients: Option<i64>,
}

/// Find an optimal tree of depth 1 or 2 and prove it so.
///
/// The bound holds for every tree whose lines are taken in exact arithmetic over the values as given. Returns None for
/// deeper trees.
pub fn solve(problem: &Problem, options: &Options, keep_going: KeepGoing) -> Option<Outcome> {
    let watch = Supervision::new(options.limits);
    let mut ground = Ground::new(problem);
    ground.switches = options.switches;
    ground.preferred = options.whole_coefficients;
    match problem.depth {
        1 => Some(solve_single(problem, &ground, &watch, keep_going)),
        2 => Some(pair::solve_pair(problem, &ground, &watch, options, keep_going)),
        _ => None,
    }
}

fn solve_single(problem: &Problem, ground: &Ground, watch: &Supervision, keep_going: KeepGoing) -> Outcome {
    let ids = ground.all();
    let (_, label) = ground.loss.leaf(&ground.view().tally(&ids));
    let leaf = draw(problem, ground, &Sketch::Leaf).unwrap_or((Tree::leaf(label as u32), INFEASIBLE));
    let state = Progress { seconds: 0.0, objective: leaf.1, bound: 0, n_nodes: 0 };
    let work = || {
        let need = problem.leaf_size as i64;
        let charts = &ground.charts;
        single::best_single(ground.view(), charts, &ids, need, INFEASIBLE, [], watch.flag())
    };
    let answer = watch.run(work, || watch.poll(keep_going, state));
    let drawn = draw(problem, ground, &Sketch::stump(answer.line));
    let (tree, objective) = drawn.filter(|drawn| drawn.1 <= leaf.1).unwrap_or(leaf);
    let bound = if watch.is_stopped() { 0 } else { answer.lower.min(objective) };
    let stop = match watch.reason() {
        Some(reason) => reason,
        None if bound == objective => Stop::Optimal,
        None => Stop::Finished,
    };
    Outcome { tree, objective, bound, stop, n_nodes: 1 }
}

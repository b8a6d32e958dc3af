//! Optimal trees whose splits use up to two features, proven by branch and bound over regions of lines.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod budget;
mod depth_three;
mod depth_two;
mod geometry;
mod instance;
mod label_count;
mod line_tree;
mod loss;
mod nodes;
mod options;
mod proof;
mod regions;
mod stumps;
mod subproblem;
mod switches;
mod weighted_samples;

pub use geometry::line::Line;
pub use geometry::plane::Plane;
pub use loss::Loss;
pub use nodes::queue::{Saved, Saver};
pub use options::Options;
pub use proof::write as write_proof;
pub use regions::dual_plane::DualPlane;
pub use stumps::depth_one::best_of_dual_planes;
pub use switches::Switches;
pub use weighted_samples::WeightedSamples;

use octmip_check::problem::Problem;
use octmip_frame::control::{KeepGoing, Outcome, Progress, Stop};
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;

use depth_three::solve_depth_three;
use depth_two::solve_depth_two;
use instance::Instance;
use line_tree::{LineTree, to_tree};
use loss::INFEASIBLE;
use stumps::depth_one::best_single;

/// Find an optimal tree of depth 1 to 3 and prove it so.
///
/// The bound holds for every tree whose lines are taken in exact arithmetic over the values as given. It goes on from
/// the state of an earlier search of the problem with the same options, and hands out its own every so often; an error
/// says why there is no search: other depths, or no such state.
pub fn solve(
    problem: &Problem,
    options: &Options,
    kept: (Option<&Saved>, Option<Saver<'_>>),
    keep_going: KeepGoing,
) -> Result<Outcome, String> {
    let supervision = Supervision::new(options.limits);
    let mut instance = Instance::new(problem);
    instance.switches = options.switches;
    instance.preferred = options.whole_coefficients;
    match problem.depth {
        1 => Ok(solve_depth_one(problem, &instance, &supervision, keep_going)),
        2 => solve_depth_two(problem, &instance, &supervision, options, kept, keep_going),
        3 => Ok(solve_depth_three(problem, &instance, &supervision, options, keep_going)),
        depth => Err(format!("depth {depth}; expected 1 to 3")),
    }
}

fn solve_depth_one(
    problem: &Problem,
    instance: &Instance,
    supervision: &Supervision,
    keep_going: KeepGoing,
) -> Outcome {
    let ids = instance.all();
    let (_, label) = instance.loss.leaf(&instance.samples().tally(&ids));
    let leaf = to_tree(problem, instance, &LineTree::Leaf).unwrap_or((Tree::leaf(label as u32), INFEASIBLE));
    let state = Progress { seconds: 0.0, objective: leaf.1, bound: 0, n_nodes: 0 };
    let work = || {
        let need = problem.leaf_size as i64;
        best_single(instance.samples(), &instance.dual_planes, &ids, need, INFEASIBLE, [], supervision.flag())
    };
    let result = supervision.run(work, || supervision.poll(keep_going, state));
    let stump = to_tree(problem, instance, &LineTree::stump(result.line));
    let (tree, objective) = stump.filter(|stump| stump.1 <= leaf.1).unwrap_or(leaf);
    let bound = if supervision.is_stopped() { 0 } else { result.lower.min(objective) };
    let stop = match supervision.reason() {
        Some(reason) => reason,
        None if bound == objective => Stop::Optimal,
        None => Stop::Finished,
    };
    Outcome { tree, objective, bound, stop, n_nodes: 1 }
}

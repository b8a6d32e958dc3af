//! The whole search: incumbent, shallower depths, the root's frontier, sensor budget, limits.

mod beside_free;
pub(crate) mod elsewhere;
pub(crate) mod frontier;
pub(crate) mod known;
pub(crate) mod memory;
pub(crate) mod run;
pub(crate) mod sensor_sets;
mod within_budget;

use crate::samples::merging::merged;
use crate::samples::{Samples, levels_of};
use crate::view::View;
use octmip_check::problem::Problem;
use octmip_frame::control::{KeepGoing, Outcome, Stop};
use octmip_frame::costs::{base_cost, best_leaf};
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;

use elsewhere::Elsewhere;
use known::{Known, Saver};
use run::{LARGE, Run};

pub use run::{Options, one_level_deeper};

/// The best tree of the problem and a bound, from what an earlier search has proven perhaps, handing out what is known
/// every so often; `elsewhere` solves the cuts of the root.
///
/// An error says why what is known cannot be.
pub fn solve<'s>(
    problem: &Problem,
    options: &Options,
    known: Option<Known>,
    saver: Option<Saver<'s>>,
    elsewhere: Option<&'s Elsewhere<'s>>,
    keep_going: KeepGoing<'_>,
) -> Result<Outcome, String> {
    let supervision = Supervision::new(options.limits);
    let tables = memory::bytes(problem, options.n_threads.max(1), &options.switches);
    if tables > options.limits.memory {
        return Ok(without_search(problem, options));
    }
    let smaller = if options.switches.merging { merged(problem, options.switches.cancelling) } else { None };
    let avoided = smaller.as_ref().map_or(0, |smaller| smaller.avoided);
    let problem = smaller.as_ref().map_or(problem, |smaller| &smaller.problem);
    let samples =
        if has_lists_on_demand(problem, options) { Samples::without_order(problem) } else { Samples::new(problem) };
    let mut samples = samples.in_units_of(problem);
    samples.avoided = avoided;
    let samples = samples.beside_free(&options.switches);
    let view = View::root(&samples);
    let known = known.map(|known| known.without(samples.base_cost()).map_costs(|cost| samples.counted(cost)));
    if let Some(known) = &known {
        known.check(&samples, &view, problem.depth, problem.sensor_cost.len())?;
    }
    let mut run = Run::new(problem, (&samples, &view), options, supervision, tables, known, saver).helped_by(elsewhere);
    // Large leaves leave room for few levels; the free problem need not have more either.
    let most = if problem.leaf_size > 1 { levels_of(problem.n, problem.leaf_size).max(1) } else { problem.depth };
    run.search(problem.depth.min(most), keep_going);
    if problem.sensor_cost.iter().sum::<f64>() > problem.sensor_limit {
        run.keep_budget(keep_going);
    }
    Ok(run.outcome())
}

/// Whether the samples in the order of a feature are wanted one feature after the other only.
fn has_lists_on_demand(problem: &Problem, options: &Options) -> bool {
    let is_tight = problem.sensor_cost.iter().sum::<f64>() > problem.sensor_limit;
    let has_buckets = options.switches.buckets && problem.leaf_size == 1;
    problem.depth <= 2 && has_buckets && !is_tight && problem.n * problem.p >= LARGE
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

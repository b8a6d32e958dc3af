//! Depth 2 from beginning to end: tables, first trees, nodes, the best tree and its bound.

use std::sync::Arc;

use crate::budget::affordable_sets;
use crate::instance::Instance;
use crate::label_count::label_count_bound;
use crate::line_tree::{LineTree, to_tree};
use crate::loss::INFEASIBLE;
use crate::nodes::first_trees::first_tree;
use crate::nodes::known::Known;
use crate::nodes::node::{Child, Node, SearchContext};
use crate::nodes::queue::{Queue, Saved, Saver};
use crate::options::Options;
use crate::regions::slope_interval::{GROUP, SlopeInterval};
use octmip_check::problem::Problem;
use octmip_frame::control::{KeepGoing, Outcome, Progress, Stop};
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;

/// Most slope intervals of a dual plane, where memory allows, and fewest.
const MOST_INTERVALS: usize = 64;
const LEAST_INTERVALS: usize = 4;
/// Random roots in a row that may fail to give a better first tree.
const STARTS: usize = 24;
/// Most affordable sets that get a first tree.
const MOST_BEGUN: usize = 8;

/// The slope intervals that the nodes of one affordable set share.
type Intervals = Arc<Vec<SlopeInterval>>;

/// Find the best tree of depth 2 or less; see `Options` for what is known. `kept` is the state of an earlier search of
/// the same problem with the same options; an error says why it is not.
pub(crate) fn solve_depth_two(
    problem: &Problem,
    instance: &Instance,
    supervision: &Supervision,
    options: &Options,
    (kept, saver): (Option<&Saved>, Option<Saver<'_>>),
    keep_going: KeepGoing,
) -> Result<Outcome, String> {
    let leaf = to_tree(problem, instance, &LineTree::Leaf);
    let (tree, objective) = leaf.unwrap_or((Tree::leaf(0), INFEASIBLE));
    let affordable = affordable_intervals(instance, supervision.limits().memory);
    let n_intervals = kept.map_or(affordable, |kept| kept.n_intervals);
    let sets = affordable_sets(problem);
    if n_intervals > affordable {
        return Err(format!("tables of {n_intervals} slope intervals, and memory for {affordable}"));
    }
    let (Some(sets), true) = (sets, n_intervals >= LEAST_INTERVALS) else {
        return Ok(Outcome { tree, objective, bound: 0, stop: Stop::Memory, n_nodes: 0 });
    };
    let floor = floor_of(instance);
    let upper = options.known.unwrap_or(objective).min(objective);
    let prepare = || {
        let context = SearchContext::new(problem, instance, n_intervals, supervision.flag())?;
        let intervals: Vec<Intervals> = sets.iter().map(|set| intervals_of(&context, set)).collect();
        let first = match kept {
            None => first_trees(&context, &intervals, options.seed, floor),
            Some(_) => Vec::new(), // the kept search has had them
        };
        Some((context, intervals, first))
    };
    let state = Progress { seconds: 0.0, objective: upper, bound: 0, n_nodes: 0 };
    let Some((context, intervals, first)) = supervision.run(prepare, || supervision.poll(&mut *keep_going, state))
    else {
        let stop = supervision.reason().unwrap_or(Stop::Interrupted);
        return Ok(Outcome { tree, objective, bound: floor.min(upper), stop, n_nodes: 0 });
    };
    let roots = intervals.iter().flat_map(|intervals| roots_of(&context, intervals, floor));
    let known = Known::new(instance, sets.len());
    let mut queue = Queue::new(&context, supervision, options.n_threads, roots.collect(), upper, known);
    if let Some(kept) = kept {
        queue = queue.go_on(kept).ok_or("nodes that are none of such a search")?;
    }
    for line_tree in &first {
        queue.offer(line_tree);
    }
    let stop = match supervision.reason() {
        Some(reason) => reason,
        None => queue.run(saver, keep_going),
    };
    let bound = queue.bound();
    let (best, n_nodes) = queue.into_best();
    let (tree, objective) = best.unwrap_or((tree, objective));
    Ok(Outcome { tree, objective, bound, stop, n_nodes })
}

/// Number of slope intervals of each dual plane whose tables take half the memory.
fn affordable_intervals(instance: &Instance, memory: f64) -> usize {
    let n_entries = (instance.dual_planes.len() * instance.plane.n) as f64;
    (memory / 2.0 / n_entries.max(1.0) - 1.0).min(MOST_INTERVALS as f64) as usize
}

/// A first tree for each of the first affordable sets.
fn first_trees(context: &SearchContext<'_>, intervals: &[Intervals], seed: u64, floor: i64) -> Vec<LineTree> {
    let begun = intervals.iter().take(MOST_BEGUN);
    let trees = begun.filter_map(|intervals| first_tree(context, intervals, STARTS, seed, floor));
    trees.map(|(_, line_tree)| line_tree).collect()
}

/// Cost of what four leaves leave wrong, whatever they hold.
fn floor_of(instance: &Instance) -> i64 {
    let samples = instance.samples();
    if !instance.switches.label_count {
        return 0;
    }
    let none = vec![0; samples.loss.lanes()];
    label_count_bound(samples.loss, [0, 0], [&none, &none], &samples.tally(&instance.all()))
}

/// The slope intervals of the dual planes whose features are all in a set.
pub(crate) fn intervals_of(context: &SearchContext<'_>, set: &[bool]) -> Intervals {
    let p = context.problem.p;
    let group = if context.instance.switches.grouped { GROUP } else { 1 };
    let mut intervals = Vec::new();
    for (index, dual_plane) in context.dual_planes.iter().enumerate() {
        let (f, g) = dual_plane.features;
        let n = dual_plane.n_intervals() as u16;
        if set[f] && (g == p || set[g]) {
            intervals.extend((0..n).step_by(group as usize).map(|first| SlopeInterval {
                dual_plane: index as u32,
                first,
                n_intervals: group.min(n - first),
                bound: 0,
                gain: INFEASIBLE,
            }));
        }
    }
    Arc::new(intervals)
}

/// One node for every dual plane that has intervals.
fn roots_of(context: &SearchContext<'_>, intervals: &Intervals, floor: i64) -> Vec<Node> {
    let firsts = intervals.iter().filter(|interval| interval.first == 0);
    firsts
        .map(|interval| Node {
            dual_plane: interval.dual_plane,
            region: context.dual_planes[interval.dual_plane as usize].whole(),
            key: floor,
            children: [0, 1].map(|_| Child::new(intervals.clone(), context.all.len())),
            n_learnt: context.all.len(),
        })
        .collect()
}

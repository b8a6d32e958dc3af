//! Depth 2 from the beginning to the end: tables, first trees, boxes, the best tree and its bound.

use std::sync::Arc;

use crate::control::{KeepGoing, Outcome, Progress, Stop};
use crate::problem::Problem;
use crate::supervise::Supervision;
use crate::tree::Tree;

use super::Options;
use super::boxes::{Child, Field, RootBox};
use super::budget::affordable_sets;
use super::chart::Chart;
use super::extract::{Sketch, draw};
use super::ground::Ground;
use super::known::Known;
use super::labels::with_labels;
use super::loss::INFEASIBLE;
use super::queue::Queue;
use super::start::first_tree;
use super::strips::{GROUP, Strip};

/// Strips of a chart where memory allows.
const MOST_STRIPS: usize = 64;
const LEAST_STRIPS: usize = 4;
/// Random roots in a row that may fail to give a better first tree.
const STARTS: usize = 24;

/// Find the best tree of depth 2 or less; see `Options` for what is known.
pub fn solve_pair(
    problem: &Problem,
    ground: &Ground,
    watch: &Supervision,
    options: &Options,
    keep_going: KeepGoing,
) -> Outcome {
    let leaf = draw(problem, ground, &Sketch::Leaf);
    let (tree, objective) = leaf.unwrap_or((Tree::leaf(0), INFEASIBLE));
    let outcome = |tree, objective, bound, stop, n_nodes| Outcome { tree, objective, bound, stop, n_nodes };
    let cells = (ground.charts.len() * ground.plane.n) as f64;
    let n_strips = (watch.limits().memory / 2.0 / cells.max(1.0) - 1.0).min(MOST_STRIPS as f64) as usize;
    let sets = affordable_sets(problem);
    let (Some(sets), true) = (sets, n_strips >= LEAST_STRIPS) else {
        return outcome(tree, objective, 0, Stop::Memory, 0);
    };
    let all = ground.all();
    let floor = floor_of(ground);
    let upper = options.known.unwrap_or(objective).min(objective);
    let prepare = || {
        let charts = ground.charts.iter();
        let field = Field {
            problem,
            ground,
            charts: charts
                .take_while(|_| !watch.is_stopped())
                .map(|&features| Chart::new(&ground.plane, features, n_strips))
                .collect(),
            all,
            stop: watch.flag(),
        };
        let strips: Vec<Arc<Vec<Strip>>> = sets.iter().map(|set| strips_of(&field, set)).collect();
        let first: Vec<Sketch> = strips
            .iter()
            .take(8)
            .filter_map(|strips| first_tree(&field, strips, STARTS, options.seed, floor))
            .map(|(_, sketch)| sketch)
            .collect();
        (field, strips, first)
    };
    let state = Progress { seconds: 0.0, objective: upper, bound: 0, n_nodes: 0 };
    let (field, strips, first) = watch.run(prepare, || watch.poll(&mut *keep_going, state));
    let roots = strips.iter().flat_map(|strips| roots_of(&field, strips, floor));
    let known = Known::new(ground, sets.len());
    let mut queue = Queue::new(&field, watch, options.n_threads, roots.collect(), upper, known);
    for sketch in &first {
        queue.offer(sketch);
    }
    let stop = match watch.reason() {
        Some(reason) => reason,
        None => queue.run(keep_going),
    };
    let bound = queue.bound();
    let (best, n_nodes) = queue.into_best();
    let (tree, objective) = best.unwrap_or((tree, objective));
    outcome(tree, objective, bound, stop, n_nodes)
}

/// What four leaves leave wrong, whatever they hold.
fn floor_of(ground: &Ground) -> i64 {
    let view = ground.view();
    if !ground.switches.labels_due {
        return 0;
    }
    let none = vec![0; view.loss.lanes()];
    with_labels(view.loss, [0, 0], [&none, &none], &view.tally(&ground.all()))
}

/// The strips of the charts whose features are all in a set.
pub(super) fn strips_of(field: &Field<'_>, set: &[bool]) -> Arc<Vec<Strip>> {
    let p = field.problem.p;
    let group = if field.ground.switches.grouped { GROUP } else { 1 };
    let mut strips = Vec::new();
    for (index, chart) in field.charts.iter().enumerate() {
        let (f, g) = chart.features;
        let n = chart.n_strips() as u16;
        if set[f] && (g == p || set[g]) {
            strips.extend((0..n).step_by(group as usize).map(|first| Strip {
                chart: index as u32,
                first,
                n_strips: group.min(n - first),
                bound: 0,
            }));
        }
    }
    Arc::new(strips)
}

/// One box for every chart that has strips.
fn roots_of(field: &Field<'_>, strips: &Arc<Vec<Strip>>, floor: i64) -> Vec<RootBox> {
    let firsts = strips.iter().filter(|strip| strip.first == 0);
    firsts
        .map(|strip| RootBox {
            chart: strip.chart,
            cell: field.charts[strip.chart as usize].whole(),
            key: floor,
            children: [Child::new(strips.clone()), Child::new(strips.clone())],
        })
        .collect()
}

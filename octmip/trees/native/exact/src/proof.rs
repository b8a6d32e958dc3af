//! The proof log: the search once more, its budget at the claim, writing down every cut that it solved.
//!
//! The format is docs/theory/proof.md's; `octmip_check` reads it and knows nothing of what stands here. Children are
//! searched without the bounds of their neighbours (`floor` 0), as a record must stand by itself; the checker carries
//! bounds from cut to cut on its own.

use crate::node::log::Log;
use crate::node::search::{Cut, Search};
use crate::root_search::elsewhere::Elsewhere;
use crate::root_search::frontier::{Frontier, Level};
use crate::root_search::sensor_sets::{Relaxed, Sets};
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_check::problem::Problem;
use octmip_frame::effort::Control;
use octmip_frame::log::Body;

/// Who solves the cuts of the root while a log is written.
#[derive(Clone, Copy)]
pub enum Helpers<'a> {
    /// So many threads of this process.
    Threads(usize),
    /// Other processes, but under a budget of sensors, where this one's only thread does.
    Elsewhere(&'a Elsewhere<'a>),
}

/// The body of a log that proves `claim`, None if it was stopped or the claim does not hold.
///
/// It is the same for any number of threads, or of other processes that solve the cuts of the root.
pub fn write(
    problem: &Problem,
    claim: i64,
    switches: Switches,
    control: &Control,
    helpers: Helpers<'_>,
) -> Option<String> {
    let switches = switches.of_logs();
    let samples = Samples::of_log(problem, &switches);
    let upper = samples.counted(claim - samples.base_cost());
    let mut out = Body::default();
    if problem.sensor_cost.iter().sum::<f64>() > problem.sensor_limit {
        let n_threads = if let Helpers::Threads(n_threads) = helpers { n_threads } else { 1 };
        let sets = Sets::new(problem, &samples, switches, control, None, upper);
        sets.prove(&mut out, n_threads)?;
    } else {
        out.append(&record(&samples, switches, control, problem.depth, upper, helpers)?);
    }
    (!control.is_stopped()).then(|| out.into_lines())
}

/// The record that no tree over these features costs less than `upper` above the base, as the samples count: of leaves
/// of any size, where these cost no less.
fn record(
    samples: &Samples,
    switches: Switches,
    control: &Control,
    depth: usize,
    upper: i64,
    helpers: Helpers<'_>,
) -> Option<String> {
    let Some(free) = samples.free.as_deref() else {
        return own_record(samples, switches, control, depth, upper, helpers);
    };
    let of_free = match helpers {
        Helpers::Threads(_) => own_record(free, switches, control, depth, upper, helpers),
        Helpers::Elsewhere(elsewhere) => {
            let ask = |level: usize, cut: &Cut, control: &Control| {
                (elsewhere.ask)(level, &Cut { is_free: true, ..*cut }, control)
            };
            let elsewhere = Elsewhere { ask: &ask, round: elsewhere.round };
            own_record(free, switches, control, depth, upper, Helpers::Elsewhere(&elsewhere))
        }
    };
    of_free.or_else(|| own_record(samples, switches, control, depth, upper, helpers))
}

/// The same of the leaves that are asked for.
fn own_record(
    samples: &Samples,
    switches: Switches,
    control: &Control,
    depth: usize,
    upper: i64,
    helpers: Helpers<'_>,
) -> Option<String> {
    let view = View::root(samples);
    let logging = |depth| Search::new(samples, switches, control, depth).logging();
    let mut search = logging(depth);
    if depth < 3 || search.is_leaf_best((view.leaf(), view.len), depth, 0) {
        let result = search.solve(&view, depth, upper, i64::MIN);
        let record = search.log.as_mut().and_then(Log::take);
        return record.filter(|_| result.lower >= upper && !control.is_stopped());
    }
    let (shallower, _, incumbents) = search.shallower(&view, depth - 1, view.leaf() + 1, i64::MIN);
    let record = search.last_record();
    let log = search.log.as_mut()?;
    log.shallower(record);
    let below = log.take_lines();
    let whole = shallower.lower;
    let is_tree = samples.free.is_none() && shallower.cost(i64::MAX) < upper;
    if control.is_stopped() || view.leaf() < upper || is_tree {
        return None; // a tree of fewer levels costs less
    }
    let incumbents = &incumbents[..];
    let level = Level { before: depth - 1, depth, upper, incumbents, whole, fewer: &[], free: &[] };
    let frontier = Frontier::new(samples, switches, control, &view, &level, None)
        .by_windows_of(if let Helpers::Elsewhere(elsewhere) = helpers { elsewhere.round } else { 0 });
    match helpers {
        Helpers::Threads(n_threads) => std::thread::scope(|scope| {
            for _ in 0..n_threads.max(1) {
                scope.spawn(|| {
                    let mut search = logging(depth);
                    if depth == 3 {
                        search.prepare(&view);
                    }
                    frontier.work(&mut search);
                });
            }
        }),
        Helpers::Elsewhere(elsewhere) => {
            let frontier = &frontier;
            std::thread::scope(|scope| {
                for _ in 0..frontier.size() {
                    scope.spawn(move || frontier.work_by(|_, cut| elsewhere.solve(depth, cut, control)));
                }
            });
        }
    }
    if control.is_stopped() || frontier.best().is_some() {
        return None;
    }
    let mut log = Log::default();
    let outer = log.open();
    log.append(&below);
    log.append(&frontier.records());
    log.close(outer, depth, samples.leaf_size, samples.base_cost() + samples.cost(upper));
    log.take()
}

impl Sets<'_> {
    /// Write the tree of decisions over sensors, a record at each leaf; None when it cannot be proven.
    fn prove(&self, out: &mut Body, n_threads: usize) -> Option<()> {
        let mut open = self.take_open();
        while let Some(choice) = open.pop() {
            match self.relax(&choice, self.best().0) {
                Relaxed::Closed(features) => {
                    let samples = self.samples.with_features(&features);
                    let depth = self.problem.depth;
                    let helpers = Helpers::Threads(n_threads);
                    out.append(&record(&samples, self.switches, self.control, depth, self.best().0, helpers)?);
                }
                Relaxed::Within(..) => return None,
                Relaxed::Breaking(sensors) => {
                    let (sensor, without, with) = self.decide(&choice, &sensors)?;
                    out.decide(sensor);
                    open.push(with);
                    open.push(without);
                }
            }
        }
        Some(())
    }
}

//! The cuts of a root solved by other processes: what goes out, what comes back, and the solver at the other end.
//!
//! The search at this end is the one that threads do: as many cuts in work at once, chosen and entered in the same
//! order after it. So tree, bound and evaluated cuts are the same wherever the cuts are solved, and a cut that is lost
//! with its process is asked for again. Where results of nodes are kept (`node::kept`), those of other cuts stay at
//! this end: more is evaluated elsewhere, and of equally good trees another may be found.

use crate::node::axis::Beside;
use crate::node::children::Children;
use crate::node::kept::Kept;
use crate::node::plan::Plan;
use crate::node::search::{Cut, Search};
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_check::problem::Problem;
use octmip_frame::effort::Control;
use octmip_frame::tree::Tree;

/// The result of a solved cut: lower bounds of both children, cost and tree where both were found, evaluated cuts.
#[derive(Debug, Clone)]
pub struct SolvedCut {
    /// Lower bounds of both children.
    pub bounds: [i64; 2],
    /// The same with leaves of any size, and of the cut's `sizes`; 0 where that is the problem itself.
    pub free: Beside,
    /// Cost above the base in the search's unit, and the tree.
    pub tree: Option<(i64, Tree)>,
    /// Cuts evaluated.
    pub n_evaluated: u64,
    /// What a log says of it, where one is written.
    pub record: String,
}

/// Asks for the solution of a cut at a level (depth of the trees), until a stop; None when it was stopped.
pub(crate) type Ask<'a> = dyn Fn(usize, &Cut, &Control) -> Option<SolvedCut> + Sync + 'a;

/// Solver of cuts in other processes.
pub struct Elsewhere<'a> {
    /// Asks one of them, and waits.
    pub ask: &'a Ask<'a>,
    /// Cuts in work at once; 0: as many as on one machine.
    pub round: usize,
}

impl Elsewhere<'_> {
    /// The children of a cut.
    pub(crate) fn solve(&self, level: usize, cut: &Cut, control: &Control) -> Option<Children> {
        let solved = (self.ask)(level, cut, control)?;
        control.add(solved.n_evaluated);
        let tree = solved.tree.map(|(cost, tree)| (cost, Plan::Whole(tree)));
        Some(Children { bounds: solved.bounds, free: solved.free, tree, record: solved.record, kept: Kept::default() })
    }
}

/// The other end: a problem ready for cuts of its root to be solved.
pub struct CutSolver {
    samples: Samples,
    view: View,
    switches: Switches,
    is_logged: bool,
}

impl CutSolver {
    /// Of a problem, by the same numbering of samples as the search that asks, or the writer of its log.
    pub fn new(problem: &Problem, switches: Switches, is_logged: bool) -> Self {
        let switches = if is_logged { switches.of_logs() } else { switches };
        let samples = match is_logged {
            true => Samples::of_log(problem, &switches),
            false => Samples::in_few_rows(problem, &switches).beside_free(&switches),
        };
        Self { view: View::root(&samples), samples, switches, is_logged }
    }

    /// The children of a cut at a level, with what a log says of them where one is written; None when it was stopped.
    pub fn solve(&self, level: usize, cut: &Cut, control: &Control) -> Option<SolvedCut> {
        // Leaves of any size are asked for by a root that searches them first.
        let samples = self.samples.free.as_deref().filter(|_| cut.is_free).unwrap_or(&self.samples);
        let search = Search::new(samples, self.switches, control, level);
        let mut search = if self.is_logged { search.logging() } else { search };
        if level == 3 {
            search.prepare(&self.view);
        }
        let Children { bounds, free, tree, record, .. } =
            search.root_children(&self.view, level, (0, cut), &mut [View::default(), View::default()]);
        let tree = tree.map(|(cost, plan)| (cost, plan.tree(samples, &self.view)));
        (!control.is_stopped()).then(|| SolvedCut { bounds, free, tree, n_evaluated: control.n_evaluated(), record })
    }

    /// Whether a cut is one of this problem.
    pub fn has(&self, cut: &Cut) -> bool {
        cut.feature < self.samples.p && 0 < cut.position && cut.position < self.view.len
    }
}

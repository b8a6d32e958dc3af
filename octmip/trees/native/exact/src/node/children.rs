//! Both children of a cut: solved one after the other, joined, and written to the log.

use crate::node::axis::Beside;
use crate::node::kept::Kept;
use crate::node::log::Log;
use crate::node::plan::Plan;
use crate::node::search::{Cut, Search};
use crate::view::View;

/// The children of a solved cut.
#[derive(Debug)]
pub(crate) struct Children {
    /// Lower bounds of both children.
    pub(crate) bounds: [i64; 2],
    /// The same with leaves of any size, and with leaves of the cut's `sizes`; 0 where that is the problem itself.
    pub(crate) free: Beside,
    /// Cost and plan when both were found, the cut itself included.
    pub(crate) tree: Option<(i64, Plan)>,
    /// What a log says of them, where one is written of the root's cuts one by one.
    pub(crate) record: String,
    /// Results of the nodes below it, where they are kept.
    pub(crate) kept: Kept,
}

/// Both sides of a cut: bounds, what was found, what a log says of them, whether their samples are parted.
pub(super) struct Both {
    pub(super) bounds: [i64; 2],
    pub(super) plans: [Option<(i64, Plan)>; 2],
    pub(super) records: [Option<String>; 2],
    pub(super) is_split: bool,
}

impl Search<'_> {
    /// Solve both children of a cut: their bounds, and the tree when both are found.
    pub(crate) fn children(&mut self, view: &View, depth: usize, cut: &Cut, sides: &mut [View; 2]) -> Children {
        if self.free.is_some() {
            return self.children_beside(view, depth, cut, sides);
        }
        let nothing =
            Children { bounds: cut.bounds, free: cut.free, tree: None, record: String::new(), kept: Kept::default() };
        let Some(Both { bounds, plans, records, .. }) = self.both(view, depth, cut, cut.bounds, sides) else {
            return nothing;
        };
        self.log_cut(view, cut, &[records]);
        Children { bounds, tree: self.joined(view, cut, plans), ..nothing }
    }

    /// Log a cut with records of its sides.
    pub(super) fn log_cut(&mut self, view: &View, cut: &Cut, records: &[[Option<String>; 2]]) {
        if let Some(log) = &mut self.log {
            let mut position = [cut.position as u32];
            self.samples.rows_left(view.list(cut.feature), &mut position);
            log.cut(self.samples.features[cut.feature], position[0] as usize, records);
        }
    }

    /// The tree of a cut whose sides were both found, the cut included.
    pub(super) fn joined(&self, view: &View, cut: &Cut, plans: [Option<(i64, Plan)>; 2]) -> Option<(i64, Plan)> {
        let [Some((left, left_plan)), Some((right, right_plan))] = plans else { return None };
        let plan = Plan::split(self.samples, view, cut.feature, cut.position, [left_plan, right_plan]);
        Some((left + right + self.samples.penalty, plan))
    }

    /// Solve both sides of a cut, known to cost `floors` at least; None when stopped.
    ///
    /// With slack a child is solved although the pair is known to lose: its bound then rules out neighbours too.
    pub(super) fn both(
        &mut self,
        view: &View,
        depth: usize,
        cut: &Cut,
        floors: [i64; 2],
        sides: &mut [View; 2],
    ) -> Option<Both> {
        let (left, right) = view.list(cut.feature).split_at(cut.position);
        let parts = [left, right];
        let (mut bounds, mut others, mut is_split) = (floors, cut.bounds, false);
        let first = usize::from(right.len() > left.len());
        let mut plans = [None, None];
        let mut records = [None, None];
        for side in [first, 1 - first] {
            let budget = cut.target + cut.slack - others[1 - side];
            let known = self.part(parts[side], depth - 1, budget, bounds[side]);
            if known.is_err() && !std::mem::replace(&mut is_split, true) {
                self.split(view, cut, sides);
            }
            let result = match known {
                Ok(result) => result,
                Err(Some(unknown)) => self.search(&sides[side], depth - 1, unknown, budget),
                Err(None) => self.solve(&sides[side], depth - 1, budget, bounds[side]),
            };
            if self.is_stopped() {
                return None;
            }
            bounds[side] = bounds[side].max(result.lower);
            others[side] = others[side].max(bounds[side]);
            plans[side] = result.best;
            records[side] = self.log.as_mut().and_then(Log::take);
        }
        Some(Both { bounds, plans, records, is_split })
    }

    pub(super) fn split(&mut self, view: &View, cut: &Cut, sides: &mut [View; 2]) {
        let mut marks = std::mem::take(&mut self.marks);
        view.split(self.samples, cut.feature, cut.position, &mut marks, sides);
        self.marks = marks;
    }

    /// The same for a cut of the root, chosen when `until` were entered, with the lines of its log.
    pub(crate) fn root_children(
        &mut self,
        view: &View,
        depth: usize,
        (until, cut): (usize, &Cut),
        sides: &mut [View; 2],
    ) -> Children {
        self.known.begin(until);
        if let Some(free) = &mut self.free {
            free.known.begin(until);
        }
        let children = self.children(view, depth, cut, sides);
        let record = self.log.as_mut().map_or_else(String::new, Log::take_lines);
        self.report_effort();
        Children { record, kept: self.known.take(), ..children }
    }
}

//! The best single split of any subset of the samples, exactly: leaf, axis-aligned or over two features.
//!
//! Regions of strips are bounded in bulk (`scan`); those that could still win are split as cells, the most promising
//! first (`refine`).

use std::sync::atomic::{AtomicBool, Ordering};

use super::cell::Cell;
use super::chart::Chart;
use super::loss::INFEASIBLE;
use super::realise::Asked;
use super::strips::{Histograms, Limits, Strip};
use super::view::{Line, View};

/// What is asked of a search for the best split.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// The samples.
    pub ids: &'a [u32],
    /// Fewest samples on a side.
    pub need: i64,
    /// Answers of this much and more need not be told apart.
    pub cutoff: i64,
    /// No split is known to cost less.
    pub floor: i64,
    /// Once less than this is attained, the answer no longer matters.
    pub hopeless: i64,
    /// Regions that are split at most; fewer than all give a good split, but no bound.
    pub most_tried: usize,
    /// Strips whose own bound is this much or more are left out.
    pub dead: i64,
    /// What a bound of these samples loses to hold for those that the strips' bounds speak of.
    pub less: i64,
}

/// The answer: every split outside dead strips costs at least `lower`; `line` (none: a leaf) costs `attained`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Answer {
    pub lower: i64,
    pub attained: i64,
    pub line: Option<Line>,
}

/// A region that could still win.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) bound: i64,
    pub(super) order: u32,
    pub(super) features: (usize, usize),
    pub(super) cell: Cell,
}

/// A search for the best split of one set of samples.
pub struct Search<'a> {
    pub(super) view: View<'a>,
    pub(super) ids: &'a [u32],
    pub(super) total: Vec<i64>,
    pub(super) need: i64,
    pub(super) stop: &'a AtomicBool,
    /// Splits that cost this much or more are of no interest.
    pub(super) current: i64,
    pub(super) attained: i64,
    pub(super) line: Option<Line>,
    /// Least cost of a way of parting that no line does with room for rounding.
    pub(super) thin: i64,
    pub(super) candidates: Vec<Candidate>,
    pub(super) chart_start: usize,
    /// So many regions are split at most: all of them for an exact answer.
    pub(super) most_tried: usize,
    pub(super) histograms: Histograms,
    pub(super) asked: Asked,
}

impl<'a> Search<'a> {
    /// Begin with a leaf as the answer.
    pub fn new(view: View<'a>, ids: &'a [u32], need: i64, cutoff: i64, stop: &'a AtomicBool) -> Self {
        let total = view.tally(ids);
        let leaf = if total[view.loss.k] >= need { view.loss.leaf(&total).0 } else { INFEASIBLE };
        Self {
            view,
            ids,
            total,
            need,
            stop,
            current: leaf.min(cutoff),
            attained: leaf,
            line: None,
            thin: INFEASIBLE,
            candidates: Vec::new(),
            chart_start: 0,
            most_tried: usize::MAX,
            histograms: Histograms::new(&view, ids),
            asked: Asked::new(),
        }
    }

    /// Try lines that were good elsewhere.
    pub fn try_lines(&mut self, lines: impl IntoIterator<Item = Line>) {
        for line in lines {
            let cost = self.view.cost_of(&line, self.ids, &self.total, self.need);
            if cost < self.attained && line.is_clear_of(self.view.plane, self.ids) {
                self.offer(cost, line);
            }
        }
    }

    pub(super) fn offer(&mut self, cost: i64, line: Line) {
        if cost < self.attained {
            self.attained = cost;
            self.line = Some(line);
            self.current = self.current.min(cost);
        }
    }

    /// Note where the regions of the next chart begin.
    pub fn begin_chart(&mut self) {
        self.chart_start = self.candidates.len();
    }

    /// Try the middle of the most promising region since `begin_chart`: a better incumbent spares later charts.
    pub fn try_best_of_chart(&mut self) {
        let newest = &self.candidates[self.chart_start..];
        if let Some(best) = newest.iter().min_by_key(|candidate| candidate.bound).copied() {
            let (t, r) = best.cell.center();
            self.try_lines([Line { features: best.features, t, r }]);
            let current = self.current;
            self.candidates.retain(|candidate| candidate.bound < current);
        }
    }

    /// Split the regions that could still win until none is left; returns the answer.
    pub fn finish(mut self, floor: i64) -> Answer {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable_by_key(|candidate| (candidate.bound, candidate.order));
        for candidate in candidates.into_iter().take(self.most_tried) {
            if candidate.bound >= self.current || self.current <= floor || self.is_stopped() {
                break;
            }
            self.refine(candidate);
        }
        Answer { lower: self.current.min(self.thin).max(floor), attained: self.attained, line: self.line }
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Find the best split, looking only at strips that could hold it; their bounds are raised to what was learnt.
///
/// A raised bound holds for these samples (after `less`, for those that the strips speak of) and for every set that
/// contains them.
pub fn best_split(
    view: View<'_>,
    charts: &[Chart],
    question: Question<'_>,
    lines: impl IntoIterator<Item = Line>,
    strips: &mut Vec<Strip>,
    stop: &AtomicBool,
) -> Answer {
    let mut search = Search::new(view, question.ids, question.need, question.cutoff, stop);
    search.most_tried = question.most_tried;
    search.try_lines(lines);
    if search.attained <= question.floor {
        return search.finish(question.floor);
    }
    let limits = Limits { dead: question.dead, less: question.less };
    let mut found = Vec::with_capacity(strips.len() + 16);
    let mut seen = 0;
    for run in strips.chunk_by(|a, b| a.chart == b.chart) {
        let chart = &charts[run[0].chart as usize];
        search.begin_chart();
        for &strip in run {
            search.scan_strips(chart, strip, limits, &mut found);
        }
        search.try_best_of_chart();
        seen += run.len();
        if search.attained < question.hopeless && view.switches.hopeless {
            // The strips have learnt something; the answer is not worth the rest.
            found.extend_from_slice(&strips[seen..]);
            *strips = found;
            return Answer { lower: question.floor, attained: search.attained, line: search.line };
        }
    }
    *strips = found;
    search.finish(question.floor)
}

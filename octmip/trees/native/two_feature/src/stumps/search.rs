//! The search for the best stump: its task, its result and its state.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::geometry::line::Line;
use crate::loss::INFEASIBLE;
use crate::regions::realisation::Separability;
use crate::regions::region::Region;
use crate::stumps::histograms::{Histograms, Most};
use crate::weighted_samples::WeightedSamples;

/// The task of the stump solver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StumpTask<'a> {
    /// The samples.
    pub(crate) ids: &'a [u32],
    /// Fewest samples on a side.
    pub(crate) need: i64,
    /// Results of this much and more need not be distinguished.
    pub(crate) cutoff: i64,
    /// No split is known to cost less.
    pub(crate) floor: i64,
    /// Once the incumbent is below this, the result no longer matters.
    pub(crate) hopeless: i64,
    /// Regions that are split at most; fewer than all give a good split, but no bound.
    pub(crate) most_tried: usize,
    /// Slope intervals whose own bound is this much or more are left out.
    pub(crate) dead: i64,
    /// Reduction of a bound of these samples for it to hold for those that the intervals' bounds speak of.
    pub(crate) less: i64,
    /// The most that the samples can cost, where gains of intervals are known and learnt.
    pub(crate) most: Option<Most>,
}

impl<'a> StumpTask<'a> {
    /// A good split of some samples after so many regions, and no bound.
    pub(crate) fn tried(ids: &'a [u32], need: i64, most_tried: usize) -> Self {
        let (cutoff, dead) = (INFEASIBLE, INFEASIBLE);
        Self { ids, need, cutoff, floor: 0, hopeless: 0, most_tried, dead, less: 0, most: None }
    }
}

/// The result: every split outside dead intervals costs at least `lower`; `line` (none: a leaf) costs `incumbent`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StumpResult {
    pub(crate) lower: i64,
    pub incumbent: i64,
    pub line: Option<Line>,
}

/// A region that could still win.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) bound: i64,
    pub(crate) order: u32,
    pub(crate) features: (usize, usize),
    pub(crate) region: Region,
}

/// The state of a search for the best split of one set of samples.
pub(crate) struct StumpSearch<'a> {
    pub(crate) samples: WeightedSamples<'a>,
    pub(crate) ids: &'a [u32],
    pub(crate) total: Vec<i64>,
    pub(crate) need: i64,
    pub(crate) stop: &'a AtomicBool,
    /// Splits that cost this much or more are of no interest.
    pub(crate) current: i64,
    pub(crate) incumbent: i64,
    pub(crate) line: Option<Line>,
    /// Least cost of a numerically undecided dichotomy: no line makes it with room for rounding.
    pub(crate) undecided: i64,
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) plane_start: usize,
    /// Number of regions that are split at most: all of them for an exact result.
    pub(crate) most_tried: usize,
    pub(crate) histograms: Histograms,
    pub(crate) separability: Separability,
}

impl<'a> StumpSearch<'a> {
    /// Begin with a leaf as the result.
    pub(crate) fn new(
        samples: WeightedSamples<'a>,
        ids: &'a [u32],
        need: i64,
        cutoff: i64,
        stop: &'a AtomicBool,
    ) -> Self {
        let total = samples.tally(ids);
        let leaf = if total[samples.loss.k] >= need { samples.loss.leaf(&total).0 } else { INFEASIBLE };
        Self {
            samples,
            ids,
            total,
            need,
            stop,
            current: leaf.min(cutoff),
            incumbent: leaf,
            line: None,
            undecided: INFEASIBLE,
            candidates: Vec::new(),
            plane_start: 0,
            most_tried: usize::MAX,
            histograms: Histograms::new(&samples, ids),
            separability: Separability::new(),
        }
    }

    /// Try lines that were good elsewhere.
    pub(crate) fn try_lines(&mut self, lines: impl IntoIterator<Item = Line>) {
        for line in lines {
            let cost = self.samples.cost_of(&line, self.ids, &self.total, self.need);
            if cost < self.incumbent && line.is_clear_of(self.samples.plane, self.ids) {
                self.offer(cost, line);
            }
        }
    }

    /// Take a line as the incumbent if it is better.
    pub(crate) fn offer(&mut self, cost: i64, line: Line) {
        if cost < self.incumbent {
            self.incumbent = cost;
            self.line = Some(line);
            self.current = self.current.min(cost);
        }
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

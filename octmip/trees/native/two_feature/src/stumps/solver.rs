//! The stump solver: the best leaf or single split, axis-aligned or over two features, of any subset of the samples.
//!
//! Regions of slope intervals are bounded in bulk (`scan`); those that could still win are split, the most promising
//! first (`refine`).

use std::sync::atomic::AtomicBool;

use crate::geometry::line::Line;
use crate::regions::dual_plane::DualPlane;
use crate::regions::slope_interval::SlopeInterval;
use crate::stumps::histograms::Limits;
use crate::stumps::search::{StumpResult, StumpSearch, StumpTask};
use crate::weighted_samples::WeightedSamples;

impl StumpSearch<'_> {
    /// Note where the regions of the next dual plane begin.
    pub(crate) fn begin_dual_plane(&mut self) {
        self.plane_start = self.candidates.len();
    }

    /// Try the middle of the most promising region since `begin_dual_plane`: a better incumbent spares later dual
    /// planes.
    pub(crate) fn try_best_of_dual_plane(&mut self) {
        let newest = &self.candidates[self.plane_start..];
        if let Some(best) = newest.iter().min_by_key(|candidate| candidate.bound).copied() {
            let (t, r) = best.region.center();
            self.try_lines([Line { features: best.features, t, r }]);
            let current = self.current;
            self.candidates.retain(|candidate| candidate.bound < current);
        }
    }

    /// Split the regions that could still win until none is left; returns the result.
    pub(crate) fn finish(mut self, floor: i64) -> StumpResult {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable_by_key(|candidate| (candidate.bound, candidate.order));
        for candidate in candidates.into_iter().take(self.most_tried) {
            if candidate.bound >= self.current || self.current <= floor || self.is_stopped() {
                break;
            }
            self.refine(candidate);
        }
        StumpResult { lower: self.current.min(self.undecided).max(floor), incumbent: self.incumbent, line: self.line }
    }
}

/// Find the best split, looking only at intervals that could hold it; their bounds are raised to those that were found.
///
/// A raised bound holds for these samples (after `less`, for those that the intervals speak of) and for every set that
/// contains them.
pub(crate) fn best_split(
    samples: WeightedSamples<'_>,
    dual_planes: &[DualPlane],
    task: StumpTask<'_>,
    lines: impl IntoIterator<Item = Line>,
    intervals: &mut Vec<SlopeInterval>,
    stop: &AtomicBool,
) -> StumpResult {
    let mut search = StumpSearch::new(samples, task.ids, task.need, task.cutoff, stop);
    search.most_tried = task.most_tried;
    search.try_lines(lines);
    if search.incumbent <= task.floor {
        return search.finish(task.floor);
    }
    let limits = Limits { dead: task.dead, less: task.less, most: task.most };
    let mut found = Vec::with_capacity(intervals.len() + 16);
    let mut seen = 0;
    for run in intervals.chunk_by(|a, b| a.dual_plane == b.dual_plane) {
        let dual_plane = &dual_planes[run[0].dual_plane as usize];
        search.begin_dual_plane();
        for &interval in run {
            search.scan_intervals(dual_plane, interval, limits, &mut found);
        }
        search.try_best_of_dual_plane();
        seen += run.len();
        if search.incumbent < task.hopeless && samples.switches.hopeless {
            // The bounds of the intervals have risen; the result is not worth the rest.
            found.extend_from_slice(&intervals[seen..]);
            *intervals = found;
            return StumpResult { lower: task.floor, incumbent: search.incumbent, line: search.line };
        }
    }
    *intervals = found;
    search.finish(task.floor)
}

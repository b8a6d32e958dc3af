//! Bounds of many lines at once: the regions of one interval, or of neighbouring intervals, in one pass over the
//! samples.
//!
//! A sample counts as left wherever its lower bin is at or below the region, as right wherever its higher bin is at or
//! above it; so a region's bound takes every line of the region into account.

use crate::loss::INFEASIBLE;
use crate::regions::dual_plane::DualPlane;
use crate::regions::slope_interval::SlopeInterval;
use crate::stumps::histograms::Limits;
use crate::stumps::search::{Candidate, StumpSearch};
use crate::stumps::sweep::Sweep;

impl StumpSearch<'_> {
    /// Bound the lines between two interval boundaries by their regions and return the least bound.
    ///
    /// `keeps`: remember the regions that could still win.
    pub(crate) fn scan(&mut self, dual_plane: &DualPlane, (from, to): (usize, usize), keeps: bool) -> i64 {
        let loss = self.samples.loss;
        let room = &mut self.histograms;
        let n_regions = room.regions(to - from);
        let n_entries = n_regions * loss.lanes();
        let need = (self.need > 1).then_some(self.need);
        room.count(dual_plane.bins(from), dual_plane.bins(to), need.map(|_| loss.k * n_regions));
        let sweep = Sweep {
            loss,
            total: &self.total,
            low: &mut room.low[..n_entries],
            high: &mut room.high[..n_entries],
            need,
            bounds: &mut room.bounds[..n_regions],
            running: &mut room.running[..n_regions],
        };
        room.arch.dispatch(sweep);
        let price = self.samples.price(dual_plane.features);
        let bounds = &room.bounds[..n_regions];
        let lowest = bounds.iter().fold(INFEASIBLE, |least, &bound| least.min(bound));
        if lowest + price >= self.current {
            return (lowest + price).min(INFEASIBLE);
        }
        let mut least = INFEASIBLE;
        for (bin, bound) in bounds.iter().enumerate() {
            let bound = (bound + price).min(INFEASIBLE);
            if bound >= least.max(self.current) {
                continue;
            }
            // A region without room between its edges holds no line of its own.
            let bins = (bin << room.merged, (bin + 1) << room.merged);
            let region = dual_plane.region((from, to), bins);
            if !region.has_room() {
                continue;
            }
            least = least.min(bound);
            if keeps && bound < self.current {
                let order = self.candidates.len() as u32;
                self.candidates.push(Candidate { bound, order, features: dual_plane.features, region });
            }
        }
        least
    }

    /// Bound neighbouring intervals of one dual plane, many at once where that is enough; all of them go to `found`.
    ///
    /// Taken together they are one wide interval: its regions lie between edges drawn straight from its first boundary
    /// to its last, every line of it is in one of them, and a sample's bins at the two ends say where it lies, as in
    /// one interval. Returns the bound for the samples at hand, infeasible for what is left out.
    pub(crate) fn scan_intervals(
        &mut self,
        dual_plane: &DualPlane,
        interval: SlopeInterval,
        limits: Limits,
        found: &mut Vec<SlopeInterval>,
    ) -> i64 {
        if limits.at_least(&interval) >= self.current || interval.bound >= limits.dead || self.is_stopped() {
            found.push(interval);
            return INFEASIBLE;
        }
        let (from, n) = (interval.first as usize, interval.n_intervals as usize);
        let mut bound = self.scan(dual_plane, (from, from + n), n == 1);
        let gain = limits.gain(interval.gain, bound);
        let begin = found.len();
        if bound < self.current && n > 1 {
            let length = n.div_ceil(4);
            let firsts = (0..n).step_by(length);
            let raised = interval.bound.max(bound - limits.less);
            bound = firsts.fold(INFEASIBLE, |least, first| {
                let (n_intervals, first) = (length.min(n - first) as u16, interval.first + first as u16);
                let part = SlopeInterval { first, n_intervals, bound: raised, gain, ..interval };
                least.min(self.scan_intervals(dual_plane, part, limits, found))
            });
            if bound < self.current.min(limits.dead) {
                return bound;
            }
        }
        // None of them matters now: they are one again.
        let alone = (interval.bound.max(bound - limits.less), gain);
        let parts = found.drain(begin..).map(|part| (part.bound, part.gain));
        let (least, gain) = parts.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or(alone);
        found.push(SlopeInterval { bound: least, gain, ..interval });
        bound
    }
}

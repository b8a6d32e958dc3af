//! Bounds of many lines at once: the regions of one strip, or of neighbouring strips, in one pass over the samples.
//!
//! A sample counts as left wherever its lower bin is at or below the region, as right wherever its higher bin is at or
//! above it; so a region's bound takes every line of the region into account.

use super::chart::Chart;
use super::loss::INFEASIBLE;
use super::strips::{Limits, Strip};
use super::stump::{Candidate, Search};
use super::sweep::Sweep;

impl Search<'_> {
    /// Bound the lines between two strip boundaries by their regions and return the least bound.
    ///
    /// `keeps`: remember the regions that could still win.
    pub fn scan(&mut self, chart: &Chart, (from, to): (usize, usize), keeps: bool) -> i64 {
        let loss = self.view.loss;
        let room = &mut self.histograms;
        let n_regions = room.bounds.len();
        let need = (self.need > 1).then_some(self.need);
        room.count(chart.bins(from), chart.bins(to), need.map(|_| loss.k * n_regions));
        let sweep = Sweep {
            loss,
            total: &self.total,
            low: &mut room.low,
            high: &mut room.high,
            need,
            bounds: &mut room.bounds,
            running: &mut room.running,
        };
        room.arch.dispatch(sweep);
        let price = self.view.price(chart.features);
        let lowest = room.bounds.iter().fold(INFEASIBLE, |least, &bound| least.min(bound));
        if lowest + price >= self.current {
            return (lowest + price).min(INFEASIBLE);
        }
        let mut least = INFEASIBLE;
        for (region, bound) in room.bounds.iter().enumerate() {
            let bound = (bound + price).min(INFEASIBLE);
            if bound >= least.max(self.current) {
                continue;
            }
            // A region without room between its edges holds no line of its own.
            let regions = (region << room.merged, (region + 1) << room.merged);
            let cell = chart.cell((from, to), regions);
            if !cell.has_room() {
                continue;
            }
            least = least.min(bound);
            if keeps && bound < self.current {
                let order = self.candidates.len() as u32;
                self.candidates.push(Candidate { bound, order, features: chart.features, cell });
            }
        }
        least
    }

    /// Bound neighbouring strips of one chart, many at once where that is enough; all of them go to `found`.
    ///
    /// Taken together they are one wide strip: its regions lie between edges drawn straight from its first boundary to its
    /// last, every line of it is in one of them, and a sample's bins at the two ends say where it lies, as in one strip.
    /// Returns the bound for the samples at hand, infeasible for what is left out.
    pub(super) fn scan_strips(&mut self, chart: &Chart, strip: Strip, limits: Limits, found: &mut Vec<Strip>) -> i64 {
        if strip.bound >= self.current.min(limits.dead) || self.is_stopped() {
            found.push(strip);
            return INFEASIBLE;
        }
        let (from, n) = (strip.first as usize, strip.n_strips as usize);
        let mut bound = self.scan(chart, (from, from + n), n == 1);
        let begin = found.len();
        if bound < self.current && n > 1 {
            let length = n.div_ceil(4);
            let firsts = (0..n).step_by(length);
            let raised = strip.bound.max(bound - limits.less);
            bound = firsts.fold(INFEASIBLE, |least, first| {
                let (n_strips, first) = (length.min(n - first) as u16, strip.first + first as u16);
                let part = Strip { first, n_strips, bound: raised, ..strip };
                least.min(self.scan_strips(chart, part, limits, found))
            });
            if bound < self.current.min(limits.dead) {
                return bound;
            }
        }
        // None of them matters now: they are one again.
        let parts = found.drain(begin..).map(|part| part.bound).min();
        let known = parts.unwrap_or(strip.bound.max(bound - limits.less));
        found.push(Strip { bound: known, ..strip });
        bound
    }
}

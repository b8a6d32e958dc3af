//! Bounds of many lines at once: the regions of one strip, or of neighbouring strips, in one pass over the samples.
//!
//! A sample counts as left wherever its lower bin is at or below the region, as right wherever its higher bin is at or
//! above it; so a region's bound takes every line of the region into account.

use super::chart::{Chart, REGIONS};
use super::loss::INFEASIBLE;
use super::stump::{Candidate, Search, Strip};

/// Neighbouring strips that are bounded together at first.
pub(super) const GROUP: usize = 16;

/// Whether one strip follows the other.
pub(super) fn are_neighbours(a: &Strip, b: &Strip) -> bool {
    a.chart == b.chart && a.strip + 1 == b.strip
}

impl Search<'_> {
    /// Bound the lines between two strip boundaries by their regions and return the least bound.
    ///
    /// `keeps`: remember the regions that could still win.
    pub fn scan(&mut self, chart: &Chart, (from, to): (usize, usize), keeps: bool) -> i64 {
        let lanes = self.view.loss.lanes();
        let lane_bits = lanes.next_power_of_two().trailing_zeros();
        // Few samples need few regions: neighbours are taken together.
        let merged = (REGIONS / (self.ids.len() / 4).clamp(8, REGIONS)).ilog2();
        self.count_bins(chart.bins(from), chart.bins(to), merged, lane_bits);
        let price = self.view.price(chart.features);
        let mut may_left = std::mem::take(&mut self.may_left);
        let mut may_right = std::mem::take(&mut self.may_right);
        may_left.fill(0);
        may_right.copy_from_slice(&self.total);
        let mut least = INFEASIBLE;
        for region in 0..REGIONS >> merged {
            let slot = region << lane_bits;
            for (sum, count) in may_left.iter_mut().zip(&self.low[slot..]) {
                *sum += count;
            }
            let loss = self.view.loss;
            let bound = loss.bound(&self.total, &may_left, &may_right, self.need) + price;
            if bound < least.max(self.current) {
                // A region without room between its edges holds no line of its own.
                let regions = (region << merged, (region + 1) << merged);
                let cell = chart.cell((from, to), regions);
                if cell.has_room() {
                    least = least.min(bound);
                    if keeps && bound < self.current {
                        let features = chart.features;
                        let order = self.candidates.len() as u32;
                        self.candidates.push(Candidate { bound, order, features, cell });
                    }
                }
            }
            for (sum, count) in may_right.iter_mut().zip(&self.high[slot..]) {
                *sum -= count;
            }
        }
        (self.may_left, self.may_right) = (may_left, may_right);
        least
    }

    fn count_bins(&mut self, first: &[u8], last: &[u8], merged: u32, lane_bits: u32) {
        let used = (REGIONS >> merged) << lane_bits;
        self.low[..used].fill(0);
        self.high[..used].fill(0);
        let (labels, weights) = (self.view.labels, self.view.weights);
        let k = self.view.loss.k;
        let counts_samples = self.need > 1;
        for &i in self.ids {
            let i = i as usize;
            let (a, b) = (first[i] >> merged, last[i] >> merged);
            let low = (a.min(b) as usize) << lane_bits;
            let high = (a.max(b) as usize) << lane_bits;
            let class = labels[i] as usize;
            self.low[low + class] += weights[i];
            self.high[high + class] += weights[i];
            if counts_samples {
                self.low[low + k] += 1;
                self.high[high + k] += 1;
            }
        }
        if !counts_samples {
            // Without counts no region may look too empty for a leaf.
            self.low[k] = self.total[k];
        }
    }

    /// Bound neighbouring strips of one chart, many at once where that is enough.
    ///
    /// Taken together they are one wide strip: its regions lie between edges drawn straight from its first boundary to its
    /// last, every line of it is in one of them, and a sample's bins at the two ends say where it lies, as in one strip.
    pub(super) fn scan_group(&mut self, chart: &Chart, strips: &mut [Strip], dead: i64) {
        let limit = self.current.min(dead);
        if strips.iter().all(|strip| strip.bound >= limit) || self.is_stopped() {
            return;
        }
        let from = strips[0].strip as usize;
        let bound = self.scan(chart, (from, from + strips.len()), strips.len() == 1);
        for strip in strips.iter_mut() {
            strip.bound = strip.bound.max(bound);
        }
        if bound < self.current && strips.len() > 1 {
            for part in strips.chunks_mut(strips.len().div_ceil(4)) {
                self.scan_group(chart, part, dead);
            }
        }
    }
}

//! Bounds of many lines at once: the regions of one strip, or of neighbouring strips, in one pass over the samples.
//!
//! A sample counts as left wherever its lower bin is at or below the region, as right wherever its higher bin is at or
//! above it; so a region's bound takes every line of the region into account.

use super::cell::Cell;
use super::chart::{Chart, REGIONS};
use super::loss::INFEASIBLE;
use super::stump::{Candidate, Search, Strip};

/// Neighbouring strips that are bounded together at first.
pub(super) const GROUP: usize = 16;
/// Fewer samples than this say little about the rest.
const LEAST_SAMPLE: usize = 48;

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
                        self.candidates.push(Candidate {
                            bound,
                            order,
                            features,
                            cell,
                        });
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
    pub(super) fn scan_group(&mut self, chart: &Chart, strips: &mut [Strip], dead: i64) {
        let limit = self.current.min(dead);
        if strips.iter().all(|strip| strip.bound >= limit) || self.is_stopped() {
            return;
        }
        let from = strips[0].strip as usize;
        let bound = self.scan(
            chart,
            (from, from + strips.len()),
            self.keeps && strips.len() == 1,
        );
        for strip in strips.iter_mut() {
            strip.bound = strip.bound.max(bound);
        }
        if bound < self.current && strips.len() > 1 {
            for part in strips.chunks_mut(strips.len().div_ceil(4)) {
                self.scan_group(chart, part, dead);
            }
        }
    }

    /// Bound strips by every so-maniest sample first: dropping samples lowers no optimum, and where far more goes wrong
    /// than is allowed, a sample of the samples shows it.
    pub(super) fn scan_sample(&mut self, charts: &[Chart], strips: &mut [Strip], dead: i64) {
        const EXCESS: i64 = 3;
        let stride = self.attained / (EXCESS * self.current.max(1));
        if stride < 2 || self.current <= 0 {
            return;
        }
        let stride = (stride as usize).min(self.ids.len() / LEAST_SAMPLE);
        if stride < 2 {
            return;
        }
        let ids: Vec<u32> = self.ids.iter().copied().step_by(stride).collect();
        let mut sample = Search::new(self.view, &ids, 1, self.current, self.stop);
        sample.keeps = false;
        sample.current = self.current;
        sample.scan_charts(charts, strips, dead);
    }

    /// Bound all strips, chart by chart.
    fn scan_charts(&mut self, charts: &[Chart], strips: &mut [Strip], dead: i64) {
        for run in strips.chunk_by_mut(are_neighbours) {
            let chart = &charts[run[0].chart as usize];
            for group in run.chunks_mut(GROUP) {
                self.scan_group(chart, group, dead);
            }
        }
    }

    /// Bound neighbouring strips as one cell each, for few samples.
    pub(super) fn scan_runs(&mut self, charts: &[Chart], strips: &[Strip], dead: i64) {
        let alive = |strip: &&Strip| strip.bound < dead.min(self.current);
        let alive: Vec<Strip> = strips.iter().filter(alive).copied().collect();
        let runs = alive.chunk_by(|a, b| a.chart == b.chart && a.strip + 1 == b.strip);
        for run in runs {
            let chart = &charts[run[0].chart as usize];
            let (first, last) = (run[0].strip as usize, run[run.len() - 1].strip as usize);
            let cell = self.cell_around(chart.features, chart.t[first], chart.t[last + 1]);
            self.candidates.push(Candidate {
                bound: run.iter().map(|strip| strip.bound).min().unwrap_or(0),
                order: self.candidates.len() as u32,
                features: chart.features,
                cell,
            });
        }
    }

    /// The cell of all lines that part the samples at all, between two values of t.
    fn cell_around(&self, (f, g): (usize, usize), t0: f64, t1: f64) -> Cell {
        let (x, y) = (self.view.plane.column(f), self.view.plane.column(g));
        let range = |t: f64| {
            let reach = self.ids.iter().map(|&i| x[i as usize] + t * y[i as usize]);
            reach.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| {
                (l.min(r), h.max(r))
            })
        };
        const ROOM: f64 = 1e-6;
        let ((l0, u0), (l1, u1)) = (range(t0), range(t1));
        Cell {
            t0,
            t1,
            l0: l0 - ROOM,
            l1: l1 - ROOM,
            u0: u0 + ROOM,
            u1: u1 + ROOM,
        }
    }
}

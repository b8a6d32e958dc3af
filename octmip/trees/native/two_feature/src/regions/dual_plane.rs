//! Dual planes: all lines over one ordered pair of features, cut into intervals of t and regions of r.
//!
//! The dual plane of (f, g) holds the lines `x_f + t x_g = r` with `|t| <= 1`; the dual planes of (f, g) and (g, f)
//! together hold all lines over the two features. The dual plane of (f, zero) holds the axis-aligned splits of f: one
//! interval, t = 0.
//!
//! Slope intervals end at quantiles of the places where sample lines cross, so each interval sees about as many changes
//! of order. Regions lie between edges that move with the samples: at every interval boundary, edge b is a quantile of
//! the samples there, and runs straight between boundaries. A region of an interval is then a `Region`, and a sample
//! whose bins at both boundaries are below the region's is below the whole region.

use crate::geometry::line::EPS;
use crate::geometry::plane::Plane;
use crate::regions::region::Region;

/// Regions of an interval.
pub(crate) const REGIONS: usize = 64;
const FINE: usize = 512;
/// Edges keep this clear of all samples, in units of fine bins.
const CLEAR: f64 = 1.0 / (1u64 << 20) as f64;
const SAMPLED_CROSSINGS: usize = 384;
const EVEN_CROSSINGS: usize = 64;

/// One ordered pair of features, its intervals, and the region of every sample at every interval boundary.
#[derive(Debug, Clone)]
pub struct DualPlane {
    /// The two features; the second is the plane's column of zeros for an axis-aligned split.
    pub(crate) features: (usize, usize),
    /// Interval boundaries, ascending.
    pub(crate) t: Vec<f64>,
    edges: Vec<f64>,
    bins: Vec<u8>,
    n: usize,
}

impl DualPlane {
    /// The dual plane of an ordered pair with so many intervals (1 where the second feature is the column of zeros).
    pub fn new(plane: &Plane, features: (usize, usize), n_intervals: usize) -> Self {
        let t = if features.1 == plane.p { vec![0.0, 0.0] } else { interval_boundaries(plane, features, n_intervals) };
        Self::with_boundaries(plane, features, t)
    }

    /// The dual plane with these interval boundaries.
    pub(crate) fn with_boundaries(plane: &Plane, features: (usize, usize), t: Vec<f64>) -> Self {
        let n = plane.n;
        let mut dual_plane =
            Self { features, edges: vec![0.0; t.len() * (REGIONS + 1)], bins: vec![0; t.len() * n], t, n };
        let (x, y) = (plane.column(features.0), plane.column(features.1));
        let mut fine = vec![0u16; n];
        for k in 0..dual_plane.t.len() {
            let bins = &mut dual_plane.bins[k * n..(k + 1) * n];
            let edges = &mut dual_plane.edges[k * (REGIONS + 1)..(k + 1) * (REGIONS + 1)];
            place_edges(x, y, dual_plane.t[k], &mut fine, bins, edges);
        }
        dual_plane
    }

    /// Number of intervals.
    pub(crate) fn n_intervals(&self) -> usize {
        self.t.len() - 1
    }

    /// Region of every sample at an interval boundary.
    pub(crate) fn bins(&self, boundary: usize) -> &[u8] {
        &self.bins[boundary * self.n..(boundary + 1) * self.n]
    }

    /// The regions `first..end` between two interval boundaries, as one region.
    pub(crate) fn region(&self, (from, to): (usize, usize), (first, end): (usize, usize)) -> Region {
        let at = |k: usize, b: usize| self.edges[k * (REGIONS + 1) + b];
        Region {
            t0: self.t[from],
            t1: self.t[to],
            l0: at(from, first),
            l1: at(to, first),
            u0: at(from, end),
            u1: at(to, end),
        }
    }

    /// All lines of the dual plane that part the samples at all, as one region.
    pub(crate) fn whole(&self) -> Region {
        // Edges are straight within an interval only, so the whole dual plane takes fixed ones: coordinates are in [-1,
        // 1].
        let is_axis = self.t[0] == self.t[self.t.len() - 1];
        let (low, high) = if is_axis { (-1.25, 1.25) } else { (-2.25, 2.25) };
        Region { t0: self.t[0], t1: self.t[self.t.len() - 1], l0: low, l1: low, u0: high, u1: high }
    }

    /// The interval boundary nearest the middle (counted in intervals) of an interval of t, if one lies inside.
    pub(crate) fn middle_boundary(&self, t0: f64, t1: f64) -> Option<f64> {
        let first = self.t.partition_point(|&t| t <= t0);
        let end = self.t.partition_point(|&t| t < t1);
        (first < end).then(|| self.t[(first + end) / 2])
    }
}

/// Boundaries from -1 to 1 with about as many crossings of sample lines between neighbours.
fn interval_boundaries(plane: &Plane, (f, g): (usize, usize), n_intervals: usize) -> Vec<f64> {
    let (x, y) = (plane.column(f), plane.column(g));
    let mut state = (f as u64) << 32 | g as u64 | 1 << 63;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % plane.n
    };
    let mut crossings: Vec<f64> =
        (0..EVEN_CROSSINGS).map(|k| (k as f64 + 0.5) / EVEN_CROSSINGS as f64 * 2.0 - 1.0).collect();
    for _ in 0..SAMPLED_CROSSINGS {
        let (i, j) = (draw(), draw());
        let t = -(x[i] - x[j]) / (y[i] - y[j]);
        if t.abs() < 1.0 {
            crossings.push(t);
        }
    }
    crossings.sort_unstable_by(f64::total_cmp);
    let mut t = vec![-1.0];
    for k in 1..n_intervals {
        let next = crossings[k * crossings.len() / n_intervals];
        // A little apart, so that no interval is narrower than the rounding of its ends allows.
        if next > t[t.len() - 1] + 1e-6 && next < 1.0 - 1e-6 {
            t.push(next);
        }
    }
    t.push(1.0);
    t
}

/// Place the edges at one boundary, and each sample between two of them.
///
/// Every edge keeps more than `EPS` clear of all samples, so the bins are right whatever the rounding.
fn place_edges(x: &[f64], y: &[f64], t: f64, fine: &mut [u16], bins: &mut [u8], edges: &mut [f64]) {
    let reach = |i: usize| x[i] + t * y[i];
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..x.len() {
        let r = reach(i);
        low = if r < low { r } else { low };
        high = if r > high { r } else { high };
    }
    // Off the grid that the samples may lie on, below and above all of them.
    let width = ((high - low) / (FINE as f64 - 3.618)).max(1.0 / (1u64 << 36) as f64);
    let start = low - 1.618 * width;
    let inverse = 1.0 / width;
    let clear = CLEAR.max(2.0 * EPS * inverse);
    let mut is_crowded = [false; FINE + 1];
    let mut counts = [0u32; FINE];
    for (i, slot) in fine.iter_mut().enumerate() {
        let z = (reach(i) - start) * inverse;
        let bin = z as usize;
        let part = z - bin as f64;
        is_crowded[bin] |= part < clear;
        is_crowded[bin + 1] |= part > 1.0 - clear;
        counts[bin] += 1;
        *slot = bin as u16;
    }
    let mut region_of = [0u8; FINE];
    edges[0] = start;
    let (mut region, mut below) = (0, 0);
    for bin in 0..FINE {
        // In the middle of what the bin holds, so that a crowded bin does not drag its region along.
        let target = ((below + counts[bin] / 2) as usize * REGIONS / x.len()).min(REGIONS - 1);
        if target > region && !is_crowded[bin] {
            edges[region + 1..=target].fill(start + bin as f64 * width);
            region = target;
        }
        region_of[bin] = region as u8;
        below += counts[bin];
    }
    edges[region + 1..].fill(start + FINE as f64 * width);
    for (bin, &slot) in bins.iter_mut().zip(fine.iter()) {
        *bin = region_of[slot as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_lies_clear_between_the_edges_of_its_bin() {
        let values: Vec<f64> =
            (0..40).map(|i| f64::from(i * i % 17)).chain((0..40).map(|i| f64::from(i % 5))).collect();
        let plane = Plane::new(40, 2, &values, &[0; 80]);
        let dual_plane = DualPlane::new(&plane, (0, 1), 8);
        for interval in 0..dual_plane.n_intervals() {
            let bins = dual_plane.bins(interval);
            for (i, &bin) in bins.iter().enumerate() {
                let r = plane.column(0)[i] + dual_plane.t[interval] * plane.column(1)[i];
                let region = dual_plane.region((interval, interval + 1), (bin as usize, bin as usize + 1));
                assert!(region.l0 + EPS < r && r < region.u0 - EPS, "{region:?} {r}");
            }
        }
    }
}

//! Regions of a dual plane: sets of lines that send some samples left, some right, and leave the others open.
//!
//! The line `x_f + t x_g = r` is the point (t, r); a sample is the straight line `r = x_f + t x_g` in that plane and
//! goes left where it runs below the point. A region is the trapezoid between two straight edges over `t0 <= t <= t1`.
//! A sample that is below the lower edge at both ends is below it everywhere, so two comparisons settle it for the
//! whole region.

use crate::geometry::line::EPS;
use crate::geometry::plane::Plane;

/// A region below this size is not split further.
const TINY: f64 = 1.0 / (1u64 << 34) as f64;

/// A trapezoid: lower edge from (t0, l0) to (t1, l1), upper edge from (t0, u0) to (t1, u1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Region {
    pub(crate) t0: f64,
    pub(crate) t1: f64,
    pub(crate) l0: f64,
    pub(crate) l1: f64,
    pub(crate) u0: f64,
    pub(crate) u1: f64,
}

/// The side of a region on which a sample lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Open,
    Right,
}

impl Region {
    /// The side of the sample at (x, y).
    #[inline]
    pub(crate) fn side(&self, x: f64, y: f64) -> Side {
        let (a, b) = (x + self.t0 * y, x + self.t1 * y);
        if a <= self.l0 - EPS && b <= self.l1 - EPS {
            Side::Left
        } else if a >= self.u0 + EPS && b >= self.u1 + EPS {
            Side::Right
        } else {
            Side::Open
        }
    }

    /// The line in the middle of the region, as (t, r).
    pub(crate) fn center(&self) -> (f64, f64) {
        ((self.t0 + self.t1) / 2.0, (self.l0 + self.l1 + self.u0 + self.u1) / 4.0)
    }

    /// The two regions to both sides of `t`.
    pub(crate) fn split_t(&self, t: f64) -> [Self; 2] {
        let part = (t - self.t0) / (self.t1 - self.t0);
        let low = self.l0 + part * (self.l1 - self.l0);
        let high = self.u0 + part * (self.u1 - self.u0);
        [Self { t1: t, l1: low, u1: high, ..*self }, Self { t0: t, l0: low, u0: high, ..*self }]
    }

    /// The two regions below and above the edge from (t0, m0) to (t1, m1).
    pub(crate) fn split_r(&self, m0: f64, m1: f64) -> [Self; 2] {
        [Self { u0: m0, u1: m1, ..*self }, Self { l0: m0, l1: m1, ..*self }]
    }

    /// The edge through the middle of the open samples, kept clear of the region's own edges.
    pub(crate) fn middle_edge(&self, x: &[f64], y: &[f64], open: &[u32]) -> (f64, f64) {
        let (mut sum0, mut sum1) = (0.0, 0.0);
        for &i in open {
            let (a, b) = (x[i as usize], y[i as usize]);
            sum0 += (a + self.t0 * b).clamp(self.l0, self.u0);
            sum1 += (a + self.t1 * b).clamp(self.l1, self.u1);
        }
        let m = open.len() as f64;
        let clear = |mean: f64, low: f64, high: f64| {
            let margin = (high - low) / 8.0;
            mean.clamp(low + margin, high - margin)
        };
        (clear(sum0 / m, self.l0, self.u0), clear(sum1 / m, self.l1, self.u1))
    }

    /// Whether there is room between the edges.
    pub(crate) fn has_room(&self) -> bool {
        self.u0 > self.l0 || self.u1 > self.l1
    }

    /// Whether splitting in t is still worth while.
    pub(crate) fn is_wide(&self) -> bool {
        self.t1 - self.t0 > TINY
    }

    /// Whether splitting in r is still worth while.
    pub(crate) fn is_high(&self) -> bool {
        (self.u0 - self.l0).max(self.u1 - self.l1) > TINY
    }

    /// The samples of `ids` that the region leaves open; `settled` is called with the others.
    pub(crate) fn sort(&self, x: &[f64], y: &[f64], ids: &[u32], mut settled: impl FnMut(u32, bool)) -> Vec<u32> {
        let mut open = Vec::new();
        for &i in ids {
            match self.side(x[i as usize], y[i as usize]) {
                Side::Left => settled(i, true),
                Side::Right => settled(i, false),
                Side::Open => open.push(i),
            }
        }
        open
    }

    /// Number of `ids` that both regions leave open, added up.
    pub(crate) fn count_open(regions: &[Self; 2], x: &[f64], y: &[f64], ids: &[u32]) -> usize {
        ids.iter()
            .map(|&i| {
                let (a, b) = (x[i as usize], y[i as usize]);
                regions.iter().filter(|c| c.side(a, b) == Side::Open).count()
            })
            .sum()
    }

    /// The line of the region that runs clearest of the samples when `left` go left and `right` go right.
    ///
    /// Returns the least distance in r (negative: no line of the region does it), t and r. The distance is a concave,
    /// piecewise linear function of t, so its maximum lies at an end or where two of the straight lines in it cross.
    pub(crate) fn clearest(
        &self,
        plane: &Plane,
        features: (usize, usize),
        left: &[u32],
        right: &[u32],
    ) -> (f64, f64, f64) {
        let (x, y) = (plane.column(features.0), plane.column(features.1));
        let room = |t: f64| {
            let part = if self.t1 > self.t0 { (t - self.t0) / (self.t1 - self.t0) } else { 0.0 };
            let reach = |i: &u32| x[*i as usize] + t * y[*i as usize];
            let low = left.iter().map(reach).fold(self.l0 + part * (self.l1 - self.l0), f64::max);
            let high = right.iter().map(reach).fold(self.u0 + part * (self.u1 - self.u0), f64::min);
            (high - low, (high + low) / 2.0)
        };
        let best = self
            .turning_points(plane, features, left, right)
            .max_by(|&s, &t| room(s).0.total_cmp(&room(t).0))
            .unwrap_or(self.t0);
        let (distance, r) = room(best);
        (distance, best, r)
    }

    /// The ends of the region, and where its edges and the lines of some samples cross in it.
    fn turning_points(
        &self,
        plane: &Plane,
        (f, g): (usize, usize),
        left: &[u32],
        right: &[u32],
    ) -> impl Iterator<Item = f64> {
        let (x, y) = (plane.column(f), plane.column(g));
        let width = self.t1 - self.t0;
        // Every line as its heights at both ends.
        let mut lines = vec![(self.l0, self.l1), (self.u0, self.u1)];
        lines.extend(left.iter().chain(right).map(|&i| {
            let (a, b) = (x[i as usize], y[i as usize]);
            (a + self.t0 * b, a + self.t1 * b)
        }));
        let mut points = vec![self.t0, self.t1];
        for (k, a) in lines.iter().enumerate().take(if width > 0.0 { lines.len() } else { 0 }) {
            for b in &lines[..k] {
                let (at_0, at_1) = (a.0 - b.0, a.1 - b.1);
                if at_0 * at_1 < 0.0 {
                    points.push(self.t0 + width * (at_0 / (at_0 - at_1)));
                }
            }
        }
        points.into_iter()
    }
}

/// Split a region in t (at `at`, or in the middle) or in r, whichever leaves fewer samples open.
pub(crate) fn split(
    plane: &Plane,
    (f, g): (usize, usize),
    region: &Region,
    open: &[u32],
    at: Option<f64>,
) -> [Region; 2] {
    let (x, y) = (plane.column(f), plane.column(g));
    let (m0, m1) = region.middle_edge(x, y, open);
    let by_r = region.split_r(m0, m1);
    if !region.is_wide() {
        return by_r;
    }
    let by_t = region.split_t(at.unwrap_or((region.t0 + region.t1) / 2.0));
    if !region.is_high() || Region::count_open(&by_t, x, y, open) <= Region::count_open(&by_r, x, y, open) {
        by_t
    } else {
        by_r
    }
}

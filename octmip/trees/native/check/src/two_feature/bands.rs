//! Bands: the lines of a dual plane between two parallel straight edges.

use super::checker::{Checker, DualPlane, SlopeInterval, Tally};
use super::region::EPS;

/// Bands narrower than this are not split.
pub(super) const TINY: f64 = 1.0 / (1u64 << 39) as f64;

/// The lines r = c + slope (t - middle) for t0 <= t <= t1 and low <= c <= high, over two features.
pub(super) struct Band {
    pub(super) dual_plane: DualPlane,
    pub(super) t: [f64; 2],
    pub(super) slope: f64,
    pub(super) c: [f64; 2],
}

/// Samples that a band was cut out of: those of `open` with a last bin before `begin` go left of it.
pub(super) struct Cut<'a> {
    pub(super) open: &'a [u32],
    pub(super) places: &'a [[usize; 2]],
    pub(super) begin: usize,
    pub(super) dual_plane: DualPlane,
    pub(super) around: Option<&'a Cut<'a>>,
}

impl Cut<'_> {
    /// The samples left of the band.
    pub(super) fn left(&self) -> Vec<u32> {
        let mut left = self.around.map_or_else(Vec::new, Cut::left);
        let own = self.open.iter().zip(self.places).filter(|(_, place)| place[1] < self.begin);
        left.extend(own.map(|(&i, _)| i));
        left
    }
}

/// Samples, and the fewest that each of two leaves is to hold of them.
pub(super) struct Samples<'a> {
    pub(super) ids: &'a [u32],
    pub(super) total: Tally,
    pub(super) need: i64,
}

impl Checker<'_> {
    /// The band of an interval that holds every line with samples on both sides.
    ///
    /// One with an empty side costs what a leaf costs, at least.
    pub(super) fn around(&self, samples: &Samples<'_>, &(dual_plane, t0, t1): &SlopeInterval) -> Band {
        let mut band = Band { dual_plane, t: [t0, t1], slope: 0.0, c: [-8.0, 8.0] };
        band.slope = self.slope(dual_plane, samples.ids);
        let (mut low, mut high) = (8.0f64, -8.0f64);
        for &i in samples.ids {
            let reach = self.reach(&band, i);
            (low, high) = (low.min(reach[0]), high.max(reach[1]));
        }
        band.c = [low, high];
        band
    }

    /// The mean slope of the lines of some samples.
    pub(super) fn slope(&self, (_, g): DualPlane, ids: &[u32]) -> f64 {
        let y = self.points.coordinates(g);
        let sum: f64 = ids.iter().map(|&i| y[i as usize]).sum();
        sum / ids.len().max(1) as f64
    }

    /// The range of c in which the line of a sample runs, rounding included.
    pub(super) fn reach(&self, band: &Band, i: u32) -> [f64; 2] {
        let [x, y] = [band.dual_plane.0, band.dual_plane.1].map(|f| self.points.coordinates(f)[i as usize]);
        let middle = (band.t[0] + band.t[1]) / 2.0;
        let [a, b] = band.t.map(|t| x + t * y - band.slope * (t - middle));
        [a.min(b) - EPS, a.max(b) + EPS]
    }

    /// Bands that together hold the lines between two values of c: halves in t, or one as it is where that is narrow.
    pub(super) fn halves(&self, band: &Band, part: [f64; 2], inside: &[u32]) -> Vec<Band> {
        let [t0, t1] = band.t;
        if t1 - t0 <= TINY {
            return vec![Band { c: part, ..*band }];
        }
        let (middle, slope) = ((t0 + t1) / 2.0, self.slope(band.dual_plane, inside));
        let half = |t: [f64; 2]| {
            let own = (t[0] + t[1]) / 2.0;
            let moved = t.map(|t| band.slope * (t - middle) - slope * (t - own));
            let c = [part[0] + moved[0].min(moved[1]) - EPS, part[1] + moved[0].max(moved[1]) + EPS];
            Band { dual_plane: band.dual_plane, t, slope, c }
        };
        vec![half([t0, middle]), half([middle, t1])]
    }
}

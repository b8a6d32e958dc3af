//! Lines of a plane, and their distance from samples.

use crate::geometry::plane::Plane;

/// Room for rounding: coordinates and edges are below 8 and wrong by less than 2^-45 after all the splits of a search.
pub(crate) const EPS: f64 = 1.0 / (1u64 << 42) as f64;

/// The line `x_f + t x_g = r` in scaled coordinates; samples at or below it go left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// f and g.
    pub features: (usize, usize),
    /// What column g counts beside column f.
    pub t: f64,
    pub(crate) r: f64,
}

impl Line {
    /// Whether a sample goes left.
    #[inline]
    pub fn sends_left(&self, plane: &Plane, i: u32) -> bool {
        let (f, g) = self.features;
        plane.column(f)[i as usize] + self.t * plane.column(g)[i as usize] <= self.r
    }

    /// Whether the line keeps clear of some samples by more than rounding can matter.
    pub(crate) fn is_clear_of(&self, plane: &Plane, ids: &[u32]) -> bool {
        let (x, y) = (plane.column(self.features.0), plane.column(self.features.1));
        let distance = |i: u32| (x[i as usize] + self.t * y[i as usize] - self.r).abs();
        ids.iter().all(|&i| distance(i) > EPS)
    }
}

//! Vector passes over the buckets of eight features at once: the least error at bucket edges, and a bound inside.
//!
//! A cell is a bucket of each of eight features; its rows are numbers side by side, one for each feature. Every width
//! of vectors does the same operations on the same numbers, so results do not depend on the machine.

use pulp::{Simd, WithSimd, bytemuck};

use crate::slopes::Slopes;

/// Features of a group.
pub(crate) const LANES: usize = 8;
/// Rows of a cell of squared errors: weight and weighted target of all its samples and of those left of the cut; least
/// and greatest target, and one over their difference, 0 where no cut lies inside.
pub(crate) const SQUARED_ROWS: usize = 7;
/// Most distinct targets of sloped errors.
pub(crate) const MOST_VALUES: usize = 8;

/// Lines of bounds of a bucket.
pub(crate) const CAPS: usize = 4;

/// One number for each feature of a group.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Line(pub(crate) [f64; LANES]);

impl Line {
    /// Zeros.
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    fn part<S: Simd>(&self, part: usize) -> S::f64s {
        S::as_simd_f64s(&self.0).0[part]
    }

    #[inline(always)]
    fn set<S: Simd>(&mut self, part: usize, values: S::f64s) {
        S::as_mut_simd_f64s(&mut self.0).0[part] = values;
    }
}

/// What a pass has found, by side of the cut and feature.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reached {
    /// Least error of a cut at a bucket's edge, or of no cut.
    pub(crate) edge: [[f64; LANES]; 2],
    /// No cut errs by less.
    pub(crate) lower: [[f64; LANES]; 2],
}

impl Reached {
    /// Before any pass.
    pub(crate) const NOTHING: Self = Self { edge: [[0.0; LANES]; 2], lower: [[0.0; LANES]; 2] };

    #[inline(always)]
    fn store<S: Simd>(&mut self, part: usize, side: usize, edge: S::f64s, lower: S::f64s) {
        for (to, from) in [(&mut self.edge[side], edge), (&mut self.lower[side], lower)] {
            let lanes: &[f64] = bytemuck::cast_slice(std::slice::from_ref(&from));
            to[part * S::F64_LANES..][..S::F64_LANES].copy_from_slice(lanes);
        }
    }
}

/// A pass of squared errors.
pub(crate) struct Squared<'a> {
    /// Cells of the group.
    pub(crate) lines: &'a [Line],
    /// Most that cuts inside each bucket explain, out: above and below of a fraction for each side.
    pub(crate) caps: &'a mut [Line],
    /// Weight, weighted target and weighted square of both sides.
    pub(crate) totals: [(f64, f64, f64); 2],
    /// Whether a bucket may have cuts inside.
    pub(crate) has_inside: bool,
    /// Which sides are asked for; nothing is reached on the others.
    pub(crate) needs: [bool; 2],
}

impl WithSimd for Squared<'_> {
    type Output = Reached;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Reached {
        if self.has_inside { self.sweep::<S, true>(simd) } else { self.sweep::<S, false>(simd) }
    }
}

/// What a cut explains, as a fraction: divisions would take most of the time.
#[derive(Clone, Copy)]
struct Explained<S: Simd> {
    above: S::f64s,
    below: S::f64s,
}

impl<S: Simd> Explained<S> {
    /// Of a cut with this weight and weighted target on its left.
    #[inline(always)]
    fn of(simd: S, weight: S::f64s, target: S::f64s, total: (S::f64s, S::f64s)) -> Self {
        let (w, s) = (simd.sub_f64s(total.0, weight), simd.sub_f64s(total.1, target));
        let left = simd.mul_f64s(simd.mul_f64s(target, target), w);
        let right = simd.mul_f64s(simd.mul_f64s(s, s), weight);
        Self { above: simd.add_f64s(left, right), below: simd.mul_f64s(weight, w) }
    }

    /// The larger of two; one with an empty side does not count.
    #[inline(always)]
    fn most(self, simd: S, other: Self) -> Self {
        let (own, new) = (simd.mul_f64s(self.above, other.below), simd.mul_f64s(other.above, self.below));
        let is_more =
            simd.and_m64s(simd.greater_than_f64s(new, own), simd.greater_than_f64s(other.below, simd.splat_f64s(0.0)));
        Self {
            above: simd.select_f64s(is_more, other.above, self.above),
            below: simd.select_f64s(is_more, other.below, self.below),
        }
    }

    /// The error that is left of so many squares.
    #[inline(always)]
    fn error(self, simd: S, square: f64) -> S::f64s {
        let rest = simd.sub_f64s(simd.splat_f64s(square), simd.div_f64s(self.above, self.below));
        simd.max_f64s(rest, simd.splat_f64s(0.0))
    }
}

impl Squared<'_> {
    /// One side after the other: both at once need more numbers than there are registers.
    #[inline(always)]
    fn sweep<S: Simd, const INSIDE: bool>(&mut self, simd: S) -> Reached {
        let (needs, mut reached) = (self.needs, Reached::NOTHING);
        for part in 0..LANES / S::F64_LANES {
            for m in [0, 1].into_iter().filter(|&m| needs[m]) {
                self.side::<S, INSIDE>(simd, part, m, &mut reached);
            }
        }
        reached
    }

    #[inline(always)]
    fn side<S: Simd, const INSIDE: bool>(&mut self, simd: S, part: usize, m: usize, reached: &mut Reached) {
        let (w, s, square) = self.totals[m];
        let (total, zero) = ((simd.splat_f64s(w), simd.splat_f64s(s)), simd.splat_f64s(0.0));
        let below = simd.splat_f64s(if w > 0.0 { w } else { 1.0 });
        let none = Explained::<S> { above: simd.splat_f64s(s * s), below };
        let (mut best, mut most, mut run) = (none, none, (zero, zero));
        let cells = self.lines.as_chunks::<SQUARED_ROWS>().0.iter().zip(self.caps.as_chunks_mut::<CAPS>().0);
        for (cell, caps) in cells {
            let row = |row: usize| cell[row].part::<S>(part);
            let left = (row(2), row(3));
            let own = if m == 0 { left } else { (simd.sub_f64s(row(0), left.0), simd.sub_f64s(row(1), left.1)) };
            if INSIDE {
                let (low, high, slope) = (row(4), row(5), row(6));
                // As much as can be of the greatest target first, or of the least first.
                let beyond = simd.mul_f64s(simd.sub_f64s(own.1, simd.mul_f64s(low, own.0)), slope);
                let greatest = simd.min_f64s(simd.max_f64s(beyond, zero), own.0);
                let rest = simd.sub_f64s(own.0, greatest);
                let least = simd.select_f64s(simd.greater_than_f64s(slope, zero), rest, zero);
                let mut cap = none;
                for (weight, target) in [(greatest, high), (least, low)] {
                    let target = simd.add_f64s(run.1, simd.mul_f64s(target, weight));
                    cap = cap.most(simd, Explained::of(simd, simd.add_f64s(run.0, weight), target, total));
                }
                most = most.most(simd, cap);
                caps[2 * m].set::<S>(part, cap.above);
                caps[2 * m + 1].set::<S>(part, cap.below);
            }
            run = (simd.add_f64s(run.0, own.0), simd.add_f64s(run.1, own.1));
            best = best.most(simd, Explained::of(simd, run.0, run.1, total));
        }
        let edge = best.error(simd, square);
        let lower = if INSIDE { simd.min_f64s(edge, most.error(simd, square)) } else { edge };
        reached.store::<S>(part, m, edge, lower);
    }
}

/// A pass of sloped errors of few distinct targets.
///
/// One constant errs by `sum over gaps between neighbouring targets of gap * min(down * weight below, up * weight
/// above)`: the quantile makes each term least. Let a side cost `T = down * below + up * above` at a gap, and
/// `D = down * below - up * above`, and let d be the same as D left of a cut. `min(a, b) = (a + b - |a - b|) / 2` and
/// `|d| + |D - d| = max(|D|, |2 d - D|)` make a cut's two constants
///
/// ```text
/// err by   sum over gaps of gap * (T / 2 - max(|D| / 2, |d - D / 2|))
/// ```
///
/// so that one number a gap, d - D / 2, says all. Rows of a cell: weight of each target of all samples, of those left
/// of the cut, and whether cuts lie inside.
pub(crate) struct Sloped<'a> {
    /// What a unit of distance costs.
    pub(crate) slopes: Slopes,
    /// Cells of the group.
    pub(crate) lines: &'a [Line],
    /// Least error of cuts inside each bucket, out: of each side, where cuts lie inside.
    pub(crate) caps: &'a mut [Line],
    /// Weight of each target on both sides.
    pub(crate) totals: [[f64; MOST_VALUES]; 2],
    /// Distance of each target from the next.
    pub(crate) gaps: [f64; MOST_VALUES],
    /// Number of targets.
    pub(crate) n_values: usize,
    /// Whether a bucket may have cuts inside.
    pub(crate) has_inside: bool,
    /// Which sides are asked for; nothing is reached on the others.
    pub(crate) needs: [bool; 2],
}

impl WithSimd for Sloped<'_> {
    type Output = Reached;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Reached {
        match (self.n_values, self.has_inside) {
            (5, true) => self.sweep::<S, 5, 11, true>(simd),
            (2, _) => self.sweep::<S, 2, 5, true>(simd),
            (3, _) => self.sweep::<S, 3, 7, true>(simd),
            (4, _) => self.sweep::<S, 4, 9, true>(simd),
            (5, _) => self.sweep::<S, 5, 11, false>(simd),
            (6, _) => self.sweep::<S, 6, 13, true>(simd),
            (7, _) => self.sweep::<S, 7, 15, true>(simd),
            _ => self.sweep::<S, 8, 17, true>(simd),
        }
    }
}

impl Sloped<'_> {
    #[inline(always)]
    fn sweep<S: Simd, const V: usize, const ROWS: usize, const INSIDE: bool>(&mut self, simd: S) -> Reached {
        let (needs, mut reached) = (self.needs, Reached::NOTHING);
        for part in 0..LANES / S::F64_LANES {
            for m in [0, 1].into_iter().filter(|&m| needs[m]) {
                self.side::<S, V, ROWS, INSIDE>(simd, part, m, &mut reached);
            }
        }
        reached
    }

    #[inline(always)]
    fn side<S: Simd, const V: usize, const ROWS: usize, const INSIDE: bool>(
        &mut self,
        simd: S,
        part: usize,
        m: usize,
        reached: &mut Reached,
    ) {
        let (zero, infinite) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::INFINITY));
        let (minus_up, down) = (simd.splat_f64s(-self.slopes.up), simd.splat_f64s(self.slopes.down));
        let gaps: [S::f64s; V] = std::array::from_fn(|j| simd.splat_f64s(self.gaps[j]));
        let (base, halves) = self.start::<V>(m);
        let least: [S::f64s; V] = std::array::from_fn(|j| simd.splat_f64s(halves[j].abs()));
        let mut places: [S::f64s; V] = std::array::from_fn(|j| simd.splat_f64s(-halves[j]));
        let base = simd.splat_f64s(base);
        let mut best = zero;
        for j in 0..V - 1 {
            best = simd.add_f64s(best, simd.mul_f64s(gaps[j], least[j]));
        }
        let mut lower = infinite;
        let cells = self.lines.as_chunks::<ROWS>().0.iter().zip(self.caps.as_chunks_mut::<CAPS>().0);
        for (cell, caps) in cells {
            let own: [S::f64s; V] = std::array::from_fn(|v| {
                let left = cell[V + v].part::<S>(part);
                if m == 0 { left } else { simd.sub_f64s(cell[v].part::<S>(part), left) }
            });
            let weight = own[1..].iter().fold(own[0], |sum, &w| simd.add_f64s(sum, w));
            let (mut low, mut saved, mut most) = (zero, zero, zero);
            for j in 0..V - 1 {
                low = simd.add_f64s(low, own[j]);
                let high = simd.sub_f64s(weight, low);
                let up = simd.mul_add_f64s(down, low, places[j]);
                if INSIDE {
                    // The place inside the bucket lies between the two ends, and what is saved is convex in it.
                    let ends =
                        simd.max_f64s(simd.abs_f64s(up), simd.abs_f64s(simd.mul_add_f64s(minus_up, high, places[j])));
                    most = simd.add_f64s(most, simd.mul_f64s(gaps[j], simd.max_f64s(least[j], ends)));
                }
                places[j] = simd.mul_add_f64s(minus_up, high, up);
                let own = simd.max_f64s(least[j], simd.abs_f64s(places[j]));
                saved = simd.add_f64s(saved, simd.mul_f64s(gaps[j], own));
            }
            best = simd.max_f64s(best, saved);
            if INSIDE {
                let is_open = simd.greater_than_f64s(cell[2 * V].part::<S>(part), zero);
                let cap = simd.select_f64s(is_open, simd.sub_f64s(base, most), infinite);
                lower = simd.min_f64s(lower, cap);
                caps[m].set::<S>(part, cap);
            }
        }
        let edge = simd.sub_f64s(base, best);
        reached.store::<S>(part, m, edge, simd.min_f64s(edge, lower));
    }

    /// Half of what both sides of each gap cost, times the gaps, and of each gap half of what more is below than above.
    #[inline(always)]
    fn start<const V: usize>(&self, m: usize) -> (f64, [f64; V]) {
        let Slopes { up, down } = self.slopes;
        let (weight, mut below): (f64, _) = (self.totals[m].iter().sum(), 0.0);
        let mut base = 0.5 * weight * up * self.gaps[..V - 1].iter().sum::<f64>();
        let halves = std::array::from_fn(|j| {
            below += self.totals[m][j];
            // Nothing is added where both slopes are 1.
            base += if j + 1 < V { 0.5 * (down - up) * below * self.gaps[j] } else { 0.0 };
            0.5 * ((up + down) * below - up * weight)
        });
        (base, halves)
    }
}

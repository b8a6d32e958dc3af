//! Bounds of trees of one split on some samples, counted for sets of lines.

use std::ops::Range;

use super::bands::{Band, Cut, Samples, TINY};
use super::checker::{Checker, MOST, SlopeInterval, Tally};
use super::region::EPS;

/// Slope intervals no wider than this are not sifted any finer. Bands are halved where that is needed, while each
/// interval costs a pass over the samples at least: with 1/32 checks took 1.3 to 4 times as long.
const NARROW: f64 = 1.0;
/// Most different points whose dichotomies are tried before a band is split (at the end of splitting `MOST`, or any
/// number on one line).
const FEW: usize = 6;

impl Checker<'_> {
    /// Whether a leaf, or a split in these intervals with so many samples on either side, costs `claim` or more for
    /// these samples, and so for all sets that contain them.
    pub(super) fn child_costs(&self, ids: &[u32], need: i64, intervals: &[SlopeInterval], claim: i64) -> bool {
        let samples = Samples { ids, total: self.tally(ids), need };
        let k = self.q.n_classes;
        let mut pairs = (0..k).flat_map(|a| (a..k).map(move |b| [a, b]));
        if pairs.all(|pair| self.choosing(&samples.total, &pair) >= claim) {
            return true; // a child gives two labels at most
        }
        let is_leaf_enough = self.leaf(&samples.total) >= claim || samples.total[k] < need;
        is_leaf_enough
            && intervals.iter().all(|interval| {
                let band = self.around(&samples, interval);
                self.is_closed(&samples, &band, ids, (&vec![0; k + 1], None), claim)
            })
    }

    /// The parts of intervals where not all splits cost `dead` or more.
    pub(super) fn sift(&self, ids: &[u32], need: i64, intervals: &[SlopeInterval], dead: i64) -> Vec<SlopeInterval> {
        let samples = Samples { ids, total: self.tally(ids), need };
        let none = vec![0; self.q.n_classes + 1];
        let mut kept = Vec::new();
        let mut waiting: Vec<SlopeInterval> = intervals.iter().rev().copied().collect();
        while let Some((dual_plane, t0, t1)) = waiting.pop() {
            let band = self.around(&samples, &(dual_plane, t0, t1));
            let (_, alive) = self.scan(&samples, &band, ids, &none, dead);
            if !alive.contains(&true) {
                continue;
            }
            if t1 - t0 <= NARROW {
                kept.push((dual_plane, t0, t1));
                continue;
            }
            let middle = (t0 + t1) / 2.0;
            waiting.extend([(dual_plane, middle, t1), (dual_plane, t0, middle)]);
        }
        kept
    }

    /// Whether every split by a line of the band costs `claim` or more; only the lines of `open` samples run in it.
    fn is_closed(
        &self,
        samples: &Samples<'_>,
        band: &Band,
        open: &[u32],
        (left, around): (&Tally, Option<&Cut<'_>>),
        claim: i64,
    ) -> bool {
        let (places, alive) = self.scan(samples, band, open, left, claim);
        let (is_narrow, width) = (band.t[1] - band.t[0] <= TINY, band.c[1] - band.c[0]);
        let (n_bins, mut begin) = (alive.len(), 0);
        while begin < n_bins {
            let mut end = begin + 1;
            if !alive[begin] {
                begin = end;
                continue;
            }
            while !is_narrow && end < n_bins && alive[end] {
                end += 1;
            }
            let (below, inside) = self.below_and_inside(left, open, &places, begin..end);
            let is_end = is_narrow && width <= TINY;
            let edge = |bin: usize| band.c[0] + bin as f64 * (width.max(EPS) / n_bins as f64);
            let part = [edge(begin) - EPS, edge(end) + EPS];
            let cut = Cut { open, places: &places, begin, dual_plane: band.dual_plane, around };
            let is_parted = self.is_parted(samples, band, &inside, (&below, &cut), claim, is_end);
            let is_half_closed = |half: &Band| self.is_closed(samples, half, &inside, (&below, Some(&cut)), claim);
            if !is_parted && (is_end || !self.halves(band, part, &inside).iter().all(is_half_closed)) {
                return false;
            }
            begin = end;
        }
        true
    }

    /// Of the `open` samples those below some bins, added to `left`, and those that may lie in them.
    fn below_and_inside(
        &self,
        left: &Tally,
        open: &[u32],
        places: &[[usize; 2]],
        bins: Range<usize>,
    ) -> (Tally, Vec<u32>) {
        let (mut inside, mut below) = (Vec::new(), left.clone());
        for (&i, place) in open.iter().zip(places) {
            if place[1] < bins.start {
                self.join(&mut below, i);
            } else if place[0] < bins.end {
                inside.push(i);
            }
        }
        (below, inside)
    }

    /// Whether every dichotomy of the different points in a band costs `claim` or more; false if they are not few.
    ///
    /// At the end of splitting, dichotomies that no line makes with the samples below and above on their sides do not
    /// count.
    fn is_parted(
        &self,
        samples: &Samples<'_>,
        band: &Band,
        inside: &[u32],
        (below, cut): (&Tally, &Cut<'_>),
        claim: i64,
        is_end: bool,
    ) -> bool {
        let plane = self.points.plane(band.dual_plane);
        let points = if is_end { plane.end_points(inside, MOST) } else { plane.few_points(inside, FEW) };
        let Some(points) = points else {
            return false;
        };
        let places = plane.places(&points, inside);
        plane.dichotomies(&points, band.t[0], band.t[1]).iter().all(|dichotomy| {
            let mut left = below.clone();
            let joined = || inside.iter().zip(&places).filter(|(_, place)| dichotomy[**place]).map(|(&i, _)| i);
            joined().for_each(|i| self.join(&mut left, i));
            let right: Tally = samples.total.iter().zip(&left).map(|(a, b)| a - b).collect();
            let k = self.q.n_classes;
            let is_small = left[k].min(right[k]) < samples.need;
            let costs = |left: &Tally, right: &Tally| self.leaf(left) + self.leaf(right) + self.price(band.dual_plane);
            is_small || costs(&left, &right) >= claim || (is_end && !self.is_line_between(samples, cut, joined()))
        })
    }

    /// Whether a line has those below a band and some inside it on one side, all other samples on the other.
    fn is_line_between(&self, samples: &Samples<'_>, cut: &Cut<'_>, joined: impl Iterator<Item = u32>) -> bool {
        let mut left = cut.left();
        left.extend(joined);
        left.sort_unstable();
        let right: Vec<u32> = samples.ids.iter().copied().filter(|i| left.binary_search(i).is_err()).collect();
        self.points.plane(cut.dual_plane).can_part(&left, &right)
    }
}

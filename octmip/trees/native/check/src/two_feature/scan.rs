//! Bounds of all lines of a band at once, bin by bin.

use super::bands::{Band, Samples};
use super::checker::{Checker, Tally};
use super::region::EPS;

/// Most bins of r in which lines are counted at once.
const BINS: usize = 64;

impl Checker<'_> {
    /// For each sample the first bin of c where it may go left and the last where it may go right; for each bin
    /// whether a line of it may cost less than `claim`.
    ///
    /// The bin of a number never falls as it grows, whatever the rounding: so a line of bin b has at its left only
    /// samples whose first bin is b or less, and likewise on the right. `left` are samples left of the whole band.
    pub(super) fn scan(
        &self,
        samples: &Samples<'_>,
        band: &Band,
        open: &[u32],
        left: &Tally,
        claim: i64,
    ) -> (Vec<[usize; 2]>, Vec<bool>) {
        let (lanes, n_bins) = (self.q.n_classes + 1, (2 * open.len()).clamp(8, BINS));
        let scale = n_bins as f64 / (band.c[1] - band.c[0]).max(EPS);
        let bin = |c: f64| (((c - band.c[0]) * scale) as usize).min(n_bins - 1);
        let (mut first, mut last) = (vec![0; n_bins * lanes], vec![0; n_bins * lanes]);
        let mut may_right: Tally = samples.total.iter().zip(left).map(|(a, b)| a - b).collect();
        let mut may_left = left.clone();
        let places: Vec<[usize; 2]> = open.iter().map(|&i| self.reach(band, i).map(bin)).collect();
        for (&i, place) in open.iter().zip(&places) {
            self.join(&mut first[place[0] * lanes..], i);
            self.join(&mut last[place[1] * lanes..], i);
        }
        let (mut alive, mut is_same) = (Vec::with_capacity(n_bins), false);
        let owed = claim - self.price(band.dual_plane);
        let mut scratch = Vec::with_capacity(2 * lanes);
        for (more, less) in first.chunks_exact(lanes).zip(last.chunks_exact(lanes)) {
            may_left.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            alive.push(match alive.last() {
                Some(&alive) if is_same && more[lanes - 1] == 0 => alive,
                _ => self.may_be_below(samples, &may_left, &may_right, owed, &mut scratch),
            });
            may_right.iter_mut().zip(less).for_each(|(sum, less)| *sum -= less);
            is_same = less[lanes - 1] == 0;
        }
        (places, alive)
    }

    /// Whether two different labels may cost samples less than `owed`, by those that may go left and those that may go
    /// right: one that may do both has the cheaper label.
    fn may_be_below(
        &self,
        samples: &Samples<'_>,
        may_left: &[i64],
        may_right: &[i64],
        owed: i64,
        scratch: &mut Vec<i64>,
    ) -> bool {
        let (q, k, total) = (self.q, self.q.n_classes, &samples.total);
        if may_left[k] < samples.need || may_right[k] < samples.need {
            return false;
        }
        if !self.may_save_enough(samples, may_left, may_right, owed, scratch) {
            return false;
        }
        let sure = |may: &[i64], label| -> i64 { (0..k).map(|c| (total[c] - may[c]) * q.cost(c, label)).sum() };
        scratch.clear();
        scratch.extend((0..k).map(|label| sure(may_left, label)));
        scratch.extend((0..k).map(|c| may_left[c] + may_right[c] - total[c]));
        let (right, both) = scratch.split_at(k);
        (0..k).any(|a| {
            let left = sure(may_right, a);
            (0..k).any(|b| {
                let spare = |cheaper: &[i64]| cheaper.iter().zip(both).map(|(cost, n)| cost * n).sum::<i64>();
                let known = left + right[b];
                a != b && known < owed && known + spare(&self.cheaper[(a * k + b) * k..][..k]) < owed
            })
        })
    }

    /// The same as if a sample that may do both could have both labels at once, and save by each of them: then it saves
    /// no less than in truth. So where this does not save enough nothing does. What the labels save adds up side by
    /// side, and where a class saves by its own label alone the answer is that of all pairs.
    fn may_save_enough(
        &self,
        samples: &Samples<'_>,
        may_left: &[i64],
        may_right: &[i64],
        owed: i64,
        scratch: &mut Vec<i64>,
    ) -> bool {
        let k = self.q.n_classes;
        scratch.clear();
        scratch.resize(2 * k, 0);
        let (left, right) = scratch.split_at_mut(k);
        for (c, savings) in self.savings.iter().enumerate() {
            for &(label, saving) in savings {
                left[label] += may_left[c] * saving;
                right[label] += may_right[c] * saving;
            }
        }
        let worst: i64 = self.worst.iter().zip(&samples.total).map(|(cost, weight)| cost * weight).sum();
        (0..k).any(|a| (0..k).any(|b| a != b && worst - left[a] - right[b] < owed))
    }
}

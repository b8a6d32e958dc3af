//! Walks inside buckets: only those whose bound is above the best edge, and only until the threshold is decided.

use crate::samples::Samples;
use crate::stumps::buckets::Buckets;
use crate::stumps::place::Place;
use crate::stumps::scan::split_gain;
use crate::stumps::sweep::{Lane, STRIDE};
use crate::stumps::uncertainty::{Candidate, Sides};

impl<T: Lane, const N: usize, const S: usize> Buckets<T, N, S> {
    /// Look inside buckets, the side of larger remaining uncertainty first, until the stumps are exact or close the
    /// interval.
    pub(super) fn finish(&mut self, samples: &Samples, place: &Place<'_>, sides: &mut Sides, threshold: i64) {
        let n = self.groups.len();
        loop {
            let reach = |side: usize| (0..n).map(|g| (self.reaches[g][side], g)).max().unwrap_or((0, 0));
            let widest = [reach(0), reach(1)];
            let uncertainty = [0, 1].map(|side| widest[side].0 - sides.best[side]);
            let side = usize::from(uncertainty[1] > uncertainty[0]);
            let gains = [0, 1].map(|side| widest[side].0.max(sides.best[side]));
            if uncertainty[side] <= 0 || sides.is_closed(gains, place.target, threshold) {
                return;
            }
            let group = widest[side].1;
            let mut lowered = self.reaches[group];
            if self.tighten(group, sides.best, &mut lowered) {
                self.reaches[group] = lowered;
                continue;
            }
            let other = gains[1 - side];
            let mut reach = [other, other];
            self.refine(samples, place, (group, side), sides, &mut reach, threshold);
            self.reaches[group][side] = reach[side];
        }
    }

    /// Largest gain inside the buckets of a group on one side, given that `best` is known and `threshold` is enough.
    pub(super) fn refine(
        &mut self,
        samples: &Samples,
        place: &Place<'_>,
        (group, side): (usize, usize),
        sides: &mut Sides,
        reach: &mut [i64; 2],
        threshold: i64,
    ) {
        self.collect(group, side, sides.best[side], samples.p);
        for index in 0..=self.candidates.len() {
            let next = self.candidates.get(index).copied();
            let best = sides.best[side];
            reach[side] = next.map_or(best, |candidate| best.max(candidate.cap));
            let is_closed = sides.is_closed(*reach, place.target, threshold);
            let Some(candidate) = next.filter(|candidate| candidate.cap > best && !is_closed) else {
                break;
            };
            sides.best[side] = best.max(self.walk(samples, place, group, side, candidate));
        }
    }

    /// Buckets of a side whose cap is above `best`, the most promising first.
    fn collect(&mut self, group: usize, side: usize, best: i64, p: usize) {
        let least = T::narrow(best);
        self.candidates.clear();
        let histogram = &self.groups[group];
        let above = |row: &[T; N]| row.iter().fold(false, |any, &c| any | (c > least));
        for (stride, _) in histogram.tops.iter().enumerate().filter(|(_, top)| above(top)) {
            for bucket in stride * STRIDE..(stride + 1) * STRIDE {
                let caps = &histogram.caps[bucket];
                if !above(caps) {
                    continue;
                }
                for lane in (side..N).step_by(2).filter(|&lane| caps[lane] > least) {
                    let feature = group * self.shape.slots + lane / 2;
                    if feature < p {
                        let cap = histogram.cap(lane, bucket, &self.profiles, caps[lane].widen());
                        if cap > best {
                            self.candidates.push(Candidate { cap, feature, bucket });
                        }
                    }
                }
            }
        }
        self.candidates.sort_unstable_by(|a, b| b.cmp(a));
    }

    /// Largest gain of a cut inside a bucket, on one side.
    fn walk(&mut self, samples: &Samples, place: &Place<'_>, group: usize, side: usize, candidate: Candidate) -> i64 {
        let Candidate { feature, bucket, .. } = candidate;
        let mut left = std::mem::take(&mut self.left);
        left.resize(self.whole.len(), 0);
        let lane = 2 * (feature % self.shape.slots) + side;
        self.groups[group].running_sums(lane, bucket, &self.profiles, &mut left);
        let table = &self.tables[self.used];
        let ranks = samples.ranks_of(feature);
        let members = table.members(samples, place.view.list(feature), feature, bucket);
        let (mut best, mut last) = (i64::MIN, None);
        for &i in members.iter().filter(|&&i| place.is_on(side, i)) {
            let rank = ranks[i as usize];
            if last.is_some_and(|before| before != rank) {
                best = best.max(split_gain(&left, &self.totals[side]));
            }
            samples.count(i, 1, &mut left);
            last = Some(rank);
        }
        self.left = left;
        best
    }
}

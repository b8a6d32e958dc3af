//! Best stumps by a plain walk along every list: the reference.

use crate::samples::Samples;
use crate::stumps::place::{Place, Stump, StumpSolver, Sums};
use crate::view::View;

/// Stump solver by walks.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    scores: Vec<i64>,
    sums: [(Vec<i64>, i64); 2],
}

/// The best stump of one feature on one side: gain and cut (largest rank that goes left).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BestCut {
    /// Gain of both leaves.
    pub(crate) gain: i64,
    /// Largest rank that goes left.
    pub(crate) cut: u32,
}

/// Walk one list over the samples that `keeps`: up to count what the left leaf gains, and down for the right one. The
/// largest of gains that only grow is known without all the others.
pub(crate) fn best_cut(samples: &Samples, list: &[u32], f: usize, keeps: impl Fn(u32) -> bool) -> Option<BestCut> {
    let ranks = samples.ranks_of(f);
    let kept: Vec<u32> = list.iter().copied().filter(|&i| keeps(i)).collect();
    let mut gains = vec![0i64; samples.n_labels];
    let mut below = vec![0i64; kept.len()];
    let mut largest = 0;
    for (k, &i) in kept.iter().enumerate() {
        below[k] = largest;
        largest = largest_after(samples, i, &mut gains, largest);
    }
    gains.fill(0);
    largest = 0;
    let mut best: Option<BestCut> = None;
    for k in (1..kept.len()).rev() {
        largest = largest_after(samples, kept[k], &mut gains, largest);
        let (before, rank) = (ranks[kept[k - 1] as usize], ranks[kept[k] as usize]);
        let gain = below[k] + largest;
        // Of equals the first cut, which comes last on the way down.
        if before != rank
            && k >= samples.leaf_size
            && kept.len() - k >= samples.leaf_size
            && best.is_none_or(|best| gain >= best.gain)
        {
            best = Some(BestCut { gain, cut: before });
        }
    }
    best
}

/// Add the gains of a sample, which are never below 0; the largest of all, `largest` before.
#[inline(always)]
fn largest_after(samples: &Samples, sample: u32, gains: &mut [i64], largest: i64) -> i64 {
    samples.count(sample, 1, gains);
    if samples.is_single {
        largest.max(gains[samples.profile[sample as usize] as usize])
    } else {
        gains.iter().copied().fold(largest, i64::max)
    }
}

/// Gain of two leaves, the left of gains `left`, together of gains `totals`.
#[inline]
pub(crate) fn split_gain(left: &[i64], totals: &[i64]) -> i64 {
    let (mut low, mut high) = (i64::MIN, i64::MIN);
    for (l, t) in left.iter().zip(totals) {
        low = low.max(*l);
        high = high.max(t - l);
    }
    low + high
}

impl Scan {
    fn stump(&mut self, samples: &Samples, place: &Place<'_>, side: usize) -> Stump {
        let mut totals = vec![0; samples.n_labels];
        let mut total_range = 0;
        let list = place.view.list(place.f);
        let members = if side == 0 { &list[..place.k] } else { &list[place.k..] };
        for &i in members {
            samples.count(i, 1, &mut totals);
            total_range += samples.ranges[i as usize];
        }
        let mut gain = totals.iter().copied().max().unwrap_or(0);
        for f in (0..samples.p).filter(|_| place.leaf_side != Some(side)) {
            let keeps = |i: u32| place.is_on(side, i);
            let best = best_cut(samples, place.view.list(f), f, keeps);
            self.scores[f] = best.map_or(0, |best| best.gain);
            gain = gain.max(self.scores[f] - samples.penalty);
        }
        self.sums[side] = (totals, total_range);
        Stump { lower: total_range - gain, value: total_range - gain }
    }
}

impl StumpSolver for Scan {
    fn prepare(&mut self, _: &Samples, _: &View) {}

    fn forget(&mut self) {}

    fn load(&mut self, samples: &Samples, view: &View) -> Stump {
        self.scores.resize(samples.p, 0);
        self.stump(samples, &Place::whole(view), 1)
    }

    fn scores(&self) -> &[i64] {
        &self.scores
    }

    fn sums(&self, side: usize) -> Sums<'_> {
        (&self.sums[side].0, self.sums[side].1)
    }

    fn reach(&self, _: usize, _: usize) -> i64 {
        i64::MAX
    }

    fn rewind(&mut self) {}

    fn both(&mut self, samples: &Samples, place: &Place<'_>, _threshold: i64) -> [Stump; 2] {
        [0, 1].map(|side| self.stump(samples, place, side))
    }
}

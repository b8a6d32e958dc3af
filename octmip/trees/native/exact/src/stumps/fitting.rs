//! Best stumps whose leaves hold a least number of samples.
//!
//! A stump with leaves of any size gains no less, and histograms tell for all features at once how much that is
//! (`StumpSolver::reach`). So only the features that may reach what is wanted are walked, the most promising first.

use crate::samples::Samples;
use crate::stumps::place::{Place, Stump, Sums};
use crate::stumps::scan::split_gain;
use crate::view::View;

/// Buffers of the walks.
#[derive(Debug, Default)]
pub(crate) struct Fitting {
    left: Vec<i64>,
    members: Vec<u32>,
    /// Gain of each sample, that in the second of two labels negative.
    signed: Vec<i64>,
    open: Vec<(i64, usize)>,
}

impl Fitting {
    /// The best stumps, or leaf, of one side of a cut, with leaves of one or two sizes, the smaller first; exact where
    /// they cost less than `upper`. `sums`: of its samples; `reach`: the most that a stump of a feature gains there
    /// with leaves of any size.
    pub(crate) fn stump<const N: usize>(
        &mut self,
        samples: &Samples,
        place: &Place<'_>,
        (side, sizes): (usize, [usize; N]),
        upper: i64,
        sums: Sums<'_>,
        reach: impl Fn(usize) -> i64,
    ) -> [Stump; N] {
        let (totals, total_range) = sums;
        let len = if side == 0 { place.k } else { place.view.len - place.k };
        let mut costs = [total_range - totals.iter().copied().max().unwrap_or(0); N];
        let least = |gain: i64| total_range.saturating_sub(gain.saturating_sub(samples.penalty));
        let mut open = std::mem::take(&mut self.open);
        open.clear();
        // Where there is no room for two leaves of a size one leaf is best.
        if let Some(last) = (0..N).rev().find(|&size| len >= 2 * sizes[size]) {
            open.extend(
                (0..samples.p).map(|f| (reach(f), f)).filter(|&(gain, _)| least(gain) < costs[last].min(upper)),
            );
            open.sort_unstable_by(|a, b| b.cmp(a));
            for &(gain, f) in &open {
                if least(gain) >= costs[last].min(upper) {
                    break;
                }
                let gains = self.walk(samples, place, (side, sizes), (totals, len), f);
                costs.iter_mut().zip(gains).for_each(|(cost, gain)| *cost = least(gain).min(*cost));
            }
        }
        self.open = open;
        // What was not walked costs `upper` or more, or no less than the best of the largest leaves that have room.
        costs.map(|cost| Stump { lower: cost.min(upper), value: cost })
    }

    /// The best stump of all samples of a view.
    pub(crate) fn whole(&mut self, samples: &Samples, view: &View, size: usize, upper: i64) -> Stump {
        self.stump(samples, &Place::whole(view), (1, [size]), upper, (&view.totals, view.total_range), |_| i64::MAX)[0]
    }

    /// Largest gains of two leaves of a feature on one side, of so many samples, for each of the sizes; the least
    /// number where there are none.
    fn walk<const N: usize>(
        &mut self,
        samples: &Samples,
        place: &Place<'_>,
        (side, sizes): (usize, [usize; N]),
        (totals, len): (&[i64], usize),
        f: usize,
    ) -> [i64; N] {
        let (list, ranks, has_ties) = (place.view.list(f), samples.ranks_of(f), samples.has_ties[f]);
        if let (&[first, second], true) = (totals, samples.is_single) {
            let kept = (side, sizes, len);
            return match has_ties {
                true => self.walk_pair::<N, true>(samples, place, kept, (list, ranks), [first, second]),
                false => self.walk_pair::<N, false>(samples, place, kept, (list, ranks), [first, second]),
            };
        }
        self.left.clear();
        self.left.resize(totals.len(), 0);
        // Without a branch, as no guess of which samples are on a side is good; it writes ahead.
        self.members.resize(list.len() + 1, 0);
        let mut n_members = 0;
        for &i in list {
            self.members[n_members] = i;
            n_members += usize::from(place.is_on(side, i));
        }
        let (mut before, mut best) = (0, [i64::MIN; N]);
        for (passed, &i) in self.members[..len].iter().enumerate() {
            if passed + sizes[0] > len {
                break; // too few are left
            }
            let (sample, smaller) = (i as usize, passed.min(len - passed));
            if smaller >= sizes[0] && (!has_ties || before != ranks[sample]) {
                let size = if smaller >= sizes[N - 1] { N - 1 } else { 0 }; // two sizes at most
                best[size] = best[size].max(split_gain(&self.left, totals));
            }
            if has_ties {
                before = ranks[sample];
            }
            samples.count(i, 1, &mut self.left);
        }
        best[0] = best[0].max(best[N - 1]);
        best
    }

    /// The same of two labels that each sample gains in one of, in one pass without branches. Samples of the other side
    /// are passed with nothing added: what is seen at them is seen once more.
    fn walk_pair<const N: usize, const TIES: bool>(
        &mut self,
        samples: &Samples,
        place: &Place<'_>,
        (side, sizes, len): (usize, [usize; N], usize),
        (list, ranks): (&[u32], &[u32]),
        [first, second]: [i64; 2],
    ) -> [i64; N] {
        if self.signed.len() != samples.n {
            let signed = |i: usize| if samples.profile[i] == 0 { samples.ranges[i] } else { -samples.ranges[i] };
            self.signed = (0..samples.n).map(signed).collect();
        }
        let signed = &self.signed[..];
        let room = sizes.map(|size| len.checked_sub(2 * size));
        let (mut passed, mut difference, mut before) = (0, 0, u32::MAX);
        let mut best = [i64::MIN; N];
        for &i in list {
            let is_cut = !TIES || std::mem::replace(&mut before, ranks[i as usize]) != ranks[i as usize];
            // Of two labels, one left and one right: as good as a leaf is known.
            let gain = i64::max(second + difference, first - difference);
            for n in 0..N {
                let has_room = room[n].is_some_and(|room| usize::wrapping_sub(passed, sizes[n]) <= room);
                let own = if is_cut & has_room { gain } else { i64::MIN };
                best[n] = best[n].max(own);
            }
            let is_member = place.is_on(side, i);
            passed += usize::from(is_member);
            difference += signed[i as usize] & -i64::from(is_member);
        }
        best
    }
}

//! Best stumps whose leaves hold a least number of samples.
//!
//! A stump with leaves of any size gains no less, and histograms tell for all features at once how much that is
//! (`StumpSolver::reach`). So only the features that may reach what is wanted are walked, the most promising first.

use crate::samples::Samples;
use crate::stumps::place::{Place, Stump};
use crate::stumps::scan::split_gain;
use crate::view::View;

/// Buffers of the walks.
#[derive(Debug, Default)]
pub(crate) struct Fitting {
    totals: Vec<i64>,
    left: Vec<i64>,
    /// Whether each sample is on the side at hand.
    marks: Vec<bool>,
    members: Vec<u32>,
    open: Vec<(i64, usize)>,
}

impl Fitting {
    /// The best stumps, or leaf, of one side of a cut, with leaves of sizes that grow; exact where they cost less than
    /// `upper`. `reach`: the most that a stump of a feature gains there with leaves of any size.
    pub(crate) fn stump<const N: usize>(
        &mut self,
        samples: &Samples,
        place: &Place<'_>,
        (side, sizes): (usize, [usize; N]),
        upper: i64,
        reach: impl Fn(usize) -> i64,
    ) -> [Stump; N] {
        let list = place.view.list(place.f);
        let members = if side == 0 { &list[..place.k] } else { &list[place.k..] };
        self.totals.clear();
        self.totals.resize(samples.n_labels, 0);
        self.marks.resize(samples.n, false);
        for &i in members {
            samples.count(i, 1, &mut self.totals);
            self.marks[i as usize] = true;
        }
        let total_range: i64 = members.iter().map(|&i| samples.range_of(i)).sum();
        let mut costs = [total_range - self.totals.iter().copied().max().unwrap_or(0); N];
        let least = |gain: i64| total_range.saturating_sub(gain.saturating_sub(samples.penalty));
        let mut open = std::mem::take(&mut self.open);
        open.clear();
        // Where there is no room for two leaves of a size one leaf is best.
        if let Some(last) = (0..N).rev().find(|&size| members.len() >= 2 * sizes[size]) {
            open.extend(
                (0..samples.p).map(|f| (reach(f), f)).filter(|&(gain, _)| least(gain) < costs[last].min(upper)),
            );
            open.sort_unstable_by(|a, b| b.cmp(a));
            for &(gain, f) in &open {
                if least(gain) >= costs[last].min(upper) {
                    break;
                }
                let gains = self.walk(samples, place.view.list(f), f, sizes, members.len());
                for (cost, gain) in costs.iter_mut().zip(gains) {
                    *cost = gain.map_or(*cost, |gain| least(gain).min(*cost));
                }
            }
        }
        members.iter().for_each(|&i| self.marks[i as usize] = false);
        self.open = open;
        // What was not walked costs `upper` or more, or no less than the best of the largest leaves that have room.
        costs.map(|cost| Stump { lower: cost.min(upper), value: cost })
    }

    /// The best stump of all samples of a view.
    pub(crate) fn whole(&mut self, samples: &Samples, view: &View, size: usize, upper: i64) -> Stump {
        self.stump(samples, &Place::whole(view), (1, [size]), upper, |_| i64::MAX)[0]
    }

    /// Largest gains of two leaves of a feature on the side that is marked, of so many samples, for each of the sizes.
    fn walk<const N: usize>(
        &mut self,
        samples: &Samples,
        list: &[u32],
        f: usize,
        sizes: [usize; N],
        len: usize,
    ) -> [Option<i64>; N] {
        let (ranks, has_ties) = (samples.ranks_of(f), samples.has_ties[f]);
        self.left.clear();
        self.left.resize(self.totals.len(), 0);
        // Without a branch, as no guess of which samples are on a side is good; it writes ahead.
        self.members.resize(list.len() + 1, 0);
        let mut n_members = 0;
        for &i in list {
            self.members[n_members] = i;
            n_members += usize::from(self.marks[i as usize]);
        }
        let (mut before, mut best) = (0, [None; N]);
        for (passed, &i) in self.members[..len].iter().enumerate() {
            if passed + sizes[0] > len {
                break; // too few are left
            }
            let smaller = passed.min(len - passed);
            if smaller >= sizes[0] && (!has_ties || before != ranks[i as usize]) {
                let is_largest = smaller >= sizes[N - 1];
                let size =
                    if is_largest { N - 1 } else { sizes.iter().rposition(|&size| size <= smaller).unwrap_or(0) };
                best[size] = best[size].max(Some(match (&self.left[..], &self.totals[..]) {
                    (&[low, high], &[all_low, all_high]) => (low + all_high - high).max(high + all_low - low),
                    (left, totals) => split_gain(left, totals),
                }));
            }
            if has_ties {
                before = ranks[i as usize];
            }
            if samples.is_single {
                self.left[samples.profile[i as usize] as usize] += samples.range_of(i); // what each gains
            } else {
                samples.count(i, 1, &mut self.left);
            }
        }
        (0..N - 1).rev().for_each(|size| best[size] = best[size].max(best[size + 1]));
        best
    }
}

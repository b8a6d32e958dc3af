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
    open: Vec<(i64, usize)>,
}

impl Fitting {
    /// The best stump, or leaf, of one side of a cut, exact where it costs less than `upper`. `reach`: the most that a
    /// stump of a feature gains there with leaves of any size.
    pub(crate) fn stump(
        &mut self,
        samples: &Samples,
        place: &Place<'_>,
        side: usize,
        upper: i64,
        reach: impl Fn(usize) -> i64,
    ) -> Stump {
        let list = place.view.list(place.f);
        let members = if side == 0 { &list[..place.k] } else { &list[place.k..] };
        self.totals.clear();
        self.totals.resize(samples.n_labels, 0);
        members.iter().for_each(|&i| samples.count(i, 1, &mut self.totals));
        let total_range: i64 = members.iter().map(|&i| samples.range_of(i)).sum();
        let mut cost = total_range - self.totals.iter().copied().max().unwrap_or(0);
        let least = |gain: i64| total_range.saturating_sub(gain.saturating_sub(samples.penalty));
        let mut open = std::mem::take(&mut self.open);
        open.clear();
        if members.len() >= 2 * samples.leaf_size {
            open.extend((0..samples.p).map(|f| (reach(f), f)).filter(|&(gain, _)| least(gain) < cost.min(upper)));
        }
        open.sort_unstable_by(|a, b| b.cmp(a));
        for &(gain, f) in &open {
            if least(gain) >= cost.min(upper) {
                break;
            }
            if let Some(gain) = self.walk(samples, place, side, members.len(), f) {
                cost = cost.min(least(gain));
            }
        }
        self.open = open;
        // What was not walked costs `upper` or more.
        Stump { lower: cost.min(upper), value: cost }
    }

    /// The same of all samples of a view.
    pub(crate) fn whole(&mut self, samples: &Samples, view: &View, upper: i64) -> Stump {
        self.stump(samples, &Place::whole(view), 1, upper, |_| i64::MAX)
    }

    /// Largest gain of two leaves of a feature on one side, of so many samples.
    fn walk(&mut self, samples: &Samples, place: &Place<'_>, side: usize, len: usize, f: usize) -> Option<i64> {
        let (ranks, least) = (samples.ranks_of(f), samples.leaf_size);
        self.left.clear();
        self.left.resize(self.totals.len(), 0);
        let (mut passed, mut before, mut best) = (0, None, None);
        for &i in place.view.list(f).iter().filter(|&&i| place.is_on(side, i)) {
            if passed + least > len {
                break; // too few are left
            }
            let rank = ranks[i as usize];
            if passed >= least && before != Some(rank) {
                best = best.max(Some(split_gain(&self.left, &self.totals)));
            }
            samples.count(i, 1, &mut self.left);
            (passed, before) = (passed + 1, Some(rank));
        }
        best
    }
}

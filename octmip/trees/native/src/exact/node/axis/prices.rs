//! What the price of a split says of the cuts of a feature.

use crate::exact::node::axis::Axis;
use crate::exact::node::result::Solved;
use crate::exact::samples::Samples;

impl Axis {
    /// The same bounds for trees of `levels` levels in one child or the other: those of fewer are known.
    pub(crate) fn want_levels(&mut self, samples: &Samples, levels: usize) {
        if self.is_priced {
            self.of_all_levels = samples.penalty.saturating_mul(levels as i64);
        }
    }

    /// The same from cuts that were solved for trees of one level fewer.
    ///
    /// A child of the levels wanted has fewer, and costs what it does then, or has them all and pays for as many
    /// splits: `e(L) >= min(e of fewer levels, levels * price)`. What is known of the solved cuts bounds those between
    /// as ever.
    pub(crate) fn take_up_fewer(&mut self, f: usize, solved: &[Solved]) {
        let most = self.of_all_levels;
        if most == 0 {
            return;
        }
        let last = self.last();
        let mut known = [vec![0; last + 1], vec![0; last + 1]];
        for cut in solved.iter().filter(|cut| cut.feature == f) {
            if let Some(k) = self.cut_at(cut.position) {
                (known[0][k], known[1][k]) = (cut.bounds[0].min(most), cut.bounds[1].min(most));
            }
        }
        let step = |k: usize| self.total_range[k + 1] - self.total_range[k];
        for k in 0..last {
            let (left, right) = (known[0][k], known[1][k]);
            if self.is_monotone {
                known[0][k + 1] = known[0][k + 1].max(left);
            }
            if self.has_range {
                known[1][k + 1] = known[1][k + 1].max(right - step(k));
            }
        }
        for k in (0..last).rev() {
            let (left, right) = (known[0][k + 1], known[1][k + 1]);
            if self.has_range {
                known[0][k] = known[0][k].max(left - step(k));
            }
            if self.is_monotone {
                known[1][k] = known[1][k].max(right);
            }
        }
        for (bounds, known) in self.by_price.iter_mut().zip(known) {
            bounds.iter_mut().zip(known).for_each(|(bound, known)| *bound = known.max(*bound));
        }
    }

    /// What both children cost together at least in a wanted tree, from what each of them costs.
    #[inline(always)]
    pub(super) fn together(&self, (left, right): (i64, i64)) -> i64 {
        let all = self.of_all_levels;
        (left + right).max((left.max(all) + right).min(left + right.max(all)))
    }
}

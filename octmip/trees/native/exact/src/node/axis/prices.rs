//! What is known of the cuts of a feature beforehand: by the price of a split, or by an earlier search.

use crate::node::axis::Axis;
use crate::node::result::Solved;
use crate::samples::Samples;
use crate::view::View;

impl Axis {
    /// The same bounds for trees of `levels` levels in one child or the other: those of fewer are known.
    pub(crate) fn want_levels(&mut self, samples: &Samples, levels: usize) {
        if samples.penalty > 0 && self.has_least {
            self.of_all_levels = samples.penalty.saturating_mul(levels as i64);
        }
    }

    /// The same from cuts that were solved for trees of one level fewer.
    ///
    /// A child of the levels wanted has fewer, and costs what it does then, or has them all and pays for as many
    /// splits: `e(L) >= min(e of fewer levels, levels * price)`.
    pub(crate) fn take_up_fewer(&mut self, f: usize, solved: &[Solved]) {
        if self.of_all_levels > 0 {
            self.spread(f, solved, self.of_all_levels);
        }
    }

    /// The same from cuts that were solved with leaves of any size.
    pub(crate) fn take_up_free(&mut self, f: usize, solved: &[Solved]) {
        if self.is_beside && solved.iter().any(|cut| cut.feature == f) {
            self.spread(f, solved, i64::MAX);
        }
    }

    /// The same where the child on this side is a leaf: what that costs.
    pub(crate) fn take_up_leaves(&mut self, samples: &Samples, view: &View, f: usize, side: usize) {
        let mut gains = [vec![0; samples.n_labels], view.totals.clone()];
        let mut from = 0;
        let ends = self.positions[..=self.last()].iter().zip(&self.total_range);
        let costs: Vec<i64> = ends
            .map(|(&to, &total_range)| {
                for &i in &view.list(f)[from..to as usize] {
                    samples.count(i, 1, &mut gains[0]);
                    samples.count(i, -1, &mut gains[1]);
                }
                from = to as usize;
                let range = [total_range, view.total_range - total_range];
                range[side] - gains[side].iter().copied().max().unwrap_or(0)
            })
            .collect();
        self.take_up_costs(side, &costs);
    }

    /// The same where the cost of the child on this side is known at each cut.
    pub(crate) fn take_up_costs(&mut self, side: usize, costs: &[i64]) {
        self.least_of.iter_mut().for_each(|least| least.resize(costs.len(), 0));
        self.least_of[side].copy_from_slice(costs);
        self.has_least = true;
    }

    /// Raise what is known of children to the bounds of solved cuts, up to `most`; what is known of these bounds those
    /// between as ever.
    fn spread(&mut self, f: usize, solved: &[Solved], most: i64) {
        let last = self.last();
        let mut known = [vec![0; last + 1], vec![0; last + 1]];
        for cut in solved.iter().filter(|cut| cut.feature == f) {
            if let Some(k) = self.cut_at(cut.position) {
                let bounds = cut.bounds.map(|bound| bound.min(most));
                (known[0][k], known[1][k]) = (known[0][k].max(bounds[0]), known[1][k].max(bounds[1]));
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
        for (bounds, known) in self.least_of.iter_mut().zip(known) {
            bounds.resize(known.len(), 0);
            bounds.iter_mut().zip(known).for_each(|(bound, known)| *bound = known.max(*bound));
        }
        self.has_least = true;
    }

    /// What both children cost together at least in a wanted tree, from what each of them costs.
    #[inline(always)]
    pub(super) fn together(&self, (left, right): (i64, i64)) -> i64 {
        let all = self.of_all_levels;
        (left + right).max((left.max(all) + right).min(left + right.max(all)))
    }
}

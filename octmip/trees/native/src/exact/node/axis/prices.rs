//! What the price of a split says of the cuts of a feature.

use crate::exact::node::axis::Axis;
use crate::exact::node::price::least_by_labels;
use crate::exact::node::result::Solved;
use crate::exact::samples::Samples;
use crate::exact::view::View;

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

    /// What each side of every cut costs at least by price and labels.
    pub(super) fn lay_prices(&mut self, samples: &Samples, view: &View, f: usize) {
        let (ranks, list, n_leaves) = (samples.ranks_of(f), view.list(f), self.n_leaves);
        let smallest = samples.leaf_size.max(1);
        let (mut gains, mut total_range) = (vec![0; samples.n_labels], 0);
        let mut sorted = vec![0; samples.n_labels];
        let [left, right] = &mut self.by_price;
        left.clear();
        right.clear();
        let mut rank = list.first().map_or(0, |&i| ranks[i as usize]);
        for k in 0..=list.len() {
            let next = list.get(k).map_or(u32::MAX, |&i| ranks[i as usize]);
            let is_cut = next != rank && k >= smallest && view.len - k >= smallest;
            if k == 0 || k == list.len() || is_cut {
                sorted.copy_from_slice(&gains);
                left.push(least_by_labels(samples, total_range, &mut sorted, n_leaves));
                sorted.iter_mut().zip(&view.totals).zip(&gains).for_each(|((rest, all), left)| *rest = all - left);
                right.push(least_by_labels(samples, view.total_range - total_range, &mut sorted, n_leaves));
            }
            rank = next;
            if let Some(&i) = list.get(k) {
                samples.count(i, 1, &mut gains);
                total_range += samples.ranges[i as usize];
            }
        }
    }

    /// What both children cost together at least in a wanted tree, from what each of them costs.
    #[inline(always)]
    pub(super) fn together(&self, (left, right): (i64, i64)) -> i64 {
        let all = self.of_all_levels;
        (left + right).max((left.max(all) + right).min(left + right.max(all)))
    }
}

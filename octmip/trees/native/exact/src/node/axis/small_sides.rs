//! Sides of cuts that hold too few samples for two leaves of the least size: one leaf, whose cost is known beforehand.

use crate::samples::Samples;
use crate::view::View;

/// What the sides of the first and the last cuts of a feature cost as leaves.
///
/// Within these cuts it never falls as a side grows; of the others nothing is known.
#[derive(Debug, Default)]
pub(super) struct SmallSides {
    /// Of the left sides of the first cuts, and of the right sides of the last ones.
    costs: [Vec<i64>; 2],
    /// The first cut whose right side is small.
    from: usize,
}

impl SmallSides {
    /// Count the small sides of the cuts at these positions, with so much range left of each.
    pub(super) fn lay(
        &mut self,
        samples: &Samples,
        view: &View,
        (f, leaf_size): (usize, usize),
        positions: &[u32],
        total_range: &[i64],
    ) {
        self.costs.iter_mut().for_each(Vec::clear);
        let (list, last) = (view.list(f), positions.len() - 1);
        let is_small = |len: usize| len < 2 * leaf_size;
        let mut gains = vec![0; samples.n_labels];
        let mut counted = 0;
        for (&k, &range) in positions.iter().zip(total_range).take_while(|cut| is_small(*cut.0 as usize)) {
            let k = k as usize;
            list[counted..k].iter().for_each(|&i| samples.count(i, 1, &mut gains));
            counted = k;
            self.costs[0].push(range - gains.iter().copied().max().unwrap_or(0));
        }
        gains.fill(0);
        counted = view.len;
        self.from = last + 1;
        while self.from > 0 && is_small(view.len - positions[self.from - 1] as usize) {
            self.from -= 1;
            let k = positions[self.from] as usize;
            list[k..counted].iter().for_each(|&i| samples.count(i, 1, &mut gains));
            counted = k;
            let range = total_range[last] - total_range[self.from];
            self.costs[1].push(range - gains.iter().copied().max().unwrap_or(0));
        }
        self.costs[1].reverse();
    }

    /// What the left and the right sides of all cuts from one to another cost at least.
    #[inline(always)]
    pub(super) fn least(&self, first: usize, last: usize) -> [i64; 2] {
        let left = if last < self.costs[0].len() { self.costs[0][first] } else { 0 };
        let right = if first >= self.from { self.costs[1][last - self.from] } else { 0 };
        [left, right]
    }
}

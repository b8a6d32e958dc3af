//! The best tree of one split that is in order within itself and with decided leaves.

use crate::shaped::boxes::{Fixed, labels, side};
use crate::shaped::monotone::{Cut, Found, Monotone, Node, ends_of};
use octmip_frame::tree::Tree;

/// A split of a node: usable feature, largest rank of its left side.
type Split = (usize, u32);

/// Costs of each label on both sides of a cut (`n_labels` each).
type Sums = [Vec<i64>; 2];

impl Monotone<'_> {
    /// The best split of a node in order with the decided leaves, if it costs less than `upper`.
    pub(super) fn stump(&mut self, node: &Node, fixed: &[Fixed], mut upper: i64) -> Found {
        let cuts = self.cuts(node, 1, upper)?;
        let worth = |cut: &&Cut| cut.bounds[0] + cut.bounds[1] + self.penalty < upper;
        let mut cuts: Vec<(usize, usize)> = cuts.iter().filter(worth).map(|cut| (cut.feature, cut.position)).collect();
        cuts.sort_unstable();
        let (samples, totals) = (self.samples, self.label_costs(node));
        let mut best = None;
        for cuts in cuts.chunk_by(|a, b| a.0 == b.0) {
            let f = cuts[0].0;
            let (ranks, list, ends) = (samples.ranks_of(f), node.view.list(f), ends_of(fixed, f));
            let mut sums = [vec![0; totals.len()], totals.clone()];
            let mut passed = 0;
            for &(_, position) in cuts {
                list[passed..position].iter().for_each(|&i| self.pass(i, &mut sums));
                passed = position;
                let [first, next] = [position - 1, position].map(|k| ranks[list[k] as usize]);
                for &place in ends.iter().filter(|&&end| end > first && end < next).chain([&first]) {
                    if let Some((cost, tree)) = self.at(node, (f, place), &sums, fixed, upper) {
                        (upper, best) = (cost, Some((cost, tree)));
                    }
                }
            }
        }
        best
    }

    /// Move a sample from the right side to the left one.
    fn pass(&self, sample: u32, [left, right]: &mut Sums) {
        let row = self.costs_of(sample);
        left.iter_mut().zip(row).for_each(|(sum, cost)| *sum += cost);
        right.iter_mut().zip(row).for_each(|(sum, cost)| *sum -= cost);
    }

    /// The best labels of both sides of a split.
    fn at(&self, node: &Node, (f, place): Split, sums: &Sums, fixed: &[Fixed], mut upper: i64) -> Found {
        let ends = [0, 1].map(|s| labels(&side(&node.bounds, f, place, s), fixed, &self.directions, self.n_labels));
        let mut best = None;
        for left in ends[0][0]..=ends[0][1] {
            for right in ends[1][0]..=ends[1][1] {
                let rise = (i64::from(right) - i64::from(left)) * i64::from(self.directions[f]);
                let cost = sums[0][left as usize] + sums[1][right as usize] + self.penalty;
                if left != right && rise >= 0 && cost < upper {
                    (upper, best) = (cost, Some([left, right]));
                }
            }
        }
        let [left, right] = best?.map(Tree::leaf);
        Some((upper, Tree::join(self.samples.features[f], place, &left, &right)))
    }
}

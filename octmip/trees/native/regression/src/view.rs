//! The samples that reach a node: one list of ids per feature, each in its order, and one in the order of the targets.

use crate::clusters::{Histogram, N_BINS, Sums};
use crate::samples::Samples;
use octmip_frame::interval::part;
use octmip_frame::tree::{Node, Tree};

/// Samples of a node. The cut at position `k` of feature `f` sends the first `k` samples of list `f` left.
#[derive(Debug, Clone, Default)]
pub(crate) struct View {
    /// Number of samples.
    pub len: usize,
    /// Sample ids, list after list (`(p + 1) * len`), the last in the order of the targets.
    lists: Vec<u32>,
}

impl View {
    /// All the samples.
    pub(crate) fn root(samples: &Samples) -> Self {
        Self { len: samples.n, lists: samples.order.clone() }
    }

    /// The samples in the order of feature `f`; `p` gives the order of the targets.
    pub(crate) fn list(&self, f: usize) -> &[u32] {
        &self.lists[f * self.len..(f + 1) * self.len]
    }

    /// The largest rank of feature `f` left of a cut.
    pub(crate) fn rank_before(&self, samples: &Samples, f: usize, position: usize) -> u32 {
        samples.ranks_of(f)[self.list(f)[position - 1] as usize]
    }

    /// Fill `sides` with the samples left and right of the cut at position `k` of feature `f`.
    pub(crate) fn split(&self, samples: &Samples, f: usize, k: usize, marks: &mut [bool], sides: &mut [View; 2]) {
        for (position, &i) in self.list(f).iter().enumerate() {
            marks[i as usize] = position >= k;
        }
        let lists = sides.each_mut().map(|view| &mut view.lists);
        part(samples.p + 1, (self.len, k), |g| self.list(g), marks, lists);
        (sides[0].len, sides[1].len) = (k, self.len - k);
    }

    /// What the samples sum to.
    pub(crate) fn sums(&self, samples: &Samples) -> Sums {
        let mut total = Sums::default();
        for &i in self.list(samples.p) {
            total += samples.sums[i as usize];
        }
        total
    }

    /// Least error of one constant.
    pub(crate) fn leaf(&self, samples: &Samples) -> f64 {
        let Some(slopes) = samples.slopes else {
            return self.sums(samples).squared_error();
        };
        let list = self.list(samples.p);
        let total: f64 = list.iter().map(|&i| samples.sums[i as usize].weight).sum();
        let mut below = 0.0;
        let mut quantile = 0.0;
        for &i in list {
            quantile = samples.targets[i as usize];
            below += samples.sums[i as usize].weight;
            if slopes.is_reached(below, total) {
                break;
            }
        }
        let error = |&i: &u32| {
            let miss = samples.targets[i as usize] - quantile;
            samples.sums[i as usize].weight * slopes.most(-miss, miss)
        };
        list.iter().map(error).sum()
    }

    /// Whether leaves of a tree of so many levels have room for twice the least size: the problem with leaves of any
    /// size then is near to the one that is asked, and easier.
    pub(crate) fn has_room(&self, samples: &Samples, depth: usize) -> bool {
        (self.len >> depth.min(20)) / 2 >= samples.leaf_size
    }

    /// Whether every leaf of a tree has so many of the samples.
    pub(crate) fn holds_leaves(&self, samples: &Samples, tree: &Tree, leaf_size: usize) -> bool {
        let mut counts = vec![0; tree.nodes.len()];
        for &i in self.list(samples.p) {
            let mut row = 0;
            while let Node::Split { feature, cut, left, right } = &tree.nodes[row] {
                let f = samples.features.iter().position(|usable| usable == feature).unwrap_or(samples.p);
                let is_left = samples.ranks_of(f)[i as usize] <= *cut;
                row = if is_left { *left } else { *right } as usize;
            }
            counts[row] += 1;
        }
        let is_large = |(node, count): (&Node, &usize)| !matches!(node, Node::Leaf { .. }) || *count >= leaf_size;
        tree.nodes.iter().zip(&counts).all(is_large)
    }

    /// Lower bound of the error of any tree with so many leaves.
    pub(crate) fn cluster_bound(&self, samples: &Samples, n_leaves: usize) -> f64 {
        let mut histogram: Histogram = [Sums::default(); N_BINS];
        for &i in self.list(samples.p) {
            histogram[samples.bins.of_sample[i as usize] as usize] += samples.sums[i as usize];
        }
        samples.bins.bound(&histogram, n_leaves, samples.slopes)
    }

    /// Least and greatest target.
    pub(crate) fn ends(&self, samples: &Samples) -> (f64, f64) {
        let list = self.list(samples.p);
        let target = |place: Option<&u32>| place.map_or(0.0, |&i| samples.targets[i as usize]);
        (target(list.first()), target(list.last()))
    }
}

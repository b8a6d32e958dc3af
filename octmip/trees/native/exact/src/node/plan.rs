//! A tree found, its last levels left to be looked up again when it is wanted.

use crate::samples::Samples;
use crate::stumps::scan::{BestCut, best_cut};
use crate::view::{View, first_largest};
use octmip_frame::tree::{Node, Tree};

/// The best tree of a search, in short; only the plan that wins becomes a tree.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Plan {
    /// The best leaf of the samples that arrive.
    Leaf,
    /// Their best tree of at most one split.
    Stump,
    /// A cut.
    Split {
        /// Usable feature.
        feature: usize,
        /// Largest rank that goes left.
        cut: u32,
        /// Plans of both sides.
        sides: Box<[Plan; 2]>,
    },
    /// A tree that came from elsewhere.
    Whole(Tree),
}

impl Plan {
    /// The plan of a tree, its last splits to be chosen anew; None where it reads another feature than the usable ones.
    pub(crate) fn of(samples: &Samples, tree: &Tree) -> Option<Self> {
        Self::of_row(samples, tree, 0)
    }

    fn of_row(samples: &Samples, tree: &Tree, row: usize) -> Option<Self> {
        let Node::Split { feature, cut, left, right } = &tree.nodes[row] else { return Some(Self::Leaf) };
        let sides = [left, right].map(|&side| Self::of_row(samples, tree, side as usize));
        Some(match sides {
            [Some(Self::Leaf), Some(Self::Leaf)] => Self::Stump,
            [left, right] => {
                let feature = samples.features.iter().position(|usable| usable == feature)?;
                Self::Split { feature, cut: *cut, sides: Box::new([left?, right?]) }
            }
        })
    }

    /// A cut at position `k` of feature `f` of a view.
    pub(crate) fn split(samples: &Samples, view: &View, f: usize, k: usize, sides: [Plan; 2]) -> Self {
        let cut = samples.ranks_of(f)[view.list(f)[k - 1] as usize];
        Self::Split { feature: f, cut, sides: Box::new(sides) }
    }

    /// The tree on the samples of a view, features and cuts as the problem numbers them.
    pub(crate) fn tree(&self, samples: &Samples, view: &View) -> Tree {
        match self {
            Self::Leaf => Tree::leaf(samples.labels[view.best_label()]),
            Self::Stump => stump(samples, view, view, |_| true),
            Self::Split { feature, cut, sides } => {
                let ranks = samples.ranks_of(*feature);
                let k = view.with_list(*feature, |list| list.partition_point(|&i| ranks[i as usize] <= *cut));
                let [left, right] = [0, 1].map(|side| match &sides[side] {
                    Self::Stump => {
                        let (part, is_here) = view.totals_of_side(samples, *feature, k, side);
                        stump(samples, view, &part, |i| is_here[i as usize])
                    }
                    plan => plan.tree(samples, &view.side(samples, *feature, k, side)),
                });
                Tree::join(samples.features[*feature], *cut, &left, &right)
            }
            Self::Whole(tree) => tree.clone(),
        }
    }
}

/// The best tree of one split on the part of a view that is here, the first among equals; a leaf when no split is worth
/// its price. The part has its totals, and no lists.
fn stump(samples: &Samples, view: &View, part: &View, is_here: impl Fn(u32) -> bool) -> Tree {
    let mut best: Option<(BestCut, usize)> = None;
    for f in 0..samples.p {
        let found = view.with_list(f, |list| best_cut(samples, list, f, &is_here));
        if let Some(found) = found.filter(|found| best.is_none_or(|(best, _)| found.gain > best.gain)) {
            best = Some((found, f));
        }
    }
    let leaf = part.total_range - part.leaf();
    let Some((BestCut { cut, .. }, f)) = best.filter(|(best, _)| best.gain - samples.penalty > leaf) else {
        return Plan::Leaf.tree(samples, part);
    };
    let ranks = samples.ranks_of(f);
    let mut left = vec![0; samples.n_labels];
    view.with_list(f, |list| {
        let is_left = |i: &u32| ranks[*i as usize] <= cut && is_here(*i);
        list.iter().copied().filter(is_left).for_each(|i| samples.count(i, 1, &mut left));
    });
    let right: Vec<i64> = part.totals.iter().zip(&left).map(|(all, left)| all - left).collect();
    let [left, right] = [left, right].map(|totals| Tree::leaf(samples.labels[first_largest(&totals)]));
    Tree::join(samples.features[f], cut, &left, &right)
}

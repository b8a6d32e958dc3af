//! A tree found, its last levels left to be looked up again when it is wanted.

use crate::exact::samples::Samples;
use crate::exact::stumps::scan::best_cut;
use crate::exact::view::View;
use crate::tree::Tree;

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
    /// A cut at position `k` of feature `f` of a view.
    pub(crate) fn split(samples: &Samples, view: &View, f: usize, k: usize, sides: [Plan; 2]) -> Self {
        let cut = samples.ranks_of(f)[view.list(f)[k - 1] as usize];
        Self::Split { feature: f, cut, sides: Box::new(sides) }
    }

    /// The tree on the samples of a view, features and cuts as the problem numbers them.
    pub(crate) fn tree(&self, samples: &Samples, view: &View) -> Tree {
        match self {
            Self::Leaf => Tree::leaf(samples.labels[view.best_label()]),
            Self::Stump => match best_stump(samples, view) {
                Some((f, cut)) => {
                    Self::Split { feature: f, cut, sides: Box::new([Self::Leaf, Self::Leaf]) }.tree(samples, view)
                }
                None => Self::Leaf.tree(samples, view),
            },
            Self::Split { feature, cut, sides } => {
                let ranks = samples.ranks_of(*feature);
                let k = view.with_list(*feature, |list| list.partition_point(|&i| ranks[i as usize] <= *cut));
                let [left, right] = [0, 1].map(|side| {
                    let part = view.side(samples, *feature, k, side);
                    sides[side].tree(samples, &part)
                });
                Tree::join(samples.features[*feature], *cut, &left, &right)
            }
            Self::Whole(tree) => tree.clone(),
        }
    }
}

/// Feature and cut of the best stump, the lowest among equals; None when no split is worth its price.
fn best_stump(samples: &Samples, view: &View) -> Option<(usize, u32)> {
    let mut best: Option<(i64, usize, u32)> = None;
    for f in 0..samples.p {
        let found = view.with_list(f, |list| best_cut(samples, list, f, &view.totals, view.len, |_| true));
        if let Some(found) = found.filter(|found| best.is_none_or(|(gain, _, _)| found.gain > gain)) {
            best = Some((found.gain, f, found.cut));
        }
    }
    let leaf = view.total_range - view.leaf();
    best.filter(|&(gain, _, _)| gain - samples.penalty > leaf).map(|(_, f, cut)| (f, cut))
}

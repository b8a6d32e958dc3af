//! The rule of a split: a cut of one feature, or a hyperplane.

use std::hash::{Hash, Hasher};

use octmip_check::problem::Problem;

/// The rule of a node, which sends its samples left or right.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Rule {
    /// No rule: a leaf.
    Leaf,
    /// Left when the rank is at most `cut`.
    Axis {
        /// Feature index.
        feature: u32,
        /// Largest rank that goes left.
        cut: u32,
    },
    /// Left when the terms, added from first to last, come to at most `offset`.
    Plane {
        /// Feature and coefficient, features ascending.
        terms: Vec<(u32, f64)>,
        /// Largest projection that goes left.
        offset: f64,
    },
}

impl Hash for Rule {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        match self {
            Self::Leaf => 0_u8.hash(hasher),
            Self::Axis { feature, cut } => (1_u8, feature, cut).hash(hasher),
            Self::Plane { terms, offset } => {
                (2_u8, offset.to_bits()).hash(hasher);
                terms.iter().for_each(|(feature, weight)| (feature, weight.to_bits()).hash(hasher));
            }
        }
    }
}

impl Rule {
    /// Number of features read.
    pub(crate) fn size(&self) -> usize {
        match self {
            Self::Leaf => 0,
            Self::Axis { .. } => 1,
            Self::Plane { terms, .. } => terms.len(),
        }
    }

    /// The features read.
    pub(crate) fn features(&self) -> impl Iterator<Item = u32> + '_ {
        let (axis, terms) = match self {
            Self::Leaf => (None, &[][..]),
            Self::Axis { feature, .. } => (Some(*feature), &[][..]),
            Self::Plane { terms, .. } => (None, terms.as_slice()),
        };
        axis.into_iter().chain(terms.iter().map(|term| term.0))
    }

    /// The left rule of `octmip.trees.nodes.tree`, in the same floating-point operations.
    #[inline]
    pub(crate) fn goes_left(&self, problem: &Problem, sample: u32) -> bool {
        match self {
            Self::Leaf => true,
            Self::Axis { feature, cut } => problem.ranks[*feature as usize * problem.n + sample as usize] <= *cut,
            Self::Plane { terms, offset } => project(problem, terms, sample) <= *offset,
        }
    }
}

/// `terms . x` of a sample: products rounded, then added from the first feature to the last.
#[inline]
pub(crate) fn project(problem: &Problem, terms: &[(u32, f64)], sample: u32) -> f64 {
    let row = problem.row(sample);
    terms.iter().fold(0.0, |sum, &(f, c)| sum + c * row[f as usize])
}

/// A cut of one feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AxisCut {
    /// Feature index.
    pub(crate) feature: u32,
    /// Largest rank that goes left.
    pub(crate) cut: u32,
}

//! Boxes of ranks, and the order that two leaves must keep.
//!
//! A tree is monotone in a feature when its prediction never falls as that feature rises and all others stay. Two
//! leaves are compared by that where their boxes overlap in all other features: then some point of one lies straight
//! above a point of the other. Leaves of one tree overlap nowhere, so there is exactly one feature in which they part:
//!
//! ```text
//! leaf A  x0 in 0..=3, x1 in 0..=9
//! leaf B  x0 in 4..=9, x1 in 5..=9     part in x0 alone: A lies below B along x0
//! leaf C  x0 in 4..=9, x1 in 0..=4     part from B in x1, from A in x0
//! ```
//!
//! Boxes are compared by ranks of the whole problem: thresholds between the same two ranks count as equal. Equal ones
//! make boxes overlap least, so no tree is lost.

use std::rc::Rc;

/// Smallest and largest rank of each usable feature.
pub(super) type Bounds = Rc<[[u32; 2]]>;

/// A leaf that is decided: its box and what it predicts.
#[derive(Debug, Clone)]
pub(super) struct Fixed {
    pub(super) bounds: Bounds,
    pub(super) label: u32,
}

/// The largest rank of each usable feature's left part, replaced on one side.
pub(super) fn side(bounds: &Bounds, feature: usize, cut: u32, side: usize) -> Bounds {
    let mut part: Vec<[u32; 2]> = bounds.to_vec();
    part[feature] = if side == 0 { [bounds[feature][0], cut] } else { [cut + 1, bounds[feature][1]] };
    part.into()
}

/// How two boxes that overlap nowhere must be ordered: `Greater` where the label of `b` must be that of `a` or more,
/// `Less` where it must be that or less; None where nothing compares them.
pub(super) fn order(a: &Bounds, b: &Bounds, directions: &[i8]) -> Option<std::cmp::Ordering> {
    let mut parting = None;
    for (f, (a, b)) in a.iter().zip(b.iter()).enumerate() {
        if a[1] < b[0] || b[1] < a[0] {
            if parting.is_some() || directions[f] == 0 {
                return None;
            }
            parting = Some((f, a[1] < b[0]));
        }
    }
    let (f, is_below) = parting?;
    let rises = directions[f] > 0;
    Some(if rises == is_below { std::cmp::Ordering::Greater } else { std::cmp::Ordering::Less })
}

/// Smallest and largest label that a leaf in these bounds may predict beside the decided ones.
pub(super) fn labels(bounds: &Bounds, fixed: &[Fixed], directions: &[i8], n_labels: u32) -> [u32; 2] {
    let mut ends = [0, n_labels - 1];
    for leaf in fixed {
        match order(&leaf.bounds, bounds, directions) {
            Some(std::cmp::Ordering::Greater) => ends[0] = ends[0].max(leaf.label),
            Some(_) => ends[1] = ends[1].min(leaf.label),
            None => {}
        }
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cmp::Ordering::{Greater, Less};

    #[test]
    fn leaves_are_ordered_where_they_part_in_one_monotone_feature() {
        let [a, b, c]: [Bounds; 3] = [[[0, 3], [0, 9]].into(), [[4, 9], [5, 9]].into(), [[4, 9], [0, 4]].into()];
        assert_eq!(order(&a, &b, &[1, 0]), Some(Greater));
        assert_eq!(order(&b, &a, &[1, 0]), Some(Less));
        assert_eq!(order(&a, &b, &[-1, 0]), Some(Less));
        assert_eq!(order(&c, &b, &[1, 0]), None);
        assert_eq!(order(&c, &b, &[1, 1]), Some(Greater));
        let apart: Bounds = [[4, 9], [10, 12]].into();
        assert_eq!(order(&a, &apart, &[1, 1]), None);
    }
}

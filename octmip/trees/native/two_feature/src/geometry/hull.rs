//! Convex hulls of samples, and whether a line can part two sets, in exact arithmetic.

use std::cmp::Ordering;

use crate::geometry::plane::Plane;

/// Whether a line can part these samples strictly, in exact arithmetic.
///
/// Two disjoint convex polygons lie strictly to both sides of a line along an edge of one of them; where all points lie
/// on one line, their order on it decides.
pub(crate) fn can_part(plane: &Plane, (f, g): (usize, usize), left: &[u32], right: &[u32]) -> bool {
    let (a, b) = (hull(plane, (f, g), left), hull(plane, (f, g), right));
    if a.is_empty() || b.is_empty() {
        return true;
    }
    if all_on_one_line(plane, (f, g), &a, &b) {
        let range = |hull: &[u32]| {
            let points = || hull.iter().map(|&i| plane.point(f, g, i));
            (points().min(), points().max())
        };
        let ((a_low, a_high), (b_low, b_high)) = (range(&a), range(&b));
        return a_high < b_low || b_high < a_low;
    }
    has_edge_clear_of(plane, (f, g), &a, &b) || has_edge_clear_of(plane, (f, g), &b, &a)
}

fn all_on_one_line(plane: &Plane, (f, g): (usize, usize), a: &[u32], b: &[u32]) -> bool {
    let all = || a.iter().chain(b).copied();
    let other = all().find(|&i| plane.point(f, g, i) != plane.point(f, g, a[0]));
    other.is_none_or(|other| all().all(|i| plane.turn(f, g, a[0], other, i) == Ordering::Equal))
}

/// Whether some edge of the polygon `a` (a segment has two) has all of `b` strictly on its outer side.
fn has_edge_clear_of(plane: &Plane, (f, g): (usize, usize), a: &[u32], b: &[u32]) -> bool {
    let mut edges = a.iter().zip(a.iter().cycle().skip(1));
    a.len() > 1 && edges.any(|(&from, &to)| b.iter().all(|&i| plane.turn(f, g, from, to, i) == Ordering::Less))
}

/// The corners of the convex hull, counter-clockwise, in exact arithmetic.
pub(crate) fn hull(plane: &Plane, (f, g): (usize, usize), ids: &[u32]) -> Vec<u32> {
    let mut sorted = ids.to_vec();
    sorted.sort_by_key(|&i| (plane.point(f, g, i), i));
    sorted.dedup_by_key(|i| plane.point(f, g, *i));
    if sorted.len() < 3 {
        return sorted;
    }
    let mut corners = half_hull(plane, (f, g), sorted.iter().copied());
    let upper = half_hull(plane, (f, g), sorted.iter().rev().copied());
    corners.pop();
    corners.extend(&upper[..upper.len() - 1]);
    corners
}

fn half_hull(plane: &Plane, (f, g): (usize, usize), ids: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut chain: Vec<u32> = Vec::new();
    for i in ids {
        while let [.., a, b] = chain[..]
            && plane.turn(f, g, a, b, i) != Ordering::Greater
        {
            chain.pop();
        }
        chain.push(i);
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_cannot_part_crossing_diagonals_nor_the_middle_from_both_ends() {
        let plane = Plane::of_points(&[(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0), (0.5, 0.5)]);
        assert!(!can_part(&plane, (0, 1), &[0, 1], &[2, 3]));
        assert!(can_part(&plane, (0, 1), &[0, 2], &[1, 3]));
        assert!(!can_part(&plane, (0, 1), &[0, 1], &[4]));
        assert!(can_part(&plane, (0, 1), &[0, 4], &[1]));
        assert!(can_part(&plane, (0, 1), &[0], &[1, 2, 3, 4]));
    }
}

//! Where the splitting of a cell ends: few open points, or open points on one line, and the ways a line can part them.

use std::cmp::Ordering;

use super::cell::Cell;
use super::plane::Plane;

/// Open points on one line beyond this area count as collinear and are parted in exact arithmetic.
const FLAT: f64 = 1.0 / (1u64 << 40) as f64;
/// More points than this are parted only where they are exactly collinear.
const MOST_POINTS: usize = 24;

/// What is to become of a cell.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// Split it.
    Split,
    /// All ways in which a line can part the open points (groups of equal samples): true = left.
    Parts {
        /// Samples at each point.
        points: Vec<Vec<u32>>,
        /// For each way, the side of each point.
        ways: Vec<Vec<bool>>,
    },
    /// Too small to split, too crowded to part: its bound has to stand.
    Stuck,
}

/// Look whether the splitting of a cell ends here.
pub fn end_of(plane: &Plane, features: (usize, usize), cell: &Cell, open: &[u32]) -> End {
    let tiny = !cell.is_wide() && !cell.is_high();
    // On an axis all points lie on one line, and splitting tells them apart.
    let is_axis = features.1 == plane.p;
    if open.len() > 3 && !tiny && (is_axis || !is_flat(plane, features, open)) {
        return End::Split;
    }
    let points = distinct_points(plane, features, open);
    match ways_to_part(plane, features, &points) {
        Some(ways) => End::Parts { points, ways },
        None if tiny => End::Stuck,
        None => End::Split,
    }
}

/// Whether all samples lie on one line, or nearly so (in scaled coordinates).
fn is_flat(plane: &Plane, (f, g): (usize, usize), open: &[u32]) -> bool {
    let (x, y) = (plane.column(f), plane.column(g));
    let at = |i: u32| (x[i as usize], y[i as usize]);
    let (ax, ay) = at(open[0]);
    let distance = |i: &u32| {
        let (bx, by) = at(*i);
        (bx - ax).abs() + (by - ay).abs()
    };
    let Some(&far) = open.iter().max_by(|i, j| distance(i).total_cmp(&distance(j))) else {
        return true;
    };
    let (bx, by) = at(far);
    open.iter().all(|&i| {
        let (cx, cy) = at(i);
        ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)).abs() <= FLAT
    })
}

/// The samples grouped by point, the points in the order of the first feature, then of the second.
pub(super) fn distinct_points(plane: &Plane, (f, g): (usize, usize), open: &[u32]) -> Vec<Vec<u32>> {
    let mut sorted = open.to_vec();
    sorted.sort_by_key(|&i| (plane.point(f, g, i), i));
    sorted.chunk_by(|&i, &j| plane.point(f, g, i) == plane.point(f, g, j)).map(<[u32]>::to_vec).collect()
}

/// All ways in which a line can part these points (sorted by coordinates), and perhaps some that it cannot.
///
/// Points on one line come apart as a prefix and a suffix in their order along it. In general, every way is that of a
/// line through two of the points, turned a little about a place between or beyond the points on it.
fn ways_to_part(plane: &Plane, (f, g): (usize, usize), points: &[Vec<u32>]) -> Option<Vec<Vec<bool>>> {
    let m = points.len();
    let at = |k: usize| points[k][0];
    if m <= 2 {
        return Some(all_ways(m));
    }
    let mut collinear = true;
    for k in 1..m - 1 {
        collinear &= plane.turn(f, g, at(0), at(m - 1), at(k)) == Ordering::Equal;
    }
    let mut ways: Vec<Vec<bool>> = Vec::new();
    if collinear {
        for cut in 0..m {
            ways.push((0..m).map(|k| k < cut).collect());
            ways.push((0..m).map(|k| k >= cut).collect());
        }
        return Some(ways);
    }
    if m > MOST_POINTS {
        return None;
    }
    for a in 0..m {
        for b in a + 1..m {
            add_turned_line(plane, (f, g), points, (a, b), &mut ways);
        }
    }
    ways.sort_unstable();
    ways.dedup();
    Some(ways)
}

fn all_ways(m: usize) -> Vec<Vec<bool>> {
    (0..1u32 << m).map(|mask| (0..m).map(|k| mask >> k & 1 == 1).collect()).collect()
}

/// Add the ways of the lines near the one through points `a` and `b`.
fn add_turned_line(
    plane: &Plane,
    (f, g): (usize, usize),
    points: &[Vec<u32>],
    (a, b): (usize, usize),
    ways: &mut Vec<Vec<bool>>,
) {
    let m = points.len();
    let turns: Vec<Ordering> = (0..m).map(|k| plane.turn(f, g, points[a][0], points[b][0], points[k][0])).collect();
    let on: Vec<usize> = (0..m).filter(|&k| turns[k] == Ordering::Equal).collect();
    for cut in 0..=on.len() {
        for first_goes_left in [false, true] {
            let mut way: Vec<bool> = turns.iter().map(|&t| t == Ordering::Greater).collect();
            for (position, &k) in on.iter().enumerate() {
                way[k] = (position < cut) == first_goes_left;
            }
            ways.push(way.iter().map(|&side| !side).collect());
            ways.push(way);
        }
    }
}

/// Whether a line can part these samples strictly, in exact arithmetic.
///
/// Two disjoint convex polygons lie strictly to both sides of a line along an edge of one of them; where all points lie
/// on one line, their order on it decides.
pub fn can_part(plane: &Plane, (f, g): (usize, usize), left: &[u32], right: &[u32]) -> bool {
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
pub fn hull(plane: &Plane, (f, g): (usize, usize), ids: &[u32]) -> Vec<u32> {
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

    fn plane(points: &[(f64, f64)]) -> Plane {
        let rank = |values: Vec<f64>| -> Vec<u32> {
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            sorted.dedup();
            values.iter().map(|v| sorted.iter().position(|s| s == v).unwrap() as u32).collect()
        };
        let x: Vec<f64> = points.iter().map(|p| p.0).collect();
        let y: Vec<f64> = points.iter().map(|p| p.1).collect();
        let ranks = [rank(x.clone()), rank(y.clone())].concat();
        Plane::new(points.len(), 2, &[x, y].concat(), &ranks)
    }

    fn n_ways(points: &[(f64, f64)]) -> usize {
        let plane = plane(points);
        let ids: Vec<u32> = (0..points.len() as u32).collect();
        let groups = distinct_points(&plane, (0, 1), &ids);
        ways_to_part(&plane, (0, 1), &groups).unwrap().len()
    }

    #[test]
    fn points_in_general_position_come_apart_in_m_times_m_minus_1_plus_2_ways() {
        let points = [(0.0, 0.0), (4.0, 1.0), (1.0, 3.0), (5.0, 6.0), (2.0, 7.5)];
        assert_eq!(n_ways(&points[..3]), 8);
        assert_eq!(n_ways(&points[..4]), 14);
        assert_eq!(n_ways(&points), 22);
    }

    #[test]
    fn points_on_a_line_come_apart_in_2m_ways() {
        let points: Vec<(f64, f64)> = (0..5).map(|k| (f64::from(k), f64::from(2 * k))).collect();
        assert_eq!(n_ways(&points), 10);
    }

    #[test]
    fn a_line_cannot_part_crossing_diagonals_nor_the_middle_from_both_ends() {
        let plane = plane(&[(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0), (0.5, 0.5)]);
        assert!(!can_part(&plane, (0, 1), &[0, 1], &[2, 3]));
        assert!(can_part(&plane, (0, 1), &[0, 2], &[1, 3]));
        assert!(!can_part(&plane, (0, 1), &[0, 1], &[4]));
        assert!(can_part(&plane, (0, 1), &[0, 4], &[1]));
        assert!(can_part(&plane, (0, 1), &[0], &[1, 2, 3, 4]));
    }
}

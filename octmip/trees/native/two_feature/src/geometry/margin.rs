//! The line that keeps farthest from two sets of points: halfway between their convex hulls.

use crate::geometry::hull::hull;
use crate::geometry::line::Line;
use crate::geometry::plane::Plane;

type Point = (f64, f64);

/// The normal of the widest gap between two sets and a point in its middle, in the plane's coordinates.
///
/// Widths are measured with every feature stretched to a range of 1: there the normal is the shortest way from one hull
/// to the other.
pub(crate) fn widest_gap(plane: &Plane, (f, g): (usize, usize), left: &[u32], right: &[u32]) -> Option<(Point, Point)> {
    let (from, to) = shortest_way(plane, (f, g), left, right)?;
    let (a, b) = (plane.stretches[f], plane.stretches[g]);
    let middle = ((from.0 + to.0) / 2.0 / a, (from.1 + to.1) / 2.0 / b);
    Some((((to.0 - from.0) * a, (to.1 - from.1) * b), middle))
}

/// The shortest way from one hull to the other, as its two ends, in stretched coordinates.
///
/// The shortest way between two disjoint convex polygons starts or ends in a corner, so corners against edges suffice.
fn shortest_way(plane: &Plane, (f, g): (usize, usize), left: &[u32], right: &[u32]) -> Option<(Point, Point)> {
    let corners = |ids: &[u32]| -> Vec<Point> {
        let (x, y) = (plane.column(f), plane.column(g));
        let (a, b) = (plane.stretches[f], plane.stretches[g]);
        let stretched = |&i: &u32| (x[i as usize] * a, y[i as usize] * b);
        hull(plane, (f, g), ids).iter().map(stretched).collect()
    };
    let (a, b) = (corners(left), corners(right));
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let mut best: Option<(f64, Point, Point)> = None;
    let mut offer = |from: Point, to: Point| {
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        if best.is_none_or(|(least, ..)| length < least) {
            best = Some((length, from, to));
        }
    };
    for (k, &corner) in a.iter().enumerate() {
        let next = a[(k + 1) % a.len()];
        for (l, &other) in b.iter().enumerate() {
            offer(corner, nearest_on(other, b[(l + 1) % b.len()], corner));
            offer(nearest_on(corner, next, other), other);
        }
    }
    best.map(|(_, from, to)| (from, to))
}

fn nearest_on(a: Point, b: Point, point: Point) -> Point {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    if square == 0.0 {
        return a;
    }
    let part = (((point.0 - a.0) * dx + (point.1 - a.1) * dy) / square).clamp(0.0, 1.0);
    (a.0 + part * dx, a.1 + part * dy)
}

/// The widest-margin line between two sets that a line can part, and its distance from them (in r).
///
/// The line's left side is the set with the smaller `x_f + t x_g`: sides may come out exchanged.
pub(crate) fn widest_line(plane: &Plane, (f, g): (usize, usize), left: &[u32], right: &[u32]) -> Option<(Line, f64)> {
    let (normal, middle) = widest_gap(plane, (f, g), left, right)?;
    let (features, t, r) = if normal.0.abs() >= normal.1.abs() {
        let t = normal.1 / normal.0;
        ((f, g), t, middle.0 + t * middle.1)
    } else {
        let t = normal.0 / normal.1;
        ((g, f), t, middle.1 + t * middle.0)
    };
    if !t.is_finite() {
        return None;
    }
    let (x, y) = (plane.column(features.0), plane.column(features.1));
    let distance =
        left.iter().chain(right).map(|&i| (x[i as usize] + t * y[i as usize] - r).abs()).fold(f64::INFINITY, f64::min);
    Some((Line { features, t, r }, distance))
}

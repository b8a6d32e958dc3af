//! Whether a line parts samples in a given way, in floating point where there is room, in exact arithmetic elsewhere.

use std::collections::HashMap;

use super::cell::{Cell, EPS};
use super::ends::can_part;
use super::margin::widest_line;
use super::plane::Plane;
use super::view::Line;

/// Lines that keep this clear of all samples part them in floating point as they do in exact arithmetic.
pub const THICK: f64 = 2.0 * EPS;

/// What exact arithmetic said of sets of samples that are to go left of a line over two features.
pub(super) type Asked = HashMap<((usize, usize), Vec<u32>), Realised>;

/// Whether a line parts the samples in a given way.
#[derive(Clone, Copy)]
pub(super) enum Realised {
    /// This one does, with room for rounding.
    Line(Line),
    /// One does, but too close to some samples for floating point.
    Thin,
    /// None does, in this cell at least.
    Never,
}

/// Find a line of the cell that parts the open points in this way.
pub(super) fn realise(
    plane: &Plane,
    features: (usize, usize),
    cell: &Cell,
    ids: &[u32],
    (points, way): (&[Vec<u32>], &[bool]),
    asked: &mut Asked,
) -> Realised {
    let side = |wanted: bool| -> Vec<u32> {
        let chosen = points.iter().zip(way).filter(|(_, w)| **w == wanted);
        chosen.map(|(point, _)| point[0]).collect()
    };
    let (distance, t, r) = cell.clearest(plane, features, &side(true), &side(false));
    if distance > THICK {
        return Realised::Line(Line { features, t, r });
    }
    if distance < -THICK {
        return Realised::Never;
    }
    // On the cell's edge, or between samples nearly on one line: all samples decide, in exact arithmetic.
    let (mut left, mut right) = (Vec::new(), Vec::new());
    let (x, y) = (plane.column(features.0), plane.column(features.1));
    cell.sort(x, y, ids, |i, goes_left| {
        if goes_left { &mut left } else { &mut right }.push(i);
    });
    for (point, goes_left) in points.iter().zip(way) {
        if *goes_left { &mut left } else { &mut right }.extend(point);
    }
    left.sort_unstable();
    *asked.entry((features, left)).or_insert_with_key(|(_, left)| part(plane, features, left, &right))
}

fn part(plane: &Plane, features: (usize, usize), left: &[u32], right: &[u32]) -> Realised {
    if !can_part(plane, features, left, right) {
        return Realised::Never;
    }
    match widest_line(plane, features, left, right) {
        Some((line, margin)) if margin > THICK => Realised::Line(line),
        _ => Realised::Thin,
    }
}

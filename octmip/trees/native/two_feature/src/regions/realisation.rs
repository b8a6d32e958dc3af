//! Realisation of dichotomies by lines: in floating point where there is room, in exact arithmetic elsewhere.

use std::collections::HashMap;

use crate::geometry::hull::can_part;
use crate::geometry::line::{EPS, Line};
use crate::geometry::margin::widest_line;
use crate::geometry::plane::Plane;
use crate::regions::region::Region;

/// Lines that keep this clear of all samples part them in floating point as they do in exact arithmetic.
pub(crate) const CLEARANCE: f64 = 2.0 * EPS;

/// Answers of exact arithmetic about sets of samples that are to go left of a line over two features.
pub(crate) type Separability = HashMap<((usize, usize), Vec<u32>), Realisation>;

/// The realisation of a dichotomy by a line.
#[derive(Clone, Copy)]
pub(crate) enum Realisation {
    /// A line that makes the dichotomy with room for rounding.
    Line(Line),
    /// Numerically undecided: a line makes it, but too close to some samples for floating point.
    Undecided,
    /// No line makes it, in this region at least.
    Never,
}

/// Find a line of the region that makes this dichotomy of the open points.
pub(crate) fn realise(
    plane: &Plane,
    features: (usize, usize),
    region: &Region,
    ids: &[u32],
    (points, dichotomy): (&[Vec<u32>], &[bool]),
    separability: &mut Separability,
) -> Realisation {
    let side = |wanted: bool| -> Vec<u32> {
        let chosen = points.iter().zip(dichotomy).filter(|(_, w)| **w == wanted);
        chosen.map(|(point, _)| point[0]).collect()
    };
    let (distance, t, r) = region.clearest(plane, features, &side(true), &side(false));
    if distance > CLEARANCE {
        return Realisation::Line(Line { features, t, r });
    }
    if distance < -CLEARANCE {
        return Realisation::Never;
    }
    // On the region's edge, or between samples nearly on one line: all samples decide, in exact arithmetic.
    let (mut left, mut right) = (Vec::new(), Vec::new());
    let (x, y) = (plane.column(features.0), plane.column(features.1));
    region.sort(x, y, ids, |i, goes_left| {
        if goes_left { &mut left } else { &mut right }.push(i);
    });
    for (point, goes_left) in points.iter().zip(dichotomy) {
        if *goes_left { &mut left } else { &mut right }.extend(point);
    }
    left.sort_unstable();
    *separability.entry((features, left)).or_insert_with_key(|(_, left)| part(plane, features, left, &right))
}

fn part(plane: &Plane, features: (usize, usize), left: &[u32], right: &[u32]) -> Realisation {
    if !can_part(plane, features, left, right) {
        return Realisation::Never;
    }
    match widest_line(plane, features, left, right) {
        Some((line, margin)) if margin > CLEARANCE => Realisation::Line(line),
        _ => Realisation::Undecided,
    }
}

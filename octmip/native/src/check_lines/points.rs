//! Points and lines, exactly: coordinates without rounding, signs of sums of products, the ways to part a few points.

use crate::check::Refusal;
use crate::problem::Problem;

/// Coordinates below this (other than 0) could underflow in a product of two and its rounding.
const LEAST: f64 = 1e-135;

/// The coordinates of every sample by feature, all within -1 and 1; last, a column of zeros for axis-aligned splits.
///
/// Each feature is moved by a constant and divided by a power of two, which keeps the lines, and it is checked that
/// nothing was rounded.
pub(super) fn coordinates(q: &Problem) -> Result<Vec<Vec<f64>>, Refusal> {
    let ranks = || q.ranks.iter().map(|&rank| f64::from(rank)).collect();
    let values: Vec<f64> = q.values_by_feature().unwrap_or_else(ranks);
    let mut columns = Vec::with_capacity(q.p + 1);
    for (f, values) in values.chunks_exact(q.n).enumerate() {
        let least = values.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let most = values.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        // Between zero and all the values, in units of the last place of the largest.
        let (near, far) = if least > 0.0 { (least, most) } else { (most.min(0.0), least) };
        let unit = binade(far) * f64::EPSILON;
        let origin = if near == 0.0 { 0.0 } else { (near / unit).trunc() * unit };
        let moved: Vec<f64> = values.iter().map(|v| v - origin).collect();
        let half = binade(moved.iter().fold(0.0, |a: f64, b| a.max(b.abs())));
        let column: Vec<f64> = moved.iter().map(|d| d / half / 2.0).collect();
        let is_exact = |((v, d), u): ((&f64, &f64), &f64)| {
            let back = d - v;
            (v - (d - back)) + (-origin - back) == 0.0
                && u * 2.0 * half == *d
                && (*u == 0.0 || (LEAST..1.0).contains(&u.abs()))
        };
        if !values.iter().zip(&moved).zip(&column).all(is_exact) {
            let reason = format!("feature {f} holds values too far apart for exact coordinates");
            return Err(Refusal(0, reason));
        }
        columns.push(column);
    }
    columns.push(vec![0.0; q.n]);
    Ok(columns)
}

/// The largest power of two up to the size of a number (1 for 0).
fn binade(number: f64) -> f64 {
    match number.abs() {
        0.0 => 1.0,
        small if small < f64::MIN_POSITIVE => f64::MIN_POSITIVE,
        size => f64::from_bits(size.to_bits() & (0x7ff << 52)),
    }
}

/// A number with the sign of the exact sum of some products.
///
/// Every product is itself rounded plus a remainder that fused arithmetic finds exactly. The sum is kept as numbers that
/// do not overlap, from small to large: a new one is added to each in turn, the rounding staying behind (Shewchuk 1997).
fn sign<const N: usize>(products: [(f64, f64); N]) -> f64 {
    let rounded: f64 = products.iter().map(|(a, b)| a * b).sum();
    if rounded.abs() > 1e-12 {
        return rounded; // factors are at most 1 in size, so rounding is below 1e-14
    }
    let mut parts: Vec<f64> = Vec::with_capacity(2 * N);
    for (a, b) in products {
        let product = a * b;
        for mut carry in [a.mul_add(b, -product), product] {
            for part in &mut parts {
                let sum = carry + *part;
                let added = sum - carry;
                *part = (carry - (sum - added)) + (*part - added);
                carry = sum;
            }
            parts.push(carry);
        }
    }
    parts.into_iter().rev().find(|&part| part != 0.0).unwrap_or(0.0)
}

/// All ways in which a line x + t y = r with t0 <= t <= t1 can part different points: true = at or below it.
///
/// Take a way and the values of t that allow it, an interval. If t0 is in it, the way is a prefix of the points in their
/// order at t0. If not, it begins where a point below and one above meet in value: there the line runs through both, the
/// points off it go where they lie, and those on it come apart just after by y, the smaller below.
pub(crate) fn ways(x: &[f64], y: &[f64], points: &[u32], t0: f64, t1: f64) -> Vec<Vec<bool>> {
    let (m, x, y) = (points.len(), |k: usize| x[points[k] as usize], |k: usize| y[points[k] as usize]);
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|&i, &j| {
        let difference = sign([(x(i), 1.0), (-x(j), 1.0), (t0, y(i)), (-t0, y(j))]);
        difference.total_cmp(&0.0).then(y(i).total_cmp(&y(j)))
    });
    let mut found: Vec<Vec<bool>> = Vec::new();
    let mut add_prefixes = |way: &[bool], order: &[usize]| {
        let mut way = way.to_vec();
        found.push(way.clone());
        for &k in order {
            way[k] = true;
            found.push(way.clone());
        }
    };
    add_prefixes(&vec![false; m], &order);
    for (a, b) in (0..m).flat_map(|a| (0..m).map(move |b| (a, b))) {
        let t = -(x(b) - x(a)) / (y(b) - y(a));
        // Rounding moves t by less than 1e-14.
        if y(a) < y(b) && t0 - 1e-12 <= t && t <= t1 + 1e-12 {
            let side: Vec<f64> = (0..m)
                .map(|k| {
                    let (first, second) = ((x(k), y(b)), (-x(k), y(a)));
                    let (third, fourth) = ((-x(a), y(b)), (-x(b), y(k)));
                    sign([first, second, third, fourth, (x(b), y(a)), (x(a), y(k))])
                })
                .collect();
            let mut on: Vec<usize> = (0..m).filter(|&k| side[k] == 0.0).collect();
            on.sort_by(|&i, &j| y(i).total_cmp(&y(j)));
            add_prefixes(&side.iter().map(|&s| s < 0.0).collect::<Vec<_>>(), &on);
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_right_to_the_last_bit() {
        let next = 1.0 - f64::EPSILON / 2.0;
        assert!(sign([(next, next), (-1.0, 1.0), (f64::EPSILON, 1.0)]) > 0.0);
        assert_eq!(sign([(next, next), (-next, next), (0.0, 1.0)]), 0.0);
        assert!(sign([(1e-130, 1e-130), (-1e-130, 1.1e-130)]) < 0.0);
    }

    #[test]
    fn the_ways_of_three_points_are_those_of_their_orders() {
        let (x, y) = ([0.0, 0.5, 0.25], [0.0, 0.0, 0.5]);
        // Order 0 2 1 up to t = .5, where 2 passes 1: four prefixes, and one more beyond.
        assert_eq!(ways(&x, &y, &[0, 1, 2], -0.25, 0.25).len(), 4);
        assert_eq!(ways(&x, &y, &[0, 1, 2], -0.25, 1.0).len(), 5);
        // On one line at t = -1/2: before it 2 1 0 in order of value, after it 0 1 2.
        let (x, y) = ([0.0, 0.25, 0.5], [0.0, 0.5, 1.0]);
        assert_eq!(ways(&x, &y, &[0, 1, 2], -1.0, 1.0).len(), 6);
    }
}

//! The dichotomies of points by a line.

use std::cmp::Ordering;

use super::plane::Plane;

/// Most points on one line whose dichotomies are listed: each is a list of as many entries, in all half a gigabyte.
pub(super) const MOST_ON_LINE: usize = 1 << 14;
impl Plane<'_> {
    /// One sample of each different point, the first; None if these are more than `most`.
    pub(super) fn few_points(&self, ids: &[u32], most: usize) -> Option<Vec<u32>> {
        let mut points: Vec<u32> = Vec::new();
        for &i in ids {
            if !points.iter().any(|&p| self.is_same(p, i)) {
                if points.len() == most {
                    return None;
                }
                points.push(i);
            }
        }
        Some(points)
    }

    /// One sample of each different point, the first, if their dichotomies are few: not more than `most` points, or all
    /// of them on one line and no more than `MOST_ON_LINE`.
    pub fn end_points(&self, ids: &[u32], most: usize) -> Option<Vec<u32>> {
        let mut points = ids.to_vec();
        points.sort_by(|&i, &j| self.along(i, j).then(i.cmp(&j)));
        points.dedup_by(|i, j| self.is_same(*i, *j));
        points.sort_unstable();
        let is_line = || points.len() <= MOST_ON_LINE && self.is_line(&points);
        (points.len() <= most || is_line()).then_some(points)
    }

    /// For each sample the place of its point.
    pub fn places(&self, points: &[u32], ids: &[u32]) -> Vec<usize> {
        ids.iter().map(|&i| points.iter().position(|&p| self.is_same(p, i)).unwrap_or(0)).collect()
    }

    /// All dichotomies of different points by a line x + t y = r with t0 <= t <= t1: true = at or below it.
    ///
    /// Take a dichotomy and the values of t that allow it, an interval. If t0 is in it, the dichotomy is a prefix of
    /// the points in their order at t0. If not, it begins where a point below and one above meet in value: there the
    /// line runs through both, the points off it go where they lie, and those on it come apart just after by y, the
    /// smaller below. Points on one line all meet at one t: their order at t1 is the other one.
    pub fn dichotomies(&self, points: &[u32], t0: f64, t1: f64) -> Vec<Vec<bool>> {
        let m = points.len();
        let order_at = |t: f64| {
            let mut order: Vec<usize> = (0..m).collect();
            order.sort_by(|&i, &j| {
                self.order_at(t, points[i], points[j]).then_with(|| self.upward(points[i], points[j]))
            });
            order
        };
        let mut found: Vec<Vec<bool>> = Vec::new();
        let mut add_prefixes = |dichotomy: &[bool], order: &[usize]| {
            let mut dichotomy = dichotomy.to_vec();
            found.push(dichotomy.clone());
            for &k in order {
                dichotomy[k] = true;
                found.push(dichotomy.clone());
            }
        };
        add_prefixes(&vec![false; m], &order_at(t0));
        if self.is_line(points) {
            add_prefixes(&vec![false; m], &order_at(t1));
        } else {
            for (a, b) in (0..m).flat_map(|a| (0..m).map(move |b| (a, b))) {
                let is_upward = self.upward(points[a], points[b]) == Ordering::Less;
                if is_upward && self.is_crossing(points[a], points[b], t0, t1) {
                    let turns: Vec<_> = points.iter().map(|&c| self.turn(points[a], points[b], c)).collect();
                    let mut on: Vec<usize> = (0..m).filter(|&k| turns[k] == Ordering::Equal).collect();
                    on.sort_by(|&i, &j| self.upward(points[i], points[j]));
                    let below: Vec<bool> = turns.iter().map(|&turn| turn == Ordering::Greater).collect();
                    add_prefixes(&below, &on);
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

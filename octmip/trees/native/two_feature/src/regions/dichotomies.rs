//! Ends of the splitting of a region: few open points, or open points on one line, and their dichotomies by a line.

use std::cmp::Ordering;

use crate::geometry::plane::Plane;
use crate::regions::region::Region;

/// Open points on one line beyond this area count as collinear and are parted in exact arithmetic.
const FLAT: f64 = 1.0 / (1u64 << 40) as f64;
/// More points than this are parted only where they are exactly collinear.
const MOST_POINTS: usize = 24;

/// The end of a region, or that it has to be split.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum End {
    /// Split it.
    Split,
    /// All dichotomies of the open points (groups of equal samples) by a line: true = left.
    Parts {
        /// Samples at each point.
        points: Vec<Vec<u32>>,
        /// The side of each point.
        dichotomies: Dichotomies,
    },
    /// Too small to split, too crowded to part: its bound has to stand.
    Stuck,
}

/// Ways to part points by a line: for each the points that go left.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Dichotomies {
    /// So many points in their order along a line: the first few of them, and all but these.
    AlongLine(usize),
    /// Any others.
    Listed(Vec<Vec<bool>>),
}

impl Dichotomies {
    /// One after the other.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Vec<bool>> {
        (0..self.len()).map(|at| self.at(at))
    }

    fn len(&self) -> usize {
        match self {
            Self::AlongLine(m) => 2 * m,
            Self::Listed(dichotomies) => dichotomies.len(),
        }
    }

    fn at(&self, at: usize) -> Vec<bool> {
        match self {
            Self::AlongLine(m) => (0..*m).map(|k| (k < at / 2) == at.is_multiple_of(2)).collect(),
            Self::Listed(dichotomies) => dichotomies[at].clone(),
        }
    }

    /// The dichotomies whose points going left, of these tallies, `is_wanted`.
    ///
    /// Along a line each takes one step from the last, and not one for every point.
    pub(crate) fn wanted<'a>(
        &'a self,
        tallies: &'a [Vec<i64>],
        lanes: usize,
        mut is_wanted: impl FnMut(&[i64]) -> bool + 'a,
    ) -> impl Iterator<Item = Vec<bool>> + 'a {
        let mut first = vec![0; lanes];
        let all: Vec<i64> = (0..lanes).map(|lane| tallies.iter().map(|tally| tally[lane]).sum()).collect();
        (0..self.len())
            .filter(move |&at| {
                let left: Vec<i64> = match self {
                    Self::AlongLine(_) if at.is_multiple_of(2) => {
                        if at > 0 {
                            first.iter_mut().zip(&tallies[at / 2 - 1]).for_each(|(sum, more)| *sum += more);
                        }
                        first.clone()
                    }
                    Self::AlongLine(_) => all.iter().zip(&first).map(|(all, first)| all - first).collect(),
                    Self::Listed(dichotomies) => {
                        let chosen = || tallies.iter().zip(&dichotomies[at]).filter(|(_, left)| **left);
                        (0..lanes).map(|lane| chosen().map(|(tally, _)| tally[lane]).sum()).collect()
                    }
                };
                is_wanted(&left)
            })
            .map(|at| self.at(at))
    }
}

/// The end of a region, if its splitting ends here.
pub(crate) fn end_of(plane: &Plane, features: (usize, usize), region: &Region, open: &[u32]) -> End {
    let tiny = !region.is_wide() && !region.is_high();
    // On an axis all points lie on one line, and splitting separates them.
    let is_axis = features.1 == plane.p;
    if open.len() > 3 && !tiny && (is_axis || !is_flat(plane, features, open)) {
        return End::Split;
    }
    let points = distinct_points(plane, features, open);
    match dichotomies_of(plane, features, &points) {
        Some(dichotomies) => End::Parts { points, dichotomies },
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
pub(crate) fn distinct_points(plane: &Plane, (f, g): (usize, usize), open: &[u32]) -> Vec<Vec<u32>> {
    let mut sorted = open.to_vec();
    sorted.sort_by_key(|&i| (plane.point(f, g, i), i));
    sorted.chunk_by(|&i, &j| plane.point(f, g, i) == plane.point(f, g, j)).map(<[u32]>::to_vec).collect()
}

/// All dichotomies of these points (sorted by coordinates) by a line, and perhaps some that no line makes.
///
/// Points on one line come apart as a prefix and a suffix in their order along it. In general, every dichotomy is that
/// of a line through two of the points, turned a little about a place between or beyond the points on it.
fn dichotomies_of(plane: &Plane, (f, g): (usize, usize), points: &[Vec<u32>]) -> Option<Dichotomies> {
    let m = points.len();
    let at = |k: usize| points[k][0];
    if m <= 2 {
        return Some(Dichotomies::Listed(all_dichotomies(m)));
    }
    let mut collinear = true;
    for k in 1..m - 1 {
        collinear &= plane.turn(f, g, at(0), at(m - 1), at(k)) == Ordering::Equal;
    }
    if collinear {
        return Some(Dichotomies::AlongLine(m));
    }
    if m > MOST_POINTS {
        return None;
    }
    let mut dichotomies: Vec<Vec<bool>> = Vec::new();
    for a in 0..m {
        for b in a + 1..m {
            add_turned_line(plane, (f, g), points, (a, b), &mut dichotomies);
        }
    }
    dichotomies.sort_unstable();
    dichotomies.dedup();
    Some(Dichotomies::Listed(dichotomies))
}

fn all_dichotomies(m: usize) -> Vec<Vec<bool>> {
    (0..1u32 << m).map(|mask| (0..m).map(|k| mask >> k & 1 == 1).collect()).collect()
}

/// Add the dichotomies of the lines near the one through points `a` and `b`.
fn add_turned_line(
    plane: &Plane,
    (f, g): (usize, usize),
    points: &[Vec<u32>],
    (a, b): (usize, usize),
    dichotomies: &mut Vec<Vec<bool>>,
) {
    let m = points.len();
    let turns: Vec<Ordering> = (0..m).map(|k| plane.turn(f, g, points[a][0], points[b][0], points[k][0])).collect();
    let on: Vec<usize> = (0..m).filter(|&k| turns[k] == Ordering::Equal).collect();
    for cut in 0..=on.len() {
        for first_goes_left in [false, true] {
            let mut dichotomy: Vec<bool> = turns.iter().map(|&t| t == Ordering::Greater).collect();
            for (position, &k) in on.iter().enumerate() {
                dichotomy[k] = (position < cut) == first_goes_left;
            }
            dichotomies.push(dichotomy.iter().map(|&side| !side).collect());
            dichotomies.push(dichotomy);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn n_dichotomies(points: &[(f64, f64)]) -> usize {
        let plane = Plane::of_points(points);
        let ids: Vec<u32> = (0..points.len() as u32).collect();
        let groups = distinct_points(&plane, (0, 1), &ids);
        dichotomies_of(&plane, (0, 1), &groups).unwrap().len()
    }

    #[test]
    fn points_in_general_position_have_m_times_m_minus_1_plus_2_dichotomies() {
        let points = [(0.0, 0.0), (4.0, 1.0), (1.0, 3.0), (5.0, 6.0), (2.0, 7.5)];
        assert_eq!(n_dichotomies(&points[..3]), 8);
        assert_eq!(n_dichotomies(&points[..4]), 14);
        assert_eq!(n_dichotomies(&points), 22);
    }

    #[test]
    fn points_on_a_line_have_2m_dichotomies() {
        let points: Vec<(f64, f64)> = (0..5).map(|k| (f64::from(k), f64::from(2 * k))).collect();
        assert_eq!(n_dichotomies(&points), 10);
    }

    #[test]
    fn what_goes_left_is_counted_for_every_dichotomy() {
        let tallies: Vec<Vec<i64>> = (0..5).map(|k| vec![k * k, 3 - k, 1]).collect();
        for dichotomies in [Dichotomies::AlongLine(5), Dichotomies::Listed(all_dichotomies(5))] {
            let mut lefts = Vec::new();
            let all = dichotomies.wanted(&tallies, 3, |left| {
                lefts.push(left.to_vec());
                true
            });
            let all: Vec<Vec<bool>> = all.collect();
            assert_eq!(all, dichotomies.iter().collect::<Vec<_>>());
            for (dichotomy, left) in all.iter().zip(&lefts) {
                let chosen = || tallies.iter().zip(dichotomy).filter(|(_, left)| **left);
                assert_eq!(
                    *left,
                    (0..3).map(|lane| chosen().map(|(tally, _)| tally[lane]).sum()).collect::<Vec<i64>>()
                );
            }
        }
    }
}

//! Separation of two sets of samples by a line, decided exactly.

use std::cmp::Ordering;

use super::plane::Plane;

impl Plane<'_> {
    /// Whether a line has one set strictly on one side and the other strictly on the other.
    ///
    /// Two disjoint convex polygons lie strictly to both sides of a line along an edge of one of them, moved a little;
    /// where all points lie on one line, their order on it decides.
    pub fn can_part(&self, one: &[u32], other: &[u32]) -> bool {
        let (a, b) = (self.corners(one), self.corners(other));
        if a.is_empty() || b.is_empty() {
            return true;
        }
        if self.is_line(&self.spread(&a, &b)) {
            let ends = |ids: &[u32]| [ids[0], ids[ids.len() - 1]];
            let ([a0, a1], [b0, b1]) = (ends(&self.in_order(&a)), ends(&self.in_order(&b)));
            return self.along(a1, b0) == Ordering::Less || self.along(b1, a0) == Ordering::Less;
        }
        self.has_edge_before(&a, &b) || self.has_edge_before(&b, &a)
    }

    /// The corners of both polygons, two different points first.
    fn spread(&self, a: &[u32], b: &[u32]) -> Vec<u32> {
        let mut all = [a, b].concat();
        if let Some(k) = (1..all.len()).find(|&k| !self.is_same(all[0], all[k])) {
            all.swap(1, k);
        }
        all
    }

    fn in_order(&self, ids: &[u32]) -> Vec<u32> {
        let mut sorted = ids.to_vec();
        sorted.sort_by(|&i, &j| self.along(i, j));
        sorted.dedup_by(|i, j| self.is_same(*i, *j));
        sorted
    }

    /// The corners of the convex hull, counter-clockwise; of points on one line the two ends.
    fn corners(&self, ids: &[u32]) -> Vec<u32> {
        let sorted = self.in_order(ids);
        if sorted.len() < 3 {
            return sorted;
        }
        let mut corners = self.lower_chain(sorted.iter());
        let upper = self.lower_chain(sorted.iter().rev());
        corners.pop();
        corners.extend(&upper[..upper.len() - 1]);
        corners
    }

    fn lower_chain<'i>(&self, ids: impl Iterator<Item = &'i u32>) -> Vec<u32> {
        let mut chain: Vec<u32> = Vec::new();
        for &i in ids {
            while let [.., a, b] = chain[..]
                && self.turn(a, b, i) != Ordering::Greater
            {
                chain.pop();
            }
            chain.push(i);
        }
        chain
    }

    /// Whether some edge of the polygon `a` (a segment has two) has all of `b` strictly on its outer side.
    fn has_edge_before(&self, a: &[u32], b: &[u32]) -> bool {
        let edges = a.iter().zip(a.iter().cycle().skip(1)).filter(|_| a.len() > 1);
        edges.into_iter().any(|(&from, &to)| b.iter().all(|&c| self.turn(from, to, c) == Ordering::Less))
    }
}

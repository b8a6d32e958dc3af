//! The cuts of one feature of a node, and what the solved ones prove of those between them.
//!
//! With `e` the cost of the best tree of the child's depth, `r` the same where leaves may be of any size, `c` the least
//! error of as many constants as the child has leaves, and L(k), R(k) the sides of cut k, for a < k < b:
//!
//! * `e(L(k)) >= r(L(a)) + c(a..k)` and `e(R(k)) >= r(R(b)) + c(k..b)`: growing;
//! * `e(L(k)) >= e(L(b)) - range(k..b)` and `e(R(k)) >= e(R(a)) - range(a..k)`: shrinking.
//!
//! Left bounds grow with k and right ones shrink, so that the first and the last of a run of cuts bound all of it.

use crate::regression::grid::Samples;

/// A solved cut: bounds of its sides, and those for leaves of any size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Known {
    /// Samples on the left.
    pub k: usize,
    /// Bounds of the left and the right side.
    pub strict: [i64; 2],
    /// The same where leaves may be of any size.
    pub relaxed: [i64; 2],
}

/// The cuts of a feature.
#[derive(Debug)]
pub struct Cuts<'a> {
    q: &'a Samples,
    f: usize,
    order: &'a [u32],
    /// Leaves of a child.
    n_leaves: usize,
    /// What the first samples may cost at most.
    ranges: Vec<i64>,
}

impl<'a> Cuts<'a> {
    /// The cuts of a feature of a node: its samples in the order of the feature and in that of their targets.
    pub fn new(q: &'a Samples, f: usize, order: &'a [u32], set: &[u32], child_depth: usize) -> Self {
        let target = |i: Option<&u32>| i.map_or(0, |&i| q.targets[i as usize]);
        let (low, high) = (target(set.first()), target(set.last()));
        let (mut ranges, mut sum) = (vec![0], 0);
        for &i in order {
            sum += q.range(i as usize, low, high);
            ranges.push(sum);
        }
        Self { q, f, order, n_leaves: 1 << child_depth.min(20), ranges }
    }

    /// What is known before any cut is solved: all samples on one side cost at least that.
    pub fn ends(&self, strict: i64, relaxed: i64) -> [Known; 2] {
        let n = self.order.len();
        [
            Known { k: 0, strict: [0, strict], relaxed: [0, relaxed] },
            Known { k: n, strict: [strict, 0], relaxed: [relaxed, 0] },
        ]
    }

    /// What a sample may cost at most, summed over those between a cut and the farther of two others.
    pub fn slack(&self, (a, b): (&Known, &Known), k: usize) -> i64 {
        (self.ranges[k] - self.ranges[a.k]).max(self.ranges[b.k] - self.ranges[k])
    }

    /// Lower bound of a side (0 left, 1 right) at a cut between two solved ones.
    fn side(&self, (a, b): (&Known, &Known), k: usize, side: usize) -> i64 {
        let (near, far) = if side == 0 { (a, b) } else { (b, a) };
        let between = |other: usize| (other.min(k), other.max(k));
        let (from, to) = between(near.k);
        let grown = near.relaxed[side] + self.q.clusters(&self.order[from..to], self.n_leaves);
        let (from, to) = between(far.k);
        grown.max(far.strict[side] - (self.ranges[to] - self.ranges[from]))
    }

    /// Whether what is known of two solved cuts shows that the children of all between cost `target` or more.
    fn is_closed(&self, (a, b): (&Known, &Known), target: i64) -> bool {
        let grown = a.relaxed[0] + b.relaxed[1];
        let shrunk = b.strict[0] + a.strict[1] - (self.ranges[b.k] - self.ranges[a.k]);
        grown.max(shrunk) >= target || grown + self.q.clusters(&self.order[a.k..b.k], 2 * self.n_leaves) >= target
    }

    /// A cut between two solved ones whose children may cost less than `target`, None where that is ruled out: the
    /// first one, or one near the middle.
    pub fn open(&self, ends: (&Known, &Known), target: i64, from_middle: bool) -> Option<usize> {
        let (first, last) = (ends.0.k + 1, ends.1.k.saturating_sub(1));
        if first > last || self.is_closed(ends, target) {
            return None;
        }
        let middle = first + (last - first) / 2;
        if !from_middle {
            return self.open_within(ends, target, (first, last), false);
        }
        let right = self.open_within(ends, target, (middle, last), false);
        if right == Some(middle) || middle == first {
            return right;
        }
        let nearest = right.map_or(first, |k| (2 * middle + 1).saturating_sub(k).max(first));
        let left = (nearest < middle).then(|| self.open_within(ends, target, (nearest, middle - 1), true)).flatten();
        left.or(right)
    }

    fn open_within(
        &self,
        ends: (&Known, &Known),
        target: i64,
        (first, last): (usize, usize),
        from_end: bool,
    ) -> Option<usize> {
        if self.side(ends, first, 0) + self.side(ends, last, 1) >= target {
            return None;
        }
        if first == last {
            return self.q.is_cut(self.f, self.order, first).then_some(first);
        }
        let middle = first + (last - first) / 2;
        let halves = [(first, middle), (middle + 1, last)];
        let order = if from_end { [1, 0] } else { [0, 1] };
        order.iter().find_map(|&half| self.open_within(ends, target, halves[half], from_end))
    }
}

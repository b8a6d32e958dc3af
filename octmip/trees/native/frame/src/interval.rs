//! Open cuts of a feature between two that are solved: what the searches of classes and of numbers share.
//!
//! Both bound the children of an open cut k between the solved cuts a and b by what is known of a and b. The bounds of
//! left children grow with k and those of right ones shrink, whatever the loss: so both ends of a run of cuts bound all
//! cuts between, and a run is searched by halves. How a bound is found is each loss's own.

/// Cuts `low..=high` between the solved cuts `a` and `b` are open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Interval {
    /// First open cut.
    pub low: usize,
    /// Last open cut.
    pub high: usize,
    /// Solved cut before.
    pub a: usize,
    /// Solved cut after.
    pub b: usize,
}

impl Interval {
    /// All cuts between two solved ones, None when there are none.
    pub fn between(a: usize, b: usize) -> Option<Self> {
        (a + 1 < b).then(|| Self { low: a + 1, high: b - 1, a, b })
    }

    /// The open cuts on both sides of one that was solved.
    #[inline]
    pub fn halves(self, k: usize) -> [Option<Self>; 2] {
        let Self { low, high, a, b } = self;
        [(low < k).then(|| Self { low, high: k - 1, a, b: k }), (high > k).then(|| Self { low: k + 1, high, a: k, b })]
    }

    /// The open cut nearest to `middle` that is bounded by less than `target`; `least` bounds the cuts from one to
    /// another.
    #[inline]
    pub fn nearest<C: PartialOrd + Copy>(
        self,
        middle: usize,
        target: C,
        least: impl Fn(usize, usize) -> C,
    ) -> Option<usize> {
        if least(middle, middle) < target {
            return Some(middle);
        }
        let right = survivor((middle, self.high), target, false, &least);
        // Only what is nearer to the middle than that.
        let nearest = right.map_or(self.low, |k| (2 * middle + 1).saturating_sub(k).max(self.low));
        let left = (nearest < middle).then(|| survivor((nearest, middle - 1), target, true, &least)).flatten();
        left.or(right)
    }
}

/// The first cut of `first..=last` (or the last one) whose bound stays below `target`.
fn survivor<C: PartialOrd + Copy>(
    (first, last): (usize, usize),
    target: C,
    from_end: bool,
    least: &impl Fn(usize, usize) -> C,
) -> Option<usize> {
    if least(first, last) >= target {
        return None;
    }
    if first == last {
        return Some(first);
    }
    let middle = first + (last - first) / 2;
    let halves = [(first, middle), (middle + 1, last)];
    let order = if from_end { [1, 0] } else { [0, 1] };
    order.iter().find_map(|&half| survivor(halves[half], target, from_end, least))
}

/// An open interval of the root: the least bound comes first, then the first feature, then the first cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Open<B> {
    /// Of its trees.
    pub bound: B,
    /// Of its feature, in the order in which they are searched.
    pub place: usize,
    /// The cuts.
    pub interval: Interval,
}

/// Part lists of `len` ids each, one after the other: those that are not marked to the left, `k` of each list.
#[inline]
pub fn part<'a>(
    n_lists: usize,
    (len, k): (usize, usize),
    list: impl Fn(usize) -> &'a [u32],
    marks: &[bool],
    [left, right]: [&mut Vec<u32>; 2],
) {
    for (lists, size) in [(&mut *left, k), (&mut *right, len - k)] {
        lists.resize(n_lists * size + 1, 0); // one more: the branchless partition writes ahead
    }
    for g in 0..n_lists {
        let (mut to_left, mut to_right) = (g * k, g * (len - k));
        for &i in list(g) {
            let is_right = marks[i as usize];
            left[to_left] = i;
            right[to_right] = i;
            to_left += usize::from(!is_right);
            to_right += usize::from(is_right);
        }
    }
    for (lists, size) in [(left, k), (right, len - k)] {
        lists.truncate(n_lists * size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cut_nearest_the_middle_is_the_one_that_a_look_at_all_of_them_finds() {
        for seed in 0..2000 {
            let rng = &mut fastrand::Rng::with_seed(seed);
            let n = rng.usize(1..12);
            let (mut left, mut right) = (vec![0i64], vec![0i64]);
            for _ in 0..n {
                left.push(left[left.len() - 1] + rng.i64(0..4));
                right.push(right[right.len() - 1] + rng.i64(0..4));
            }
            right.reverse();
            let interval = Interval::between(0, n + 1).expect("cuts");
            let (middle, target) = (rng.usize(1..=n), rng.i64(0..20));
            let least = |first: usize, last: usize| left[first - 1] + right[last];
            let is_open = |k: &usize| left[*k - 1] + right[*k] < target;
            let expected = (1..=n).filter(is_open).map(|k| k.abs_diff(middle)).min();
            assert_eq!(interval.nearest(middle, target, least).map(|k| k.abs_diff(middle)), expected, "seed {seed}");
        }
    }

    #[test]
    fn halves_hold_every_open_cut_but_the_solved_one() {
        let interval = Interval { low: 3, high: 7, a: 1, b: 9 };
        let [left, right] = interval.halves(5);
        assert_eq!(left, Some(Interval { low: 3, high: 4, a: 1, b: 5 }));
        assert_eq!(right, Some(Interval { low: 6, high: 7, a: 5, b: 9 }));
        assert_eq!(interval.halves(3)[0], None);
        assert_eq!(interval.halves(7)[1], None);
        assert_eq!(Interval::between(4, 5), None);
    }
}

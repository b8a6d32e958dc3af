//! Sums along a feature for the bound of mixed labels.

use crate::samples::Samples;
use crate::samples::label_sets::WIDTH;
use crate::view::View;

/// All bits of one lane. A count is added to all lanes at once, though one changes: the whole vector is read back right
/// away, and would have to wait for a single lane.
const LANE: [[i32; WIDTH]; WIDTH] = {
    let mut masks = [[0; WIDTH]; WIDTH];
    let mut lane = 0;
    while lane < WIDTH {
        masks[lane][lane] = -1;
        lane += 1;
    }
    masks
};

/// Vectors of a feature's sums at most: more take a tenth of a second and 64 MB a feature before the first node.
const MOST_VECTORS: usize = 1 << 21;

/// What is summed.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum Counted {
    /// Nothing: no bound.
    #[default]
    Nothing,
    /// Cost range of each label, where samples gain in one label each.
    Labels,
    /// Cost under each set of labels.
    Sets,
}

/// Sums left of each cut of a feature.
#[derive(Debug, Default)]
pub(super) struct MixedLabels {
    counted: Counted,
    n_leaves: usize,
    /// `width` vectors a cut; only ever grown.
    prefix: Vec<[i32; WIDTH]>,
    width: usize,
}

impl MixedLabels {
    /// Sum along a list with cuts at these positions, if the bound is wanted and says anything.
    pub(super) fn lay(&mut self, samples: &Samples, view: &View, f: usize, n_leaves: usize, positions: &[u32]) {
        self.n_leaves = n_leaves;
        let sets = samples.label_sets(n_leaves).filter(|_| view.total_range < i64::from(i32::MAX));
        if let Some(sets) = sets {
            (self.counted, self.width) = (Counted::Sets, sets.width());
        } else if samples.is_single && samples.n_labels > n_leaves && view.total_range < i64::from(i32::MAX) {
            (self.counted, self.width) = (Counted::Labels, samples.n_labels.div_ceil(WIDTH));
        } else {
            self.counted = Counted::Nothing;
            return;
        }
        if positions.len() * self.width > MOST_VECTORS {
            self.counted = Counted::Nothing;
            return;
        }
        self.prefix.resize(self.prefix.len().max(positions.len() * self.width), [0; WIDTH]);
        let profile = |i: u32| samples.profile[i as usize] as usize;
        match sets {
            Some(sets) => self.count(view.list(f), positions, |i, part| {
                let multiplicity = samples.multiplicity[i as usize] as i32;
                sets.costs_of(profile(i))[part].map(|cost| multiplicity * cost)
            }),
            None => self.count(view.list(f), positions, |i, part| {
                let range = if profile(i) / WIDTH == part { samples.range_of(i) as i32 } else { 0 };
                LANE[profile(i) % WIDTH].map(|mask| mask & range)
            }),
        }
    }

    /// No sums: the bound is 0.
    pub(super) fn leave_out(&mut self) {
        self.counted = Counted::Nothing;
    }

    /// Whether there is no bound.
    pub(super) fn is_nothing(&self) -> bool {
        self.counted == Counted::Nothing
    }

    /// Sum what each sample adds to a vector, vector after vector.
    #[inline(always)]
    fn count(&mut self, list: &[u32], positions: &[u32], added: impl Fn(u32, usize) -> [i32; WIDTH]) {
        for part in 0..self.width {
            let mut counts = [0; WIDTH];
            let mut from = 0;
            for (&to, prefix) in positions.iter().zip(self.prefix.chunks_exact_mut(self.width)) {
                for &i in &list[from..to as usize] {
                    let added = added(i, part);
                    counts = std::array::from_fn(|lane| counts[lane] + added[lane]);
                }
                prefix[part] = counts;
                from = to as usize;
            }
        }
    }

    /// Least cost of the `n` samples of total range `between` that lie between two cuts when at most `n_leaves` labels
    /// are predicted for them.
    #[inline]
    pub(super) fn cost(&self, (from, to): (usize, usize), n: u32, between: i64) -> i64 {
        if self.counted == Counted::Nothing || n as usize <= self.n_leaves {
            return 0;
        }
        let (low, high) = (&self.prefix[from * self.width..], &self.prefix[to * self.width..]);
        if self.counted == Counted::Sets {
            let mut least = [i32::MAX; WIDTH];
            for (low, high) in low.iter().zip(high).take(self.width) {
                least = std::array::from_fn(|set| least[set].min(high[set] - low[set]));
            }
            return i64::from(least.into_iter().min().unwrap_or(0));
        }
        if self.n_leaves == 2 {
            let (mut first, mut second) = (0, 0);
            for (low, high) in low.iter().zip(high).take(self.width) {
                let largest = two_largest(std::array::from_fn(|lane| high[lane] - low[lane]));
                second = second.max(largest.1).max(first.min(largest.0));
                first = first.max(largest.0);
            }
            return between - i64::from(first) - i64::from(second);
        }
        let labels = low.iter().zip(high).take(self.width);
        let mut counts: Vec<i32> =
            labels.flat_map(|(low, high)| std::array::from_fn::<_, WIDTH, _>(|c| high[c] - low[c])).collect();
        counts.sort_unstable_by(|a, b| b.cmp(a));
        between - counts.iter().take(self.n_leaves).map(|&count| i64::from(count)).sum::<i64>()
    }
}

/// The two largest of a vector's lanes, by halves: one after the other each lane would wait for that before.
#[inline(always)]
fn two_largest(counts: [i32; WIDTH]) -> (i32, i32) {
    let first: [i32; 4] = std::array::from_fn(|i| counts[i].max(counts[i + 4]));
    let second: [i32; 4] = std::array::from_fn(|i| counts[i].min(counts[i + 4]));
    let pair = |i: usize, j: usize| (first[i].max(first[j]), first[i].min(first[j]).max(second[i]).max(second[j]));
    let ((a, b), (c, d)) = (pair(0, 2), pair(1, 3));
    (a.max(c), a.min(c).max(b).max(d))
}

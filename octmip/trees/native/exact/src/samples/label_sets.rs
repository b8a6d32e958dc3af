//! Costs of samples under every set of so many labels: the bound of mixed labels where mistakes differ in cost.

/// Sets that are counted together.
pub(crate) const WIDTH: usize = 8;

/// Most sets; with more the bound is left out, as its memory and time would show.
const MOST_SETS: usize = 64;

/// The sets of as many labels as a tree has leaves.
#[derive(Debug, Clone, Default)]
pub(crate) struct LabelSets {
    /// Number of sets, in vectors of `WIDTH`; the last ones are repeated where they do not fill a vector.
    width: usize,
    /// Cost of one sample of each profile when the cheapest label of each set is predicted (`n_profiles * width`).
    costs: Vec<[i32; WIDTH]>,
}

impl LabelSets {
    /// The sets of `n_leaves` labels; None where they bound nothing, or are too many.
    ///
    /// A tree of that many leaves predicts the labels of some set at most. So on any samples it costs what they cost
    /// when each is given the cheapest label of that set, or more; the least over all sets bounds every tree.
    ///
    /// `gains` of one sample of each profile in each of `n` labels (`n_profiles * n`).
    pub(crate) fn new(gains: &[i64], n: usize, n_leaves: usize) -> Option<Self> {
        let width = width(n, n_leaves)?;
        let sets = subsets(n, n_leaves);
        let most_gain = |row: &[i64]| row.iter().copied().max().unwrap_or(0);
        let best = |row: &[i64], labels: &[usize]| labels.iter().map(|&c| row[c]).max().unwrap_or(0);
        let mut costs = Vec::with_capacity(gains.len() / n * width);
        for row in gains.chunks(n) {
            for part in 0..width {
                let mut vector = [0; WIDTH];
                for (lane, held) in vector.iter_mut().enumerate() {
                    let set = &sets[(part * WIDTH + lane).min(sets.len() - 1)];
                    *held = i32::try_from(most_gain(row) - best(row, set)).ok()?;
                }
                costs.push(vector);
            }
        }
        Some(Self { width, costs })
    }

    /// Vectors of a row.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Cost of one sample of a profile under each set.
    pub(crate) fn costs_of(&self, profile: usize) -> &[[i32; WIDTH]] {
        &self.costs[profile * self.width..(profile + 1) * self.width]
    }
}

/// Vectors of a row for sets of `n_leaves` of `n` labels; None where they bound nothing, or are too many.
pub(crate) fn width(n: usize, n_leaves: usize) -> Option<usize> {
    if n <= n_leaves {
        return None;
    }
    n_sets(n, n_leaves).filter(|&sets| sets <= MOST_SETS).map(|sets| sets.div_ceil(WIDTH))
}

/// The same, at most, for as many labels or fewer: labels that are never worth predicting fall away.
pub(crate) fn most_width(n: usize, n_leaves: usize) -> usize {
    (0..=n).filter_map(|n| width(n, n_leaves)).max().unwrap_or(0)
}

/// Number of subsets of `k` of `n`, None when it is very large.
fn n_sets(n: usize, k: usize) -> Option<usize> {
    (0..k.min(n - k)).try_fold(1usize, |sets, i| sets.checked_mul(n - i).map(|sets| sets / (i + 1)))
}

/// All subsets of `k` of `0..n`.
fn subsets(n: usize, k: usize) -> Vec<Vec<usize>> {
    let mut sets = vec![Vec::new()];
    for _ in 0..k {
        sets = sets
            .into_iter()
            .flat_map(|set: Vec<usize>| {
                let from = set.last().map_or(0, |last| last + 1);
                (from..n).map(move |next| [set.as_slice(), &[next]].concat())
            })
            .collect();
    }
    sets
}

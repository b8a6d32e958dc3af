//! The least error of at most `c` constants for a set of targets: what no tree of `c` leaves avoids.
//!
//! A leaf predicts one constant, so a tree of `c` leaves costs at least what the best `c` clusters of the targets cost,
//! and the best clusters are runs of the sorted targets. Sets are counted in a few bins of the sorted targets; a
//! boundary between two clusters lies between bins or inside one. Samples of a bin that a boundary may part are left
//! out, which only lowers the cost (errors are 0 or more, and fewer samples never cost more). Bins of one value are
//! never parted: equal targets belong to one cluster of an optimal clustering.

use std::ops::{AddAssign, Sub};

/// Most bins.
pub(crate) const N_BINS: usize = 16;

/// Sum of weights, weighted targets and weighted squares.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub(crate) struct Sums {
    /// Of the weights.
    pub(crate) weight: f64,
    /// Of weight times target.
    pub(crate) target: f64,
    /// Of weight times squared target.
    pub(crate) square: f64,
}

impl AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        self.weight += other.weight;
        self.target += other.target;
        self.square += other.square;
    }
}

impl Sub for Sums {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            weight: self.weight - other.weight,
            target: self.target - other.target,
            square: self.square - other.square,
        }
    }
}

impl Sums {
    /// Least squared error of one constant.
    #[inline(always)]
    pub(crate) fn squared_error(&self) -> f64 {
        if self.weight > 0.0 { (self.square - self.target * self.target / self.weight).max(0.0) } else { 0.0 }
    }
}

/// What a set of samples sums to in each bin.
pub(crate) type Histogram = [Sums; N_BINS];

/// Bins of the sorted targets.
#[derive(Debug, Clone)]
pub(crate) struct Bins {
    /// Bin of each sample.
    pub(crate) of_sample: Vec<u8>,
    /// Least and greatest target of each bin.
    ends: Vec<(f64, f64)>,
    /// Whether each bin holds one target.
    is_single: bool,
}

impl Bins {
    /// Bins of about as many samples each; `values` are the distinct targets, ascending.
    pub(crate) fn of(values: &[f64], ranks: &[u32]) -> Self {
        let mut counts = vec![0usize; values.len()];
        for &rank in ranks {
            counts[rank as usize] += 1;
        }
        let mut bin_of_rank = vec![0u8; values.len()];
        let mut ends: Vec<(f64, f64)> = Vec::new();
        let mut seen = 0;
        for (rank, &value) in values.iter().enumerate() {
            let is_full = seen * N_BINS >= ends.len() * ranks.len();
            if ends.is_empty() || (ends.len() < N_BINS && (is_full || values.len() - rank <= N_BINS - ends.len())) {
                ends.push((value, value));
            }
            let bin = ends.len() - 1;
            ends[bin].1 = value;
            bin_of_rank[rank] = bin as u8;
            seen += counts[rank];
        }
        let is_single = ends.iter().all(|(low, high)| low == high);
        Self { of_sample: ranks.iter().map(|&rank| bin_of_rank[rank as usize]).collect(), ends, is_single }
    }

    /// Lower bound of the error of at most `c` constants for the samples of a histogram.
    pub(crate) fn bound(&self, histogram: &Histogram, c: usize, is_absolute: bool) -> f64 {
        let n_bins = self.ends.len();
        if c >= n_bins {
            return 0.0;
        }
        if is_absolute && self.is_single {
            return self.few_targets(histogram, c);
        }
        // best[j]: least cost of the bins before j by so many clusters; a bin of several values may be left out.
        let mut best = [f64::INFINITY; N_BINS + 1];
        best[0] = 0.0;
        for round in 1..c {
            let mut next = best;
            for from in 0..if round == 1 { 1 } else { n_bins } {
                let start = self.start(&best, from);
                let mut sums = Sums::default();
                for to in from..n_bins {
                    sums += histogram[to];
                    let cost = if is_absolute { self.absolute(histogram, from, to) } else { sums.squared_error() };
                    next[to + 1] = next[to + 1].min(start + cost);
                }
            }
            best = next;
        }
        // The last cluster ends with the last bin.
        let mut least = best[n_bins];
        let mut sums = Sums::default();
        for from in (0..n_bins).rev() {
            sums += histogram[from];
            let cost = if is_absolute { self.absolute(histogram, from, n_bins - 1) } else { sums.squared_error() };
            least = least.min(self.start(&best, from) + cost);
        }
        least
    }

    /// The same where each bin is one target: the least absolute error of `c` constants.
    ///
    /// A run of targets errs by its gaps, each times the lesser of the run's weights on both sides of it.
    fn few_targets(&self, histogram: &Histogram, c: usize) -> f64 {
        let n = self.ends.len();
        let mut below = [0.0; N_BINS + 1];
        for (bin, own) in histogram[..n].iter().enumerate() {
            below[bin + 1] = below[bin] + own.weight;
        }
        let gap = |j: usize| self.ends[j].0 - self.ends[j - 1].0;
        let run = |from: usize, to: usize| -> f64 {
            let side = |j: usize| f64::min(below[j] - below[from], below[to] - below[j]);
            (from + 1..to).map(|j| gap(j) * side(j)).sum()
        };
        if c + 1 == n {
            return (0..n - 1).map(|from| run(from, from + 2)).fold(f64::INFINITY, f64::min);
        }
        let mut best: [f64; N_BINS + 1] = std::array::from_fn(|to| if to <= n { run(0, to) } else { 0.0 });
        for round in 1..c {
            for to in (if round + 1 == c { n } else { 1 }..=n).rev() {
                best[to] = (0..to).map(|from| best[from] + run(from, to)).fold(best[to], f64::min);
            }
        }
        best[n]
    }

    /// Least cost of what lies before a cluster whose first whole bin is `from`.
    #[inline(always)]
    fn start(&self, best: &[f64; N_BINS + 1], from: usize) -> f64 {
        let is_parted = from > 0 && self.ends[from - 1].0 < self.ends[from - 1].1;
        if is_parted { best[from].min(best[from - 1]) } else { best[from] }
    }

    /// Lower bound of the absolute error of one constant for the bins `from..=to`.
    ///
    /// The weighted median lies in the bin where half of the weight is reached. Bins below and above cost what their
    /// sums say, and its own at least the absolute value of its sum; all this is convex in the constant, with its one
    /// bend at the mean of that bin.
    fn absolute(&self, histogram: &Histogram, from: usize, to: usize) -> f64 {
        let total = histogram[from..=to].iter().fold(Sums::default(), |mut sum, bin| {
            sum += *bin;
            sum
        });
        let mut below = Sums::default();
        let mut middle = from;
        while middle < to && 2.0 * (below.weight + histogram[middle].weight) < total.weight {
            below += histogram[middle];
            middle += 1;
        }
        let own = histogram[middle];
        let above_weight = total.weight - below.weight - own.weight;
        let above_target = total.target - below.target - own.target;
        let cost = |m: f64| {
            (m * below.weight - below.target) + (above_target - m * above_weight) + (own.target - m * own.weight).abs()
        };
        let (low, high) = self.ends[middle];
        let mean = if own.weight > 0.0 { (own.target / own.weight).clamp(low, high) } else { low };
        cost(low).min(cost(high)).min(cost(mean)).max(0.0)
    }
}

//! The least error of at most `c` constants for a set of targets: what no tree of `c` leaves avoids.
//!
//! The best clusters of targets are runs of the sorted ones. Targets are counted in bins; a boundary between two
//! clusters lies between bins or inside one, and samples of a bin that it may part are left out, which only lowers the
//! error. Bins of one target are never parted.

use crate::regression::bins::N_BINS;
use crate::regression::grid::Samples;

/// Weights, weighted targets and weighted squares of bins, summed up from the first: whole numbers.
struct Sums {
    weight: [i64; N_BINS + 1],
    target: [i64; N_BINS + 1],
    square: [i128; N_BINS + 1],
}

impl Samples {
    /// Lower bound of the error of at most `c` constants for these samples.
    pub fn clusters(&self, set: &[u32], c: usize) -> i64 {
        let ends = &self.bins.ends;
        if c >= ends.len() || set.is_empty() {
            return 0;
        }
        let sums = self.sums(set);
        let run = |from: usize, to: usize| {
            if self.is_absolute { absolute(ends, &sums, from, to) } else { squared(&sums, from, to) }
        };
        // best[j]: least error of the bins before j by the clusters so far.
        let start = |best: &[f64], from: usize| {
            let is_parted = from > 0 && ends[from - 1].0 < ends[from - 1].1;
            if is_parted { best[from].min(best[from - 1]) } else { best[from] }
        };
        let mut best: Vec<f64> = (0..=ends.len()).map(|to| if to > 0 { run(0, to) } else { 0.0 }).collect();
        for _ in 1..c {
            let reach = |to: usize| (0..to).map(|from| start(&best, from) + run(from, to)).fold(best[to], f64::min);
            best = (0..=ends.len()).map(reach).collect();
        }
        // Absolute errors are whole. Sums of squared ones, 0 or more each, are rounded: the true one is not below this.
        let certain = if self.is_absolute { 1.0 } else { 1.0 - 2f64.powi(-46) };
        self.floor((best[ends.len()] * certain) as i128)
    }

    fn sums(&self, set: &[u32]) -> Sums {
        let mut sums = Sums { weight: [0; N_BINS + 1], target: [0; N_BINS + 1], square: [0; N_BINS + 1] };
        for &i in set {
            let (bin, weight, target) =
                (self.bins.of_sample[i as usize] as usize, self.weights[i as usize], self.targets[i as usize]);
            sums.weight[bin + 1] += weight;
            sums.target[bin + 1] += weight * target;
            sums.square[bin + 1] += i128::from(weight * target) * i128::from(target);
        }
        for bin in 0..N_BINS {
            sums.weight[bin + 1] += sums.weight[bin];
            sums.target[bin + 1] += sums.target[bin];
            sums.square[bin + 1] += sums.square[bin];
        }
        sums
    }
}

/// Squared error of one constant for the bins from one to before another, not rounded up.
fn squared(sums: &Sums, from: usize, to: usize) -> f64 {
    let (weight, target) = (sums.weight[to] - sums.weight[from], (sums.target[to] - sums.target[from]) as f64);
    let square = (sums.square[to] - sums.square[from]) as f64 * (1.0 - 2f64.powi(-51));
    (square - target * target / weight.max(1) as f64 * (1.0 + 2f64.powi(-50))).max(0.0)
}

/// Lower bound of the absolute error of one constant for these bins: it lies in one of them, which is left out, or
/// between two; the error of the others is linear between the ends of that bin.
fn absolute(ends: &[(i64, i64)], sums: &Sums, from: usize, to: usize) -> f64 {
    let error = |m: i64, bin: usize| {
        let below = m * (sums.weight[bin] - sums.weight[from]) - (sums.target[bin] - sums.target[from]);
        below + (sums.target[to] - sums.target[bin + 1]) - m * (sums.weight[to] - sums.weight[bin + 1])
    };
    let least = |bin: usize| error(ends[bin].0, bin).min(error(ends[bin].1, bin));
    (from..to).map(least).min().unwrap_or(0).max(0) as f64
}

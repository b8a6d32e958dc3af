//! The least error of at most `c` constants for a set of targets: what no tree of `c` leaves avoids.
//!
//! **Theorem.** Let the targets lie in cells, one after the other, equal ones in one cell. A *place* is before a cell,
//! after the last one, or inside a cell of several targets. The best `c` clusters cost at least the least sum, over all
//! places `0 = q_0 <= q_1 <= ... <= q_c = end`, of what the cells between `q_(j-1)` and `q_j` cost as one cluster each
//! (no cell between: 0).
//!
//! *Proof.* The best clusters are runs of the sorted targets, and part no equal ones. Put each of the `c - 1`
//! boundaries between them where it is: between two cells, or inside one. The cells between two boundaries belong to
//! one cluster, which costs no less than they do, as fewer samples never cost more. So the sum over these places is at
//! most what the clusters cost, and the least sum over all places is no larger. QED
//!
//! Nothing is assumed of where the boundaries are, or how many are in one cell.

use crate::regression::bins::N_BINS;
use crate::regression::grid::Samples;
use crate::regression::slopes::Slopes;

/// Places: before a cell `2i`, inside it `2i + 1`, after the last.
const N_PLACES: usize = 2 * N_BINS + 1;

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
        let n = ends.len();
        if c >= n || set.is_empty() {
            return 0;
        }
        let sums = self.sums(set);
        // Of the cells from one to before another.
        let cost = |from: usize, to: usize| match (from < to && to <= n, self.slopes) {
            (false, _) => 0.0,
            (true, Some(slopes)) => sloped(slopes, ends, &sums, from, to),
            (true, None) => squared(&sums, from, to),
        };
        let costs: [[f64; N_BINS + 1]; N_BINS + 1] =
            std::array::from_fn(|from| std::array::from_fn(|to| cost(from, to)));
        let between = |p: usize, q: usize| costs[p.div_ceil(2)][q / 2];
        let is_place = |q: &usize| q.is_multiple_of(2) || ends[q / 2].0 < ends[q / 2].1;
        let places: Vec<usize> = (0..=2 * n).filter(is_place).collect();
        // best[q]: least sum of the clusters so far, the last of which ends at q.
        let mut best = [0.0; N_PLACES];
        places.iter().for_each(|&q| best[q] = between(0, q));
        for _ in 1..c {
            for (k, &q) in places.iter().enumerate().rev() {
                best[q] = places[..=k].iter().map(|&p| best[p] + between(p, q)).fold(best[q], f64::min);
            }
        }
        // Sloped errors are whole. Sums of squared ones, 0 or more each, are rounded: the true one is not below this.
        let certain = if self.slopes.is_some() { 1.0 } else { 1.0 - 2f64.powi(-46) };
        self.floor((best[2 * n] * certain) as i128)
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

/// Lower bound of the sloped error of one constant for these bins: a best one lies in one of them, which is left out;
/// the error of the others is linear between the ends of that bin.
fn sloped(slopes: Slopes, ends: &[(i64, i64)], sums: &Sums, from: usize, to: usize) -> f64 {
    let error = |m: i64, bin: usize| {
        let below = m * (sums.weight[bin] - sums.weight[from]) - (sums.target[bin] - sums.target[from]);
        let above = (sums.target[to] - sums.target[bin + 1]) - m * (sums.weight[to] - sums.weight[bin + 1]);
        slopes.cost(below, above)
    };
    let least = |bin: usize| error(ends[bin].0, bin).min(error(ends[bin].1, bin));
    (from..to).map(least).min().unwrap_or(0).max(0) as f64
}

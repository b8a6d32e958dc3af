//! The least error of at most `c` constants for a set of targets: what no tree of `c` leaves avoids.
//!
//! A leaf predicts one constant, so a tree of `c` leaves costs at least what the best `c` clusters of the targets cost,
//! and the best clusters are runs of the sorted targets. Sets are counted in a few bins of the sorted targets; a
//! boundary between two clusters lies between bins or inside one. Samples of a bin that a boundary may part are left
//! out, which only lowers the cost (errors are 0 or more, and fewer samples never cost more). Bins of one value are
//! never parted: equal targets belong to one cluster of an optimal clustering.

use std::ops::{AddAssign, Sub};

use crate::slopes::Slopes;

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
    ///
    /// **Theorem.** Let `best(j, b)` be the least sum of what runs of bins before `b` cost as one cluster each, at most
    /// `j` runs, where the next run starts at the bin after the last one, or one later if the bin between holds several
    /// targets (it is left out), and where a run may be empty. Then `best(c, n_bins)` is at most what the best `c`
    /// clusters of the targets cost.
    ///
    /// *Proof.* The best clusters are runs of the sorted targets, none of them parting equal ones. Let `p(j)` be the
    /// number of bins that end within the first `j` clusters, `p(0) = 0`, `p(c) = n_bins`; by induction the first `j`
    /// clusters cost `best(j, p(j))` or more. Cluster `j + 1` starts with the bin `p(j)`, or inside it: then it holds
    /// several targets. So the whole bins of that cluster are those from `p(j)`, or from `p(j) + 1`, to before
    /// `p(j + 1)`: a run that `best` allows, empty where the cluster has no whole bin: inside one bin, from one into
    /// the next, **or as the end of the last bin**. It costs no more than the cluster, as fewer samples never do. QED
    pub(crate) fn bound(&self, histogram: &Histogram, c: usize, slopes: Option<Slopes>) -> f64 {
        let n_bins = self.ends.len();
        if c >= n_bins {
            return 0.0;
        }
        if let Some(slopes) = slopes.filter(|_| self.is_single) {
            return self.few_targets(slopes, histogram, c);
        }
        let runs = Runs::of(self, histogram, slopes);
        // Of one cluster: nothing is left out.
        let mut best = [f64::INFINITY; N_BINS + 1];
        best[0] = 0.0;
        runs.extend(&mut best, 0.0, 0);
        for _ in 2..c {
            let mut next = best;
            for from in 1..=n_bins {
                let start = self.start(&best, from);
                next[from] = next[from].min(start);
                runs.extend(&mut next, start, from);
            }
            best = next;
        }
        if c == 1 {
            return best[n_bins];
        }
        // The last cluster ends with the last bin, or inside it.
        let mut least = self.start(&best, n_bins);
        runs.to_the_end(|from, cost| least = least.min(self.start(&best, from) + cost));
        least
    }

    /// The same where each bin is one target: the least sloped error of `c` constants.
    ///
    /// A run of targets errs by its gaps, each times the lesser of what the run's weights on both sides of it cost.
    fn few_targets(&self, slopes: Slopes, histogram: &Histogram, c: usize) -> f64 {
        let n = self.ends.len();
        let mut below = [0.0; N_BINS + 1];
        for (bin, own) in histogram[..n].iter().enumerate() {
            below[bin + 1] = below[bin] + own.weight;
        }
        let gap = |j: usize| self.ends[j].0 - self.ends[j - 1].0;
        let run = |from: usize, to: usize| -> f64 {
            let side = |j: usize| f64::min(slopes.down * (below[j] - below[from]), slopes.up * (below[to] - below[j]));
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
}

/// Lower bounds of the error of one constant for runs of bins.
struct Runs<'a> {
    bins: &'a Bins,
    histogram: &'a Histogram,
    slopes: Option<Slopes>,
    /// What the bins before each one sum to; of sloped errors.
    before: Histogram,
}

impl<'a> Runs<'a> {
    #[inline(always)]
    fn of(bins: &'a Bins, histogram: &'a Histogram, slopes: Option<Slopes>) -> Self {
        let mut sum = Sums::default();
        let mut before = |bin: usize| {
            let before = sum;
            sum += histogram[bin];
            before
        };
        let before = if slopes.is_some() { std::array::from_fn(&mut before) } else { [sum; N_BINS] };
        Self { bins, histogram, slopes, before }
    }

    /// Lower `next` by the runs from a bin on that begin at a cost of `start`.
    #[inline(always)]
    fn extend(&self, next: &mut [f64; N_BINS + 1], start: f64, from: usize) {
        let (mut sums, mut middle) = (Sums::default(), from);
        for to in from..self.bins.ends.len() {
            sums += self.histogram[to];
            let cost = match self.slopes {
                Some(slopes) => self.sloped(slopes, (from, to), sums, &mut middle),
                None => sums.squared_error(),
            };
            next[to + 1] = next[to + 1].min(start + cost);
        }
    }

    /// Show each run but the longest that ends with the last bin: its first bin and its bound.
    #[inline(always)]
    fn to_the_end(&self, mut show: impl FnMut(usize, f64)) {
        let n = self.bins.ends.len();
        let Some(slopes) = self.slopes else {
            let mut sums = Sums::default();
            for from in (1..n).rev() {
                sums += self.histogram[from];
                show(from, sums.squared_error());
            }
            return;
        };
        let (end, mut middle) = (self.before[n - 1], 1);
        for from in 1..n {
            let mut total = end - self.before[from];
            total += self.histogram[n - 1];
            middle = middle.max(from);
            show(from, self.sloped(slopes, (from, n - 1), total, &mut middle));
        }
    }

    /// Lower bound of the sloped error of one constant for the bins `from..=to`, which sum to `total`.
    ///
    /// The weighted quantile lies in the bin where its share of the weight is reached: `middle` or a later one, as it
    /// goes up with either end of a run. Bins below and above cost what their sums say, and its own at least the error
    /// of its sum; all this is convex in the constant, with its one bend at the mean of that bin.
    #[inline(always)]
    fn sloped(&self, slopes: Slopes, (from, to): (usize, usize), total: Sums, middle: &mut usize) -> f64 {
        let start = self.before[from];
        let weight_to = |bin: usize| self.before[bin].weight + self.histogram[bin].weight - start.weight;
        while *middle < to && !slopes.is_reached(weight_to(*middle), total.weight) {
            *middle += 1;
        }
        let (below, own) = (self.before[*middle] - start, self.histogram[*middle]);
        let above = total - below - own;
        let cost = |m: f64| {
            let miss = own.target - m * own.weight;
            slopes.cost(m * below.weight - below.target, above.target - m * above.weight) + slopes.most(-miss, miss)
        };
        let (low, high) = self.bins.ends[*middle];
        let mean = if own.weight > 0.0 { (own.target / own.weight).clamp(low, high) } else { low };
        cost(low).min(cost(high)).min(cost(mean)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use octmip_check::regression::grid::{Samples, Scale};
    use octmip_check::regression::question::RegressionQuestion;
    use octmip_check::regression::slopes::Slopes as CheckedSlopes;

    use super::{Bins, Histogram, N_BINS, Slopes, Sums};

    /// Whole targets with a spread top, with ties, or in clusters.
    fn targets(rng: &mut fastrand::Rng, n: usize) -> Vec<f64> {
        let normal = |rng: &mut fastrand::Rng| (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
        let kind = rng.u8(0..6);
        let draw = |rng: &mut fastrand::Rng| match kind {
            0 => 64.0 * (1.5 * normal(rng)).exp(),
            1 => (64.0 * (std::f64::consts::PI * (rng.f64() - 0.5)).tan()).clamp(-1e6, 1e6),
            2 => f64::from(rng.u8(0..30)),
            3 => 1024.0 * normal(rng),
            4 => 4.0 * normal(rng).exp(),
            _ => 1000.0 * f64::from(rng.u8(0..4)) + 64.0 * normal(rng),
        };
        (0..n).map(|_| draw(rng).round()).collect()
    }

    /// The least error of one constant for targets with weights.
    fn run(own: &[(f64, f64)], slopes: Option<(i64, i64)>) -> f64 {
        let miss = |y: f64| match slopes {
            Some((up, _)) if y > 0.0 => up as f64 * y,
            Some((_, down)) => down as f64 * -y,
            None => y * y,
        };
        let error = |m: f64| -> f64 { own.iter().map(|(y, w)| w * miss(y - m)).sum() };
        if slopes.is_some() {
            return own.iter().map(|(m, _)| error(*m)).fold(f64::INFINITY, f64::min);
        }
        let weight: f64 = own.iter().map(|(_, w)| w).sum();
        error(own.iter().map(|(y, w)| y * w).sum::<f64>() / weight)
    }

    /// The least error of 1, 2, ... runs of sorted targets, by every run that there is.
    fn optima(sorted: &[(f64, f64)], most: usize, slopes: Option<(i64, i64)>) -> Vec<f64> {
        let n = sorted.len();
        let costs: Vec<Vec<f64>> =
            (0..n).map(|from| (from + 1..=n).map(|to| run(&sorted[from..to], slopes)).collect()).collect();
        let mut best: Vec<f64> = (0..=n).map(|to| if to == 0 { 0.0 } else { costs[0][to - 1] }).collect();
        let mut found = vec![best[n]];
        for _ in 1..most {
            let reach =
                |to: usize| (0..to).map(|from| best[from] + costs[from][to - from - 1]).fold(best[to], f64::min);
            best = (0..=n).map(reach).collect();
            found.push(best[n]);
        }
        found
    }

    #[test]
    fn neither_bound_is_above_the_best_clusters_and_both_meet_them_where_each_bin_is_one_target() {
        let (mut n_met, mut n_many) = (0, 0);
        for seed in 0..1000 {
            let rng = &mut fastrand::Rng::with_seed(seed);
            let n = rng.usize(2..48);
            let all = targets(rng, n);
            let heaviest = if rng.bool() { 9 } else { 2 };
            let weights: Vec<f64> = (0..n).map(|_| f64::from(rng.u8(1..heaviest))).collect();
            let mut values = all.clone();
            values.sort_unstable_by(f64::total_cmp);
            values.dedup();
            let ranks: Vec<u32> = all.iter().map(|y| values.partition_point(|v| v < y) as u32).collect();
            let bins = Bins::of(&values, &ranks);
            // Some of the samples, as at a node.
            let mut kept: Vec<usize> = (0..n).filter(|_| rng.u8(0..4) > 0).collect();
            kept.sort_by(|&i, &j| all[i].total_cmp(&all[j]));
            let mut histogram: Histogram = [Sums::default(); N_BINS];
            for &i in &kept {
                let (weight, target) = (weights[i], weights[i] * all[i]);
                histogram[bins.of_sample[i] as usize] += Sums { weight, target, square: target * all[i] };
            }
            let sorted: Vec<(f64, f64)> = kept.iter().map(|&i| (all[i], weights[i])).collect();
            for slopes in [None, Some((1, 1)), Some((9, 1))] {
                let question = question(&all, &weights, slopes);
                let checked =
                    Samples::on_grid(&question, Scale { weight: 0, target: 0, cost: 0, reach: 1100 }).expect("small");
                let set: Vec<u32> = kept.iter().map(|&i| i as u32).collect();
                let size: f64 =
                    sorted.iter().map(|(y, w)| w * if slopes.is_some() { 9.0 * y.abs() } else { y * y }).sum();
                for (c, least) in (1..).zip(optima(&sorted, 8, slopes)) {
                    let own = slopes.map(|(up, down)| Slopes { up: up as f64, down: down as f64 });
                    let bounds = [bins.bound(&histogram, c, own), checked.clusters(&set, c) as f64];
                    for bound in bounds {
                        assert!(bound <= least + 1e-12 * size, "seed {seed}, {c} clusters: {bound} above {least}");
                    }
                    n_many += usize::from(values.len() > N_BINS);
                    if values.len() <= N_BINS {
                        let is_met = |bound: f64, off: f64| bound >= least - off - 1e-12 * size;
                        assert!(
                            is_met(bounds[0], 0.0) && is_met(bounds[1], 1.0),
                            "seed {seed}, {c}: {bounds:?}, {least}"
                        );
                        n_met += 1;
                    }
                }
            }
        }
        assert!(n_met > 5_000 && n_many > 5_000, "{n_met} and {n_many} bounds");
    }

    fn question(targets: &[f64], weights: &[f64], slopes: Option<(i64, i64)>) -> RegressionQuestion {
        RegressionQuestion {
            n: targets.len(),
            p: 1,
            features: (0..targets.len()).map(|i| i as f64).collect(),
            targets: targets.to_vec(),
            weights: weights.to_vec(),
            slopes: slopes.map(|(up, down)| CheckedSlopes { up, down, over: if up == 1 { 1 } else { up + down } }),
            depth: 1,
            leaf_size: 1,
            leaf_penalty: 0.0,
            sensor_of_feature: vec![0],
            sensor_cost: vec![1.0],
            sensor_limit: f64::INFINITY,
        }
    }
}

//! The problem as the exact core counts it: gains instead of costs.
//!
//! Every sample has a swing, the largest cost that its prediction can add to its smallest, and gives a gain of
//! `swing - added cost` to each column (label) that is predicted for it. Then
//!
//! ```text
//! cost of a leaf S = base(S) + swing(S) - max over columns of gain(S, column)
//! ```
//!
//! and every bound reads as it does for counts of samples, with "number of samples" replaced by swing:
//! adding a sample never lowers the cost of the best tree above the base, and raises it by at most its swing.

use crate::problem::Problem;

/// Samples, gains and limits; read by all threads.
#[derive(Debug, Clone)]
pub struct Samples {
    /// Number of samples.
    pub n: usize,
    /// Number of usable features: allowed and not constant.
    pub p: usize,
    /// Number of columns: labels worth predicting.
    pub n_columns: usize,
    /// The problem's index of each usable feature (`p`).
    pub features: Vec<u32>,
    /// Dense ranks, feature-major (`p * n`).
    pub ranks: Vec<u32>,
    /// Sample ids in the order of each feature, ties by id (`p * n`).
    pub order: Vec<u32>,
    /// Largest added cost of each sample (`n`).
    pub swing: Vec<i64>,
    /// Smallest cost of each sample, which no tree avoids (`n`).
    pub base: Vec<i64>,
    /// Whether every sample gains in one column only (0/1 costs with any weights, for instance).
    pub is_single: bool,
    /// The column that each sample gains in, by all of its swing, where `is_single` (`n`).
    pub column: Vec<u32>,
    /// Gains of each sample (`n * n_columns`) where not `is_single`, else empty.
    pub gains: Vec<i64>,
    /// Label of each column (`n_columns`).
    pub labels: Vec<u32>,
    /// Price of a split.
    pub penalty: i64,
    /// Fewest samples in a leaf.
    pub leaf_size: usize,
}

impl Samples {
    /// Encode a validated problem; features that are not allowed or constant are left out.
    pub fn new(problem: &Problem) -> Self {
        let features: Vec<u32> =
            (0..problem.p).filter(|&f| problem.allowed[f] && problem.n_ranks[f] > 1).map(|f| f as u32).collect();
        let n = problem.n;
        let mut ranks = Vec::with_capacity(features.len() * n);
        let mut order = Vec::with_capacity(features.len() * n);
        for &f in &features {
            let values = problem.feature(f as usize);
            ranks.extend_from_slice(values);
            order.extend(sorted_by_rank(values, problem.n_ranks[f as usize]));
        }
        let mut samples = Self {
            n,
            p: features.len(),
            n_columns: 0,
            features,
            ranks,
            order,
            swing: Vec::with_capacity(n),
            base: Vec::with_capacity(n),
            is_single: true,
            column: Vec::new(),
            gains: Vec::new(),
            labels: Vec::new(),
            penalty: problem.penalty,
            leaf_size: problem.leaf_size,
        };
        samples.set_gains(problem);
        samples
    }

    fn set_gains(&mut self, problem: &Problem) {
        let k = problem.n_classes;
        let rows: Vec<&[i64]> = problem.costs.chunks(k).collect();
        let least: Vec<i64> = rows.iter().map(|row| row.iter().copied().min().unwrap_or(0)).collect();
        let most: Vec<i64> = rows.iter().map(|row| row.iter().copied().max().unwrap_or(0)).collect();
        let mut has_samples = vec![false; k];
        for i in 0..self.n {
            let class = problem.labels[i] as usize;
            has_samples[class] |= problem.weights[i] > 0;
            self.swing.push(problem.weights[i] * (most[class] - least[class]));
            self.base.push(problem.weights[i] * least[class]);
        }
        // A column in which no present class gains is never better than another.
        let gains = |class: usize, label: usize| most[class] - rows[class][label];
        self.labels = (0..k)
            .filter(|&label| (0..k).any(|class| has_samples[class] && gains(class, label) > 0))
            .map(|label| label as u32)
            .collect();
        if self.labels.is_empty() {
            self.labels.push(0);
        }
        self.n_columns = self.labels.len();
        let columns_of = |class: usize| -> Vec<usize> {
            (0..self.labels.len()).filter(|&c| gains(class, self.labels[c] as usize) > 0).collect()
        };
        self.is_single = (0..k).filter(|&class| has_samples[class]).all(|class| columns_of(class).len() <= 1);
        if self.is_single {
            let of_class: Vec<u32> =
                (0..k).map(|class| columns_of(class).first().map_or(0, |&column| column as u32)).collect();
            self.column = problem.labels.iter().map(|&class| of_class[class as usize]).collect();
        } else {
            for i in 0..self.n {
                let class = problem.labels[i] as usize;
                let row = self.labels.iter().map(|&label| problem.weights[i] * gains(class, label as usize));
                self.gains.extend(row);
            }
        }
    }

    /// The same samples with only these of the usable features.
    pub fn with_features(&self, usable: &[usize]) -> Self {
        let pick = |lists: &[u32]| -> Vec<u32> {
            usable.iter().flat_map(|&f| lists[f * self.n..(f + 1) * self.n].iter().copied()).collect()
        };
        Self {
            p: usable.len(),
            features: usable.iter().map(|&f| self.features[f]).collect(),
            ranks: pick(&self.ranks),
            order: pick(&self.order),
            swing: self.swing.clone(),
            base: self.base.clone(),
            column: self.column.clone(),
            gains: self.gains.clone(),
            labels: self.labels.clone(),
            ..*self
        }
    }

    /// The ranks of one usable feature, by sample.
    pub fn ranks_of(&self, f: usize) -> &[u32] {
        &self.ranks[f * self.n..(f + 1) * self.n]
    }

    /// Add (`sign` 1) or take away (-1) the gains of a sample.
    #[inline(always)]
    pub fn count(&self, sample: u32, sign: i64, totals: &mut [i64]) {
        let i = sample as usize;
        if self.is_single {
            totals[self.column[i] as usize] += sign * self.swing[i];
        } else {
            let row = &self.gains[i * self.n_columns..(i + 1) * self.n_columns];
            for (total, gain) in totals.iter_mut().zip(row) {
                *total += sign * gain;
            }
        }
    }
}

/// Sample ids by rank, ties by id: a counting sort.
fn sorted_by_rank(ranks: &[u32], n_ranks: u32) -> Vec<u32> {
    let mut start = vec![0u32; n_ranks as usize + 1];
    for &rank in ranks {
        start[rank as usize + 1] += 1;
    }
    for r in 0..n_ranks as usize {
        start[r + 1] += start[r];
    }
    let mut order = vec![0; ranks.len()];
    for (i, &rank) in ranks.iter().enumerate() {
        let place = &mut start[rank as usize];
        order[*place as usize] = i as u32;
        *place += 1;
    }
    order
}

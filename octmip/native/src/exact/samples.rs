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

pub mod directions;
pub mod label_sets;

use crate::costs::ClassCosts;
use crate::problem::Problem;

use directions::doubled_spans;
use label_sets::LabelSets;

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
    /// Kind of each sample (`n`): where `is_single` the column that it gains in, else the row of `gains`.
    pub kind: Vec<u32>,
    /// How often a sample counts in its kind (`n`): its gains are `amount * gains[kind]`.
    pub amount: Vec<i64>,
    /// Gains of one sample of each kind (`n_kinds * n_columns`).
    pub gains: Vec<i64>,
    /// Twice the span that is left of each kind beside each direction (`n_directions * n_kinds`); none where
    /// `is_single`.
    pub spans: Vec<i64>,
    /// Sets of 2, 4, 8, ... columns, as far as they bound anything; none where `is_single`.
    sets: Vec<Option<LabelSets>>,
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
            kind: Vec::with_capacity(n),
            amount: Vec::with_capacity(n),
            gains: Vec::new(),
            spans: Vec::new(),
            sets: Vec::new(),
            labels: Vec::new(),
            penalty: problem.penalty,
            leaf_size: problem.leaf_size,
        };
        samples.set_gains(problem);
        samples
    }

    fn set_gains(&mut self, problem: &Problem) {
        let k = problem.n_classes;
        let costs = ClassCosts::of(problem);
        let mut has_samples = vec![false; k];
        for i in 0..self.n {
            let class = problem.labels[i] as usize;
            has_samples[class] |= problem.weights[i] > 0;
            self.swing.push(problem.weights[i] * costs.range(class));
            self.base.push(problem.weights[i] * costs.base(class));
        }
        // A column that gains no more than another in any present class (the first of equals stays) is never needed.
        let present: Vec<usize> = (0..k).filter(|&class| has_samples[class]).collect();
        let is_covered = |label: usize, by: usize| {
            let differs = present.iter().any(|&class| costs.gain(class, label) != costs.gain(class, by));
            (differs || by < label) && present.iter().all(|&class| costs.gain(class, label) <= costs.gain(class, by))
        };
        self.labels =
            (0..k).filter(|&label| !(0..k).any(|by| is_covered(label, by))).map(|label| label as u32).collect();
        self.n_columns = self.labels.len();
        self.set_kinds(problem, &has_samples, &costs);
    }

    /// Classes whose gains are in proportion are one kind: cost matrices have few, however many classes there are.
    fn set_kinds(&mut self, problem: &Problem, has_samples: &[bool], costs: &ClassCosts) {
        let rows: Vec<Vec<i64>> = (0..problem.n_classes)
            .map(|class| self.labels.iter().map(|&label| costs.gain(class, label as usize)).collect())
            .collect();
        let is_row_single = |row: &Vec<i64>| row.iter().filter(|&&gain| gain > 0).count() <= 1;
        self.is_single = (0..rows.len()).filter(|&class| has_samples[class]).all(|class| is_row_single(&rows[class]));
        let mut kinds: Vec<Vec<i64>> = Vec::new();
        if self.is_single {
            kinds = (0..self.n_columns).map(|c| (0..self.n_columns).map(|d| i64::from(c == d)).collect()).collect();
        }
        let mut of_class = vec![(0, 0); rows.len()];
        for class in (0..rows.len()).filter(|&class| has_samples[class]) {
            let factor = rows[class].iter().fold(0, |a, &b| greatest_divisor(a, b));
            if factor > 0 {
                let row: Vec<i64> = rows[class].iter().map(|gain| gain / factor).collect();
                let kind = kinds.iter().position(|known| *known == row).unwrap_or(kinds.len());
                if kind == kinds.len() {
                    kinds.push(row);
                }
                of_class[class] = (kind as u32, factor);
            }
        }
        for i in 0..self.n {
            let (kind, factor) = of_class[problem.labels[i] as usize];
            self.kind.push(kind);
            self.amount.push(problem.weights[i] * factor);
        }
        self.gains = kinds.concat();
        if !self.is_single {
            self.spans = doubled_spans(&self.gains, self.n_columns);
            let sizes = (1..self.n_columns).map(|level| 1 << level).take_while(|&size| size < self.n_columns);
            self.sets = sizes.map(|size| LabelSets::new(&self.gains, self.n_columns, size)).collect();
        }
    }

    /// The sets of as many columns as a child of this many leaves may predict, where they bound anything.
    pub fn label_sets(&self, n_leaves: usize) -> Option<&LabelSets> {
        self.sets.get((n_leaves.max(2).ilog2() - 1) as usize)?.as_ref()
    }

    /// Number of kinds of samples.
    pub fn n_kinds(&self) -> usize {
        self.gains.len() / self.n_columns
    }

    /// Gains of one sample of a kind (`n_columns`).
    pub fn gains_of(&self, kind: usize) -> &[i64] {
        &self.gains[kind * self.n_columns..(kind + 1) * self.n_columns]
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
            kind: self.kind.clone(),
            amount: self.amount.clone(),
            gains: self.gains.clone(),
            spans: self.spans.clone(),
            sets: self.sets.clone(),
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
        let (kind, amount) = (self.kind[i] as usize, sign * self.amount[i]);
        if self.is_single {
            totals[kind] += amount;
        } else {
            for (total, gain) in totals.iter_mut().zip(self.gains_of(kind)) {
                *total += amount * gain;
            }
        }
    }
}

fn greatest_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { greatest_divisor(b, a % b) }
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

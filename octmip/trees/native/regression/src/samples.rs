//! The problem as the regression core counts it.

use crate::clusters::{Bins, Sums};
use crate::slopes::Slopes;
use crate::sweep::MOST_VALUES;
use octmip_frame::ranks::sorted_by_rank;

/// What is asked: ranks, targets, weights and the tree that is wanted.
#[derive(Debug, Clone)]
pub struct Question {
    /// Number of samples.
    pub n: usize,
    /// Number of features.
    pub p: usize,
    /// Dense ranks, feature-major (`p * n`).
    pub ranks: Vec<u32>,
    /// Number of ranks of each feature (`p`).
    pub n_ranks: Vec<u32>,
    /// Targets, centred and scaled (`n`).
    pub targets: Vec<f64>,
    /// Weights, 0 or more (`n`).
    pub weights: Vec<f64>,
    /// Weight times squared target of each sample, rounded up to a common grid (`n`): `trees/regression/grid.py`.
    pub squares: Vec<f64>,
    /// The grid of `squares`.
    pub grain: f64,
    /// Those of the error; None where it is squared.
    pub slopes: Option<Slopes>,
    /// Price of a split.
    pub penalty: f64,
    /// Levels of splits.
    pub depth: usize,
    /// Fewest samples in a leaf.
    pub leaf_size: usize,
    /// Which features may be used (`p`).
    pub allowed: Vec<bool>,
}

impl Question {
    /// What is wrong with it, in words, if anything is.
    pub fn complaint(&self) -> Option<String> {
        let Self { n, p, .. } = *self;
        if n == 0
            || self.ranks.len() != n * p
            || self.targets.len() != n
            || self.weights.len() != n
            || self.squares.len() != n
        {
            let [ranks, targets, weights] = [self.ranks.len(), self.targets.len(), self.weights.len()];
            return Some(format!("{ranks} ranks, {targets} targets, {weights} weights of {n} samples, {p} features"));
        }
        if self.n_ranks.len() != p || self.allowed.len() != p {
            return Some(format!("{} numbers of ranks for {p} features", self.n_ranks.len()));
        }
        if let Some(j) = (0..n * p).find(|&j| self.ranks[j] >= self.n_ranks[j / n]) {
            return Some(format!("rank {} of feature {} is beyond {}", self.ranks[j], j / n, self.n_ranks[j / n]));
        }
        let is_fine = |x: &f64| x.is_finite();
        if !self.targets.iter().all(is_fine) || !self.weights.iter().all(|w| w.is_finite() && *w >= 0.0) {
            return Some("targets and weights must be finite, weights 0 or more".to_string());
        }
        (self.penalty.is_nan() || self.penalty < 0.0 || self.leaf_size == 0 || self.depth > 30)
            .then(|| format!("penalty {}, leaf size {}, depth {}", self.penalty, self.leaf_size, self.depth))
    }
}

/// Samples and limits; read only.
#[derive(Debug)]
pub(crate) struct Samples {
    /// Number of samples.
    pub n: usize,
    /// Number of usable features: allowed and not constant.
    pub p: usize,
    /// The problem's index of each usable feature (`p`).
    pub features: Vec<u32>,
    /// Dense ranks of the usable features, then of the targets (`(p + 1) * n`).
    pub(crate) ranks: Vec<u32>,
    /// Sample ids in the order of each of these, ties by id (`(p + 1) * n`).
    pub(crate) order: Vec<u32>,
    /// Targets (`n`).
    pub(crate) targets: Vec<f64>,
    /// The distinct targets, ascending, and the distance of the first few from the next; 0 beyond the last.
    pub(crate) values: Vec<f64>,
    pub(crate) gaps: [f64; MOST_VALUES],
    /// Weight, weighted target and weighted square of each sample (`n`).
    pub(crate) sums: Vec<Sums>,
    /// Of every sample, where all are equal.
    pub(crate) weight: Option<f64>,
    /// What a square may lie above the true one.
    grain: f64,
    /// Power of two of which cost ranges are multiples, so that no sum of them is rounded.
    range_grid: f64,
    /// Bins of targets, for bounds.
    pub(crate) bins: Bins,
    /// Those of the error; None where it is squared.
    pub(crate) slopes: Option<Slopes>,
    /// Price of a split.
    pub(crate) penalty: f64,
    /// Fewest samples in a leaf.
    pub leaf_size: usize,
    /// The same with leaves of any size, where they have a least one.
    pub(crate) free: Option<Box<Samples>>,
}

impl Samples {
    /// Encode a question; features that are not allowed or constant are left out.
    pub(crate) fn new(question: &Question) -> Self {
        let n = question.n;
        let is_used = |f: &usize| question.allowed[*f] && question.n_ranks[*f] > 1;
        let features: Vec<u32> = (0..question.p).filter(is_used).map(|f| f as u32).collect();
        let (mut ranks, mut order) = (Vec::new(), Vec::new());
        for &f in &features {
            let f = f as usize;
            let own = &question.ranks[f * n..(f + 1) * n];
            order.extend(sorted_by_rank(own, question.n_ranks[f]));
            ranks.extend_from_slice(own);
        }
        let (target_ranks, values) = dense_ranks(&question.targets);
        order.extend(sorted_by_rank(&target_ranks, values.len() as u32));
        let sum = |i: usize| {
            let (weight, square) = (question.weights[i], question.squares[i]);
            Sums { weight, target: weight * question.targets[i], square }
        };
        let sums = (0..n).map(sum).collect();
        let range_grid = range_grid(question);
        let bins = Bins::of(&values, &target_ranks);
        let gaps = std::array::from_fn(|v| values.get(v + 1).map_or(0.0, |next| next - values[v]));
        ranks.extend(target_ranks);
        Self {
            n,
            p: features.len(),
            features,
            ranks,
            order,
            targets: question.targets.clone(),
            values,
            gaps,
            sums,
            weight: question.weights.first().copied().filter(|own| question.weights.iter().all(|w| w == own)),
            grain: question.grain,
            range_grid,
            bins,
            slopes: question.slopes,
            penalty: question.penalty,
            leaf_size: question.leaf_size,
            free: (question.leaf_size > 1).then(|| Box::new(Self::new(&Question { leaf_size: 1, ..question.clone() }))),
        }
    }

    /// The largest error of a sample under a prediction between two numbers on either side of it, rounded up.
    #[inline]
    pub(crate) fn error_range(&self, i: usize, low: f64, high: f64) -> f64 {
        let (above, below) = (self.targets[i] - low, high - self.targets[i]);
        let power = match self.slopes {
            Some(slopes) => slopes.most(below, above),
            None => above.max(below).powi(2),
        };
        ((self.sums[i].weight * power + self.grain) / self.range_grid).ceil() * self.range_grid + self.range_grid
    }

    /// Ranks of a usable feature; `p` gives those of the targets.
    pub(crate) fn ranks_of(&self, f: usize) -> &[u32] {
        &self.ranks[f * self.n..(f + 1) * self.n]
    }
}

/// A power of two such that the cost ranges of all samples together are fewer than 2^53 times it.
fn range_grid(question: &Question) -> f64 {
    let (low, high) =
        question.targets.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &y| (low.min(y), high.max(y)));
    let span = match question.slopes {
        Some(slopes) => slopes.most(high - low, high - low),
        None => (high - low) * (high - low),
    };
    let total = question.weights.iter().sum::<f64>() * span + question.grain * question.n as f64;
    2.0f64.powi((total.max(f64::MIN_POSITIVE).log2().ceil() as i32 - 50).max(-1000))
}

fn dense_ranks(values: &[f64]) -> (Vec<u32>, Vec<f64>) {
    let mut distinct = values.to_vec();
    distinct.sort_unstable_by(f64::total_cmp);
    distinct.dedup();
    let rank = |value: &f64| distinct.partition_point(|other| other < value) as u32;
    (values.iter().map(rank).collect(), distinct)
}

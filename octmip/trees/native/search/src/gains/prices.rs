//! The gain of every class on a sample, and the price of features in splits.

use octmip_check::problem::Problem;
use octmip_frame::costs::ClassCosts;

/// Gains of every class, and the highest cost of a sample.
#[derive(Debug)]
pub(crate) struct Prices {
    pub(super) n_classes: usize,
    /// `gains[y * n_classes + k]`.
    gains: Vec<i64>,
    /// The one class that gains, for each class of sample, where there is just one (0/1 costs): `(k, gain)`.
    pub(super) single: Option<Vec<(usize, i64)>>,
    labels: Vec<u32>,
    weights: Vec<i64>,
    pub(super) leaf_size: u32,
    /// Highest cost of each class of sample.
    highest_costs: Vec<i64>,
    /// Price of one feature in one split.
    penalty: i64,
    /// More than any tree of one leaf costs.
    above_all: i64,
}

impl Prices {
    /// The gains of a problem.
    pub(crate) fn new(problem: &Problem) -> Self {
        let k = problem.n_classes;
        let class_costs = ClassCosts::of(problem);
        let highest_costs: Vec<i64> = (0..k).map(|class| class_costs.most(class)).collect();
        let gains = (0..k).flat_map(|class| class_costs.gains(class).iter().copied()).collect();
        let single = (0..k).map(|class| class_costs.only_gain(class)).collect();
        let costs = problem
            .weights
            .iter()
            .zip(&problem.labels)
            .map(|(w, &label)| w.saturating_mul(highest_costs[label as usize]));
        let above_all = costs.fold(1_i64, i64::saturating_add).min(i64::MAX / 4);
        Self {
            n_classes: k,
            gains,
            single,
            labels: problem.labels.clone(),
            weights: problem.weights.clone(),
            leaf_size: problem.leaf_size as u32,
            highest_costs,
            penalty: problem.penalty,
            above_all,
        }
    }

    /// Price of so many features in splits; no more than makes a tree worse than one leaf, so that no sum overflows.
    pub(crate) fn price(&self, n_features: i64) -> i64 {
        self.penalty.saturating_mul(n_features).min(self.above_all)
    }

    /// Whether features in splits have a price.
    pub(crate) fn has_penalty(&self) -> bool {
        self.penalty > 0
    }

    /// The highest cost of a sample, on average over the samples.
    pub(crate) fn mean_cost(&self) -> f64 {
        (self.above_all - 1) as f64 / self.labels.len() as f64
    }

    /// The highest cost of a sample.
    pub(crate) fn highest_cost_of(&self, sample: u32) -> i64 {
        self.weights[sample as usize] * self.highest_costs[self.label(sample)]
    }

    /// Weight of a sample.
    pub(crate) fn weight(&self, sample: u32) -> i64 {
        self.weights[sample as usize]
    }

    /// Gain of predicting `k` for a sample.
    pub(crate) fn gain_of(&self, sample: u32, k: usize) -> i64 {
        self.weights[sample as usize] * self.gains[self.label(sample) * self.n_classes + k]
    }

    /// Add a sample's gain of every class, times a factor.
    pub(crate) fn add_gains(&self, sample: u32, factor: f64, gains: &mut [f64]) {
        let weighed = self.weighed(sample);
        let factor = factor * weighed.weight as f64;
        match &self.single {
            Some(single) => {
                let (class, gain) = single[weighed.label as usize];
                gains[class] += factor * gain as f64;
            }
            None => {
                let row = self.row(weighed.label);
                gains.iter_mut().zip(row).for_each(|(sum, &gain)| *sum += factor * gain as f64);
            }
        }
    }

    /// Class and weight of a sample.
    pub(crate) fn weighed(&self, sample: u32) -> Weighed {
        Weighed { label: self.labels[sample as usize], weight: self.weights[sample as usize] }
    }

    pub(super) fn row(&self, label: u32) -> &[i64] {
        &self.gains[label as usize * self.n_classes..][..self.n_classes]
    }

    /// Class of a sample.
    pub(crate) fn label(&self, sample: u32) -> usize {
        self.labels[sample as usize] as usize
    }
}

/// Class and weight of a sample.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Weighed {
    /// Class.
    pub(crate) label: u32,
    /// Risk weight.
    pub(crate) weight: i64,
}

//! The problem of a count: the exact core's samples, from which bounds come, beside the costs of every label.
//!
//! The core leaves out labels that no best tree needs and may count on a coarser grid. Here every label has its cost:
//!
//! ```text
//! cost of predicting label k for some samples = peak - gains[k],    gains >= 0
//! ```

use crate::cost::Cost;
use octmip_check::problem::Problem;
use octmip_exact::{Samples, Solved, Switches, View};

/// Most sensors that sets of sensors are told apart by.
pub const MOST_SENSORS: usize = 128;

/// Exact costs of a problem, and how the core's grid lies among them.
#[derive(Debug, Clone)]
pub struct ExactCosts<T> {
    /// Class of each sample; on the grid it may have a row of its own.
    pub classes: Vec<u32>,
    /// Weight of each sample.
    pub weights: Vec<T>,
    /// Cost of each label for one unit of weight of each class (`n_labels * n_labels`).
    pub costs: Vec<T>,
    /// Labels that may be predicted.
    pub n_labels: usize,
    /// Price of a split.
    pub penalty: T,
    /// A unit of the grid is `2^shift` units of these costs.
    pub shift: u32,
}

/// Costs of each label for some samples.
#[derive(Debug, Clone, Default)]
pub(crate) struct Totals<T> {
    /// What every label saves on the peak.
    pub(crate) gains: Vec<T>,
    /// Sum of the largest cost of each sample.
    pub(crate) peak: T,
    /// Sum of the smallest cost of each sample.
    pub(crate) base: T,
}

impl<T: Cost> Totals<T> {
    /// Cost of a leaf of this label.
    pub(crate) fn leaf(&self, label: usize) -> T {
        self.peak - self.gains[label]
    }
}

/// Samples, costs and sensors; read by all threads.
#[derive(Debug, Clone)]
pub struct Instance<T> {
    /// The exact core's samples.
    pub samples: Samples,
    /// Levels of splits.
    pub depth: usize,
    /// Labels that may be predicted.
    pub(crate) n_labels: usize,
    /// Price of a split.
    pub(crate) penalty: T,
    /// A unit of the core's grid is `2^shift` units of these costs.
    pub(crate) shift: u32,
    /// Whether each sample gains in one label only, that label and its gain (`n`).
    single: Option<Vec<(u32, T)>>,
    /// Gains of every label for each sample (`n * n_labels`); empty where `single`.
    gains: Vec<T>,
    /// Largest gain of each sample (`n`).
    pub(crate) ranges: Vec<T>,
    peaks: Vec<T>,
    bases: Vec<T>,
    /// Of each usable feature that ranks missing readings above all others, their rank.
    pub(crate) above: Vec<Option<u32>>,
    /// Set of the sensor of each usable feature; empty sets where they are not told apart.
    pub(crate) masks: Vec<u128>,
    /// Sensor of each usable feature.
    pub(crate) sensors: Vec<usize>,
    /// Number of sensors.
    pub n_sensors: usize,
    sensor_cost: Vec<f64>,
    sensor_limit: f64,
    is_limited: bool,
}

impl<T: Cost> Instance<T> {
    /// Join a validated problem with its exact costs; `above` lists the features that rank missing readings above all
    /// others, `by_sets` tells sets of sensors apart also without a budget.
    pub fn new(problem: &Problem, exact: &ExactCosts<T>, above: &[u32], by_sets: bool) -> Self {
        let samples = Samples::new(problem).beside_free(&Switches::default());
        let k = exact.n_labels;
        let rows: Vec<&[T]> = exact.costs.chunks(k).collect();
        let ends = |class: u32| {
            let row = rows[class as usize].iter().copied();
            (row.clone().min().unwrap_or_default(), row.max().unwrap_or_default())
        };
        let each = || exact.classes.iter().zip(&exact.weights);
        let gains: Vec<T> = each()
            .flat_map(|(&class, &weight)| rows[class as usize].iter().map(move |&cost| weight * (ends(class).1 - cost)))
            .collect();
        let is_single = |row: &[T]| row.iter().filter(|gain| **gain > T::default()).count() <= 1;
        let best = |row: &[T]| {
            let gain = row.iter().copied().max().unwrap_or_default();
            (row.iter().position(|other| *other == gain).unwrap_or(0) as u32, gain)
        };
        let ranges = gains.chunks(k).map(|row| best(row).1).collect();
        let single = gains.chunks(k).all(is_single).then(|| gains.chunks(k).map(best).collect());
        let is_limited = problem.sensor_cost.iter().sum::<f64>() > problem.sensor_limit;
        let mask = |f: &u32| if is_limited || by_sets { 1 << problem.sensor_of_feature[*f as usize] } else { 0 };
        let missing = |f: &u32| above.contains(f).then(|| problem.n_ranks[*f as usize] - 1);
        Self {
            above: samples.features.iter().map(missing).collect(),
            masks: samples.features.iter().map(mask).collect(),
            sensors: samples.features.iter().map(|&f| problem.sensor_of_feature[f as usize] as usize).collect(),
            n_sensors: problem.sensor_cost.len(),
            samples,
            depth: problem.depth,
            n_labels: k,
            penalty: exact.penalty,
            shift: exact.shift,
            gains: if single.is_some() { Vec::new() } else { gains },
            single,
            ranges,
            peaks: each().map(|(&class, &weight)| weight * ends(class).1).collect(),
            bases: each().map(|(&class, &weight)| weight * ends(class).0).collect(),
            sensor_cost: problem.sensor_cost.clone(),
            sensor_limit: problem.sensor_limit,
            is_limited,
        }
    }

    /// Add the gains of a sample.
    #[inline(always)]
    pub(crate) fn count(&self, sample: u32, gains: &mut [T]) {
        if let Some(single) = &self.single {
            let (label, gain) = single[sample as usize];
            gains[label as usize] += gain;
        } else {
            let start = sample as usize * self.n_labels;
            for (total, gain) in gains.iter_mut().zip(&self.gains[start..start + self.n_labels]) {
                *total += *gain;
            }
        }
    }

    /// Costs of each label for some samples.
    pub(crate) fn totals(&self, ids: impl Iterator<Item = u32>) -> Totals<T> {
        let mut totals = Totals { gains: vec![T::default(); self.n_labels], ..Totals::default() };
        for i in ids {
            self.count(i, &mut totals.gains);
            totals.peak += self.peaks[i as usize];
            totals.base += self.bases[i as usize];
        }
        totals
    }

    /// Costs of each label for all samples of a node.
    pub(crate) fn totals_of(&self, view: &View) -> Totals<T> {
        self.totals(view.ids(&self.samples))
    }

    /// Whether no other feature parts the samples of a node alike. Where no reading is missing, and between the missing
    /// ones and the others, the feature that ranks them below does.
    pub(crate) fn is_own(&self, view: &View, cut: &Solved) -> bool {
        let (list, ranks) = (view.list(cut.feature), self.samples.ranks_of(cut.feature));
        let is_missing = |position: usize| self.above[cut.feature] == Some(ranks[list[position] as usize]);
        self.above[cut.feature].is_none() || (is_missing(list.len() - 1) && !is_missing(cut.position))
    }

    /// Whether a set of sensors is within the budget.
    pub(crate) fn fits(&self, mask: u128) -> bool {
        if !self.is_limited {
            return true;
        }
        let read = self.sensor_cost.iter().enumerate().filter(|(sensor, _)| mask >> sensor & 1 == 1);
        read.map(|(_, cost)| cost).sum::<f64>() <= self.sensor_limit
    }

    /// What trees on the grid must cost less than, above the base, to cost `limit` at most.
    pub(crate) fn grid_limit(&self, limit: T, base: T) -> i64 {
        (limit - base).to_grid(self.shift) + 1
    }

    /// A bound on the grid, above the base, as a cost.
    pub(crate) fn bound(&self, lower: i64, base: T) -> T {
        base + T::from_grid(lower.max(0), self.shift)
    }
}

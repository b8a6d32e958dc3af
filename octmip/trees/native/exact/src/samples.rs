//! The problem as the exact core counts it: gains instead of costs.
//!
//! Every sample has a cost range, the largest cost that its prediction can add to its smallest, and gives each label
//! that is predicted for it a gain of `cost range - added cost`. Then
//!
//! ```text
//! cost of a leaf S = base(S) + range(S) - max over labels of gain(S, label)
//! ```
//!
//! and every bound reads as it does for counts of samples, with "number of samples" replaced by cost range:
//! adding a sample never lowers the cost of the best tree above the base, and raises it by at most its cost range.

pub(crate) mod directions;
mod few_values;
pub(crate) mod label_sets;
pub(crate) mod lists;
pub(crate) mod merging;
pub(crate) mod unit;

use std::sync::Arc;

use crate::samples::merging::{Merged, merged};
use crate::samples::unit::{common_divisor, rounded_up, unit};
use crate::switches::Switches;
use octmip_check::problem::Problem;
use octmip_frame::costs::ClassCosts;
use octmip_frame::ranks::sorted_by_rank;

use directions::doubled_spans;
use label_sets::LabelSets;

/// Samples, gains and limits; read by all threads.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Number of samples.
    pub n: usize,
    /// Number of usable features: allowed and not constant.
    pub p: usize,
    /// Number of labels worth predicting; no tree needs the others.
    pub n_labels: usize,
    /// The problem's index of each usable feature (`p`).
    pub features: Vec<u32>,
    /// Dense ranks, feature-major (`p * n`).
    pub(crate) ranks: Arc<Vec<u32>>,
    /// Sample ids in the order of each feature, ties by id (`p * n`); empty where they are made on demand.
    pub(crate) order: Arc<Vec<u32>>,
    /// Cost range of each sample (`n`).
    pub(crate) ranges: Vec<i64>,
    /// That of every sample, where it is the same.
    pub(crate) range_of_all: Option<i64>,
    /// Whether a feature has equal values (`p`).
    pub(crate) has_ties: Vec<bool>,
    /// Smallest cost of each sample, which no tree avoids (`n`).
    pub(crate) base: Vec<i64>,
    /// Whether every sample gains in one label only (0/1 costs with any weights, for instance).
    pub is_single: bool,
    /// Cost profile of each sample (`n`): where `is_single` the label that it gains in, else the row of `gains`.
    pub(crate) profile: Vec<u32>,
    /// Multiplicity of each sample in its profile (`n`): its gains are `multiplicity * gains[profile]`.
    pub(crate) multiplicity: Vec<i64>,
    /// Gains of one sample of each profile (`n_profiles * n_labels`).
    pub(crate) gains: Vec<i64>,
    /// Twice the span that is left of each profile beside each direction (`n_directions * n_profiles`); none where
    /// `is_single`.
    pub(crate) spans: Vec<i64>,
    /// Sets of 2, 4, 8, ... labels, as far as they bound anything; none where `is_single`.
    sets: Vec<Option<LabelSets>>,
    /// The problem's index of each label (`n_labels`).
    pub(crate) labels: Vec<u32>,
    /// Price of a split.
    pub(crate) penalty: i64,
    /// Fewest samples in a leaf.
    pub leaf_size: usize,
    /// What one unit of ranges, multiplicities and penalty is in the problem; the base is in the problem's own.
    pub(crate) unit: i64,
    /// Rows of the problem that each sample is (`n`), for a log, which counts those; none: one each.
    rows: Vec<u32>,
    /// What every tree of the problem costs more than these samples do, in the problem's own unit.
    pub(crate) avoided: i64,
    /// Number of values of each usable feature (`p`).
    pub(crate) values: Vec<usize>,
    /// Their sum.
    pub(crate) n_values: usize,
    /// Of each sample the cell of its value and label in each usable feature, where cells of all features stand one
    /// after the other (`n * p`); empty where they are more than the samples, or a split has no price.
    pub(crate) cells: Vec<u16>,
    /// The same with leaves of any size, where a search carries the bounds of that problem beside its own.
    pub(crate) free: Option<Box<Samples>>,
    /// What each sample costs in every tree, as equal ones have other labels (`n`); empty where that is nothing, or a
    /// split has no price.
    pub(crate) lost: Vec<i64>,
}

/// Most runs of values, one of each feature, of samples that have few.
const MOST_BOXES: f64 = 131_072.0;

/// Levels that trees on so many samples may have: every level needs one more leaf of the least size.
pub(crate) fn levels_of(len: usize, leaf_size: usize) -> usize {
    (len / leaf_size).max(1) - 1
}

impl Samples {
    /// Encode a validated problem; features that are not allowed or constant are left out.
    pub fn new(problem: &Problem) -> Self {
        let samples = Self::without_order(problem);
        let mut order = Vec::with_capacity(samples.p * samples.n);
        for (f, &feature) in samples.features.iter().enumerate() {
            order.extend(sorted_by_rank(samples.ranks_of(f), problem.n_ranks[feature as usize]));
        }
        Self { order: Arc::new(order), ..samples }
    }

    /// The same without the samples in the order of each feature.
    pub(crate) fn without_order(problem: &Problem) -> Self {
        let features: Vec<u32> =
            (0..problem.p).filter(|&f| problem.allowed[f] && problem.n_ranks[f] > 1).map(|f| f as u32).collect();
        let n = problem.n;
        // The ranks of a large problem are not copied where every feature is usable.
        let ranks = if features.len() == problem.p {
            problem.ranks.clone()
        } else {
            Arc::new(features.iter().flat_map(|&f| problem.feature(f as usize)).copied().collect())
        };
        let values: Vec<usize> = features.iter().map(|&f| problem.n_ranks[f as usize] as usize).collect();
        let mut samples = Self {
            n,
            p: features.len(),
            n_values: values.iter().sum(),
            values,
            features,
            ranks,
            is_single: true,
            penalty: problem.penalty,
            leaf_size: problem.leaf_size,
            unit: 1,
            ..Self::default()
        };
        for f in 0..samples.p {
            let mut is_met = vec![false; samples.values[f]];
            let mut is_again = |&rank: &u32| std::mem::replace(&mut is_met[rank as usize], true);
            samples.has_ties.push(samples.values[f] < n || samples.ranks_of(f).iter().any(&mut is_again));
        }
        samples.set_gains(problem);
        if samples.is_single && samples.penalty > 0 {
            samples.set_lost(problem);
            samples.set_cells();
        }
        samples
    }

    /// The same counted in the largest unit that all costs above the base are multiples of.
    pub(crate) fn in_units_of(mut self, problem: &Problem) -> Self {
        self.unit = unit(problem, &ClassCosts::of(problem));
        self.ranges
            .iter_mut()
            .chain(&mut self.multiplicity)
            .chain(&mut self.lost)
            .for_each(|count| *count /= self.unit);
        self.penalty /= self.unit;
        self.range_of_all = self.ranges.first().copied().filter(|first| self.ranges.iter().all(|range| range == first));
        self
    }

    /// The same beside their free problem, in which leaves may have any size (`node::beside`).
    pub fn beside_free(mut self, switches: &Switches) -> Self {
        if self.leaf_size > 1 && switches.free {
            let mut free = Self { leaf_size: 1, ..self.clone() };
            if free.is_single && free.penalty > 0 {
                free.set_cells();
            }
            self.free = Some(Box::new(free));
        }
        self
    }

    /// The samples of a log. Its records name the levels that are asked for: where leaves are too large for these, no
    /// free problem stands beside.
    pub(crate) fn of_log(problem: &Problem, switches: &Switches) -> Self {
        let samples = Self::in_few_rows(problem, switches);
        let has_room = levels_of(problem.n, problem.leaf_size) >= problem.depth;
        if has_room { samples.beside_free(switches) } else { samples }
    }

    /// Cost range of a sample.
    #[inline(always)]
    pub(crate) fn range_of(&self, sample: u32) -> i64 {
        self.range_of_all.unwrap_or_else(|| self.ranges[sample as usize])
    }

    /// A cost above the base in the problem's own unit.
    pub(crate) fn cost(&self, cost: i64) -> i64 {
        cost * self.unit
    }

    /// A cost above the base as it is counted here, rounded up where it is between two: no tree costs less than the one
    /// and not less than the other.
    pub(crate) fn counted(&self, cost: i64) -> i64 {
        rounded_up(cost, self.unit)
    }

    /// The samples of a problem, equal ones merged where that is on.
    pub(crate) fn in_few_rows(problem: &Problem, switches: &Switches) -> Self {
        let smaller = if switches.merging { merged(problem, switches.cancelling) } else { None };
        match smaller {
            Some(Merged { problem, rows, avoided }) => {
                Self { rows, avoided, ..Self::new(&problem).in_units_of(&problem) }
            }
            None => Self::new(problem).in_units_of(problem),
        }
    }

    /// What no tree avoids, in the problem's own unit.
    pub(crate) fn base_cost(&self) -> i64 {
        self.base.iter().sum::<i64>() + self.avoided
    }

    /// Rows of the problem among the first so many samples of a list, for each of some cuts.
    pub(crate) fn rows_left(&self, list: &[u32], cuts: &mut [u32]) {
        if self.rows.is_empty() {
            return;
        }
        let mut before = Vec::with_capacity(list.len() + 1);
        before.push(0);
        before.extend(list.iter().scan(0, |sum, &i| {
            *sum += self.rows[i as usize];
            Some(*sum)
        }));
        cuts.iter_mut().for_each(|cut| *cut = before[*cut as usize]);
    }

    fn set_gains(&mut self, problem: &Problem) {
        let k = problem.n_classes;
        let costs = ClassCosts::of(problem);
        let mut has_samples = vec![false; k];
        for i in 0..self.n {
            let class = problem.labels[i] as usize;
            has_samples[class] |= problem.weights[i] > 0;
            self.ranges.push(problem.weights[i] * costs.range(class));
            self.base.push(problem.weights[i] * costs.base(class));
        }
        // A label that gains no more than another in any present class (the first of equals stays) is never needed.
        let present: Vec<usize> = (0..k).filter(|&class| has_samples[class]).collect();
        let is_covered = |label: usize, by: usize| {
            let differs = present.iter().any(|&class| costs.gain(class, label) != costs.gain(class, by));
            (differs || by < label) && present.iter().all(|&class| costs.gain(class, label) <= costs.gain(class, by))
        };
        // Of thousands of labels hardly one is left for the comparison of pairs, which costs k^3.
        let mut is_needed = vec![false; k];
        present.iter().filter_map(|&class| costs.sole_best(class)).for_each(|label| is_needed[label] = true);
        let is_kept = |&label: &usize| is_needed[label] || !(0..k).any(|by| is_covered(label, by));
        self.labels = (0..k).filter(is_kept).map(|label| label as u32).collect();
        self.n_labels = self.labels.len();
        self.set_profiles(problem, &has_samples, &costs);
    }

    /// Classes whose gains are in proportion share a cost profile: cost matrices have few, however many classes there
    /// are.
    fn set_profiles(&mut self, problem: &Problem, has_samples: &[bool], costs: &ClassCosts) {
        let rows: Vec<Vec<i64>> = (0..problem.n_classes)
            .map(|class| self.labels.iter().map(|&label| costs.gain(class, label as usize)).collect())
            .collect();
        let is_row_single = |row: &Vec<i64>| row.iter().filter(|&&gain| gain > 0).count() <= 1;
        self.is_single = (0..rows.len()).filter(|&class| has_samples[class]).all(|class| is_row_single(&rows[class]));
        let mut profiles: Vec<Vec<i64>> = Vec::new();
        if self.is_single {
            profiles = (0..self.n_labels).map(|c| (0..self.n_labels).map(|d| i64::from(c == d)).collect()).collect();
        }
        let mut of_class = vec![(0, 0); rows.len()];
        for class in (0..rows.len()).filter(|&class| has_samples[class]) {
            let factor = rows[class].iter().fold(0, |a, &b| common_divisor(a, b));
            if factor > 0 {
                let row: Vec<i64> = rows[class].iter().map(|gain| gain / factor).collect();
                let known = if self.is_single {
                    row.iter().position(|&gain| gain > 0)
                } else {
                    profiles.iter().position(|known| *known == row)
                };
                let profile = known.unwrap_or(profiles.len());
                if profile == profiles.len() {
                    profiles.push(row);
                }
                of_class[class] = (profile as u32, factor);
            }
        }
        for i in 0..self.n {
            let (profile, factor) = of_class[problem.labels[i] as usize];
            self.profile.push(profile);
            self.multiplicity.push(problem.weights[i] * factor);
        }
        self.gains = profiles.concat();
        if !self.is_single {
            self.set_bounds();
        }
    }

    /// What bounds samples of profiles that gain in several labels.
    fn set_bounds(&mut self) {
        self.spans = doubled_spans(&self.gains, self.n_labels);
        let sizes = (1..self.n_labels).map(|level| 1 << level).take_while(|&size| size < self.n_labels);
        self.sets = sizes.map(|size| LabelSets::new(&self.gains, self.n_labels, size)).collect();
    }

    /// The sets of as many labels as a child of this many leaves may predict, where they bound anything.
    pub(crate) fn label_sets(&self, n_leaves: usize) -> Option<&LabelSets> {
        self.sets.get((n_leaves.max(2).next_power_of_two().ilog2() - 1) as usize)?.as_ref()
    }

    /// Number of cost profiles.
    pub(crate) fn n_profiles(&self) -> usize {
        self.gains.len() / self.n_labels
    }

    /// Gains of one sample of a profile (`n_labels`).
    pub(crate) fn gains_of(&self, profile: usize) -> &[i64] {
        &self.gains[profile * self.n_labels..(profile + 1) * self.n_labels]
    }

    /// The same samples with only these of the usable features.
    pub(crate) fn with_features(&self, usable: &[usize]) -> Self {
        let mut samples = self.picked(usable);
        if !self.cells.is_empty() {
            samples.set_cells();
        }
        samples
    }

    fn picked(&self, usable: &[usize]) -> Self {
        let pick = |lists: &[u32]| -> Arc<Vec<u32>> {
            Arc::new(usable.iter().flat_map(|&f| lists[f * self.n..(f + 1) * self.n].iter().copied()).collect())
        };
        Self {
            p: usable.len(),
            features: usable.iter().map(|&f| self.features[f]).collect(),
            values: usable.iter().map(|&f| self.values[f]).collect(),
            n_values: usable.iter().map(|&f| self.values[f]).sum(),
            cells: Vec::new(),
            free: self.free.as_ref().map(|free| Box::new(free.with_features(usable))),
            lost: self.lost.clone(), // fewer features part no more samples
            ranks: pick(&self.ranks),
            order: pick(&self.order),
            ranges: self.ranges.clone(),
            has_ties: usable.iter().map(|&f| self.has_ties[f]).collect(),
            base: self.base.clone(),
            profile: self.profile.clone(),
            multiplicity: self.multiplicity.clone(),
            gains: self.gains.clone(),
            spans: self.spans.clone(),
            sets: self.sets.clone(),
            labels: self.labels.clone(),
            rows: self.rows.clone(),
            ..*self
        }
    }

    /// Whether cuts part the samples in so few ways that a search soon meets each set again: by the runs of values, one
    /// of each feature.
    pub(crate) fn has_few_boxes(&self) -> bool {
        let runs = self.values.iter().map(|&values| values as f64 * (values as f64 + 1.0) / 2.0);
        runs.product::<f64>() <= MOST_BOXES
    }

    /// The ranks of one usable feature, by sample.
    pub fn ranks_of(&self, f: usize) -> &[u32] {
        &self.ranks[f * self.n..(f + 1) * self.n]
    }

    /// Add (`sign` 1) or take away (-1) the gains of a sample.
    #[inline(always)]
    pub(crate) fn count(&self, sample: u32, sign: i64, totals: &mut [i64]) {
        let i = sample as usize;
        let (profile, multiplicity) = (self.profile[i] as usize, sign * self.multiplicity[i]);
        if self.is_single {
            totals[profile] += multiplicity;
        } else {
            for (total, gain) in totals.iter_mut().zip(self.gains_of(profile)) {
                *total += multiplicity * gain;
            }
        }
    }
}

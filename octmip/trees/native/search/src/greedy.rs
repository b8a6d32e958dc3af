//! Greedy trees, with which restarts begin: built top down, each split the purest of those tried.

use crate::axis::scan::{Aim, best_cut};
use crate::gains::tally::{Tally, Worth};
use crate::logistic::regression::{MOST_FITTED, PreferredSide, fit};
use crate::prepared::Prepared;
use crate::prepared::orders::NodeOrder;
use crate::tree::allowance::Allowance;
use crate::tree::rule::Rule;
use crate::tree::state::State;
use crate::tree::view::NodeView;

/// The splits that a greedy tree is built from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BuildOptions {
    /// Share of the features that each split may look at.
    pub(crate) share: f64,
    /// Whether hyperplanes are tried beside axis-aligned cuts.
    pub(crate) has_planes: bool,
}

/// The builder of greedy trees.
pub(crate) struct GreedyBuilder<'a> {
    prepared: &'a Prepared<'a>,
    view: NodeView,
    tally: Tally<'a>,
    node_order: NodeOrder,
}

/// Groupings of the classes that one split tries.
const MOST_GROUPINGS: usize = 12;
/// Samples that a logistic fit looks at.
const MOST_FITTED_SAMPLES: usize = 2000;
const RIDGE: f64 = 1e-3;

impl<'a> GreedyBuilder<'a> {
    /// A builder on a problem.
    pub(crate) fn new(prepared: &'a Prepared<'a>) -> Self {
        let tally = Tally::new(&prepared.prices);
        Self { prepared, view: NodeView::default(), tally, node_order: NodeOrder::default() }
    }

    /// Build a tree of at most `levels` levels of splits in the place of leaf `v`.
    pub(crate) fn build(
        &mut self,
        state: &mut State,
        v: u32,
        levels: usize,
        options: BuildOptions,
        rng: &mut fastrand::Rng,
        keep_going: &dyn Fn() -> bool,
    ) {
        let mut stack = vec![(v, levels)];
        while let Some((v, levels)) = stack.pop() {
            if levels == 0 || !keep_going() {
                continue;
            }
            if let Some(rule) = self.purest(state, v, options, rng, keep_going) {
                let [left, right] = state.split(self.prepared.problem, v, rule);
                stack.extend([(right, levels - 1), (left, levels - 1)]);
            }
        }
    }

    fn purest(
        &mut self,
        state: &State,
        v: u32,
        options: BuildOptions,
        rng: &mut fastrand::Rng,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Rule> {
        let problem = self.prepared.problem;
        let allowance = Allowance::at(problem, state, v);
        let features = some(allowance.axis_features(), options.share, rng);
        self.view.look(problem, &self.prepared.prices, state, v);
        let present = self.view.present(&mut self.tally, 0);
        let scratch = (&mut self.tally, &mut self.node_order);
        let cut =
            best_cut(problem, &self.prepared.orders, &self.view, &features, (Aim::Purity, present), scratch, go_on);
        if !options.has_planes {
            return cut.map(|found| found.0);
        }
        let (mut rule, mut best) = cut.map_or((None, present), |(rule, worth)| (Some(rule), worth));
        for group in self.groupings(rng) {
            if let Some((plane, worth)) = self.parting(&group, &allowance, options, rng, go_on)
                && worth.purity > best.purity
            {
                (rule, best) = (Some(plane), worth);
            }
        }
        rule
    }

    /// Groups of classes that should go right: those above each class in order, and each class by itself.
    fn groupings(&self, rng: &mut fastrand::Rng) -> Vec<Vec<bool>> {
        let n_classes = self.prepared.problem.n_classes;
        let mut is_present = vec![false; n_classes];
        self.view.samples.iter().for_each(|&i| is_present[self.prepared.prices.label(i)] = true);
        let classes: Vec<usize> = (0..n_classes).filter(|&k| is_present[k]).collect();
        let above = classes.iter().skip(1).map(|&c| (0..n_classes).map(|k| k >= c).collect());
        let mut groups: Vec<Vec<bool>> = above.collect();
        if classes.len() > 2 {
            groups.extend(classes.iter().map(|&c| (0..n_classes).map(|k| k == c).collect()));
        }
        if groups.len() > MOST_GROUPINGS {
            rng.shuffle(&mut groups);
            groups.truncate(MOST_GROUPINGS);
        }
        groups
    }

    /// The hyperplane that parts a group of classes from the others, and its worth.
    fn parting(
        &mut self,
        group: &[bool],
        allowance: &Allowance,
        options: BuildOptions,
        rng: &mut fastrand::Rng,
        go_on: &dyn Fn() -> bool,
    ) -> Option<(Rule, Worth)> {
        let problem = self.prepared.problem;
        let sides = self.preferred_sides(group, rng);
        let share = options.share.min(MOST_FITTED as f64 / problem.p as f64);
        let all = some((0..problem.p as u32).collect(), share, rng);
        let features = self.leading(&sides, all, allowance, go_on)?;
        let (normal, offset) = fit(&self.prepared.values, &sides, &features, RIDGE, go_on)?;
        let terms: Vec<(u32, f64)> = features.into_iter().zip(normal).filter(|term| term.1 != 0.0).collect();
        let rule = self.prepared.values.rule(&terms, offset, 0)?;
        self.view.fill(&mut self.tally, |j| rule.goes_left(problem, self.view.samples[j]));
        let is_split = self.tally.is_large_enough() && self.tally.has_two_sides();
        is_split.then(|| (rule, Worth { gain: self.tally.total, purity: self.tally.purity() }))
    }

    fn preferred_sides(&self, group: &[bool], rng: &mut fastrand::Rng) -> Vec<PreferredSide> {
        let prices = &self.prepared.prices;
        let of_sample = |&sample: &u32| {
            let weight = prices.weight(sample) as f64;
            PreferredSide { sample, goes_right: group[prices.label(sample)], weight }
        };
        let mut sides: Vec<PreferredSide> = self.view.samples.iter().map(of_sample).collect();
        if sides.len() > MOST_FITTED_SAMPLES {
            rng.shuffle(&mut sides);
            sides.truncate(MOST_FITTED_SAMPLES);
        }
        sides
    }

    /// The features that weigh most in a fit over all of them, as many as one split may read.
    fn leading(
        &self,
        sides: &[PreferredSide],
        all: Vec<u32>,
        allowance: &Allowance,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Vec<u32>> {
        let size = self.prepared.split_size();
        let admitted = allowance.first_admitted(&all, size);
        if admitted.len() == all.len() {
            return Some(admitted);
        }
        let (normal, _) = fit(&self.prepared.values, sides, &all, RIDGE, go_on)?;
        let weight = |position: &usize| normal[*position].abs() * self.prepared.deviations[all[*position] as usize];
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
        let ranked: Vec<u32> = order.into_iter().map(|position| all[position]).collect();
        Some(allowance.first_admitted(&ranked, size))
    }
}

/// A random share of a list, at least one of it, ascending.
fn some(mut features: Vec<u32>, share: f64, rng: &mut fastrand::Rng) -> Vec<u32> {
    if share < 1.0 && !features.is_empty() {
        rng.shuffle(&mut features);
        features.truncate(((features.len() as f64 * share).ceil() as usize).max(1));
        features.sort_unstable();
    }
    features
}

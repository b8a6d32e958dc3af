//! The best line over a pair of features, the rest of the tree fixed: the depth-1 solver of `two_feature` as a move.

use crate::planes::plane_search::PlaneSearch;
use crate::prepared::dual_planes::{DualPlanes, PairQuestion};
use crate::tree::allowance::Allowance;
use crate::tree::view::NodeView;
use octmip_two_feature::Line;

/// Samples that the pairs of one visit may look at together, and pairs at most.
const MOST_SAMPLES: usize = 6000;
const MOST_PAIRS: usize = 4;
/// One visit in so many tries pairs where nothing else helped.
const EXACT_ONE_IN: u32 = 2;

impl PlaneSearch<'_> {
    /// Try the best lines over a few random pairs of features; the gain never falls.
    pub(crate) fn try_exact_pairs(&mut self, view: &NodeView, allowance: &Allowance, rng: &mut fastrand::Rng) {
        if self.prepared.split_size() != 2 || rng.u32(..EXACT_ONE_IN) > 0 {
            return;
        }
        let Some(dual_planes) = self.prepared.dual_planes() else {
            return;
        };
        let n_pairs = (MOST_SAMPLES / view.samples.len().max(1)).clamp(1, MOST_PAIRS);
        for _ in 0..n_pairs {
            if !self.supervisor.goes_on() {
                return;
            }
            let Some([f, g]) = self.random_pair(allowance, rng) else {
                continue;
            };
            let line = if view.n_slots() == 2 {
                self.best_of_leaves(dual_planes, view, (f, g))
            } else {
                self.best_of_sides(dual_planes, view, (f, g))
            };
            if let Some((terms, offset)) = line.and_then(|line| self.as_plane(dual_planes, view, &line)) {
                self.try_plane(view, &terms, offset, rng);
            }
        }
    }

    /// Two leaves: their labels are free.
    fn best_of_leaves(&self, dual_planes: &DualPlanes, view: &NodeView, pair: (usize, usize)) -> Option<Line> {
        let (problem, prices) = (self.prepared.problem, &self.prepared.prices);
        let highest: i64 = view.samples.iter().map(|&i| prices.highest_cost_of(i)).sum();
        let asked = PairQuestion {
            ids: &view.samples,
            labels: &problem.labels,
            weights: &dual_planes.weights,
            loss: &dual_planes.loss,
            need: problem.leaf_size as i64,
            cutoff: highest - self.gain(),
        };
        dual_planes.best_line(pair, asked, &self.supervisor.watch.is_stopped)
    }

    /// More leaves, which keep their labels: each sample prefers the side that serves it better, by the difference.
    fn best_of_sides(&mut self, dual_planes: &DualPlanes, view: &NodeView, pair: (usize, usize)) -> Option<Line> {
        let prices = &self.prepared.prices;
        let leaf_labels: Vec<u32> = (0..view.n_slots() as u32).map(|slot| self.tally.label(slot)).collect();
        let (labels, weights) = (&mut self.preferred.0, &mut self.preferred.1);
        labels.resize(self.prepared.problem.n, 0);
        weights.resize(self.prepared.problem.n, 0);
        let mut cutoff = 0;
        for ((&i, member), is_left) in view.samples.iter().zip(&view.members).zip(&self.plane.is_left) {
            let gain = member.slots.map(|slot| prices.gain_of(i, leaf_labels[slot as usize] as usize));
            let goes_right = gain[1] > gain[0];
            labels[i as usize] = u32::from(goes_right);
            weights[i as usize] = (gain[1] - gain[0]).abs();
            cutoff += if *is_left == goes_right { weights[i as usize] } else { 0 };
        }
        let asked = PairQuestion { ids: &view.samples, labels, weights, loss: &dual_planes.sides, need: 1, cutoff };
        dual_planes.best_line(pair, asked, &self.supervisor.watch.is_stopped)
    }

    /// A line as terms and offset in mid-gap, its sides as the samples prefer them.
    fn as_plane(&self, dual_planes: &DualPlanes, view: &NodeView, line: &Line) -> Option<(Vec<(u32, f64)>, f64)> {
        let (f, g) = line.features;
        let coefficients = dual_planes.coefficients(line);
        let sign = if self.prefers_sides_swapped(dual_planes, view, line) { -1.0 } else { 1.0 };
        let mut terms = vec![(f as u32, sign * coefficients[0]), (g as u32, sign * coefficients[1])];
        terms.retain(|term| term.1 != 0.0);
        terms.sort_unstable_by_key(|term| term.0);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for &i in &view.samples {
            let height = self.prepared.values.project(&terms, i);
            if dual_planes.sends_left(line, i) == (sign > 0.0) {
                low = low.max(height)
            } else {
                high = high.min(height)
            }
        }
        (low < high).then_some((terms, low / 2.0 + high / 2.0)).filter(|plane| plane.1.is_finite())
    }

    /// Whether the samples gain more when those left of a line go right.
    fn prefers_sides_swapped(&self, dual_planes: &DualPlanes, view: &NodeView, line: &Line) -> bool {
        if view.n_slots() == 2 {
            return false;
        }
        let (labels, weights) = (&self.preferred.0, &self.preferred.1);
        let agreement = |&i: &u32| {
            let is_well = dual_planes.sends_left(line, i) == (labels[i as usize] == 0);
            if is_well { weights[i as usize] } else { -weights[i as usize] }
        };
        view.samples.iter().map(agreement).sum::<i64>() < 0
    }
}

//! One plane while it is soft: its features, its steps, and the hard plane that it becomes.

use crate::prepared::Prepared;
use crate::soft_tree::schedule::{Reselection, Schedule};
use crate::tree::allowance::Allowance;
use crate::tree::rule::Rule;
use crate::tree::state::State;

const MOMENTUM: f32 = 0.9;
const SPREAD: f32 = 0.98;

/// One soft plane; the last entry of its vectors stands for `-offset`.
pub(crate) struct SoftPlane {
    /// Its node.
    pub(crate) v: u32,
    plane: Vec<f32>,
    is_active: Vec<bool>,
    length: f32,
    /// Gradient of the expected gain.
    pub(crate) gradient: Vec<f32>,
    momentum: Vec<f32>,
    spread: Vec<f32>,
}

impl SoftPlane {
    /// The plane of a node, its features active or not as the schedule says.
    pub(crate) fn new(prepared: &Prepared, state: &State, v: u32, schedule: Schedule, rng: &mut fastrand::Rng) -> Self {
        let p = prepared.problem.p;
        let is_reselected = schedule.reselection == Reselection::All || schedule.reselection == Reselection::One(v);
        let (mut plane, mut is_active) = (vec![0.0; p + 1], vec![is_reselected; p + 1]);
        let (terms, offset) = prepared.plane_of(&state.nodes[v as usize].rule).unwrap_or_default();
        let mut intercept = -offset;
        for &(f, c) in &terms {
            let f = f as usize;
            plane[f] = (c * prepared.deviations[f]) as f32;
            intercept += c * prepared.means[f];
            is_active[f] = true;
        }
        if !is_reselected {
            let support: Vec<u32> = terms.iter().map(|term| term.0).collect();
            let first = support.len();
            let mut order = support;
            order.extend((0..p as u32).filter(|&f| !is_active[f as usize]));
            rng.shuffle(&mut order[first..]);
            let allowance = Allowance::at(prepared.problem, state, v);
            allowance.first_admitted(&order, prepared.split_size()).iter().for_each(|&f| is_active[f as usize] = true);
        }
        plane[p] = intercept as f32;
        is_active[p] = true;
        // Heights of a node's own samples have unit spread, so that one inverse temperature means the same
        // in every node.
        let spread = spread_of_heights(prepared, &plane, &state.samples(v));
        plane.iter_mut().for_each(|c| *c /= spread);
        let length = plane[..p].iter().map(|c| c * c).sum::<f32>().sqrt();
        let zeros = vec![0.0; p + 1];
        Self { v, plane, is_active, length, gradient: zeros.clone(), momentum: zeros.clone(), spread: zeros }
    }

    /// Height of a standardised sample.
    pub(crate) fn height(&self, z: &[f32]) -> f32 {
        dot(&self.plane[..z.len()], z) + self.plane[z.len()]
    }

    /// Add a sample's gradient.
    pub(crate) fn add_gradient(&mut self, z: &[f32], slope: f32) {
        self.gradient.iter_mut().zip(z).for_each(|(g, z)| *g += slope * z);
        self.gradient[z.len()] += slope;
    }

    /// One step of Adam upwards, the normal's length held.
    pub(crate) fn advance(&mut self, step: f32, n_before: usize) {
        let n = n_before as i32 + 1;
        let (fade, fade_spread) = (1.0 - MOMENTUM.powi(n), 1.0 - SPREAD.powi(n));
        let size = step * self.length / (self.plane.len() as f32).sqrt();
        for f in 0..self.plane.len() {
            if !self.is_active[f] {
                continue;
            }
            let g = self.gradient[f];
            self.momentum[f] = MOMENTUM * self.momentum[f] + (1.0 - MOMENTUM) * g;
            self.spread[f] = SPREAD * self.spread[f] + (1.0 - SPREAD) * g * g;
            let root = (self.spread[f] / fade_spread).sqrt();
            if root > 0.0 {
                self.plane[f] += size * (self.momentum[f] / fade) / root;
            }
        }
        self.rescale();
    }

    fn rescale(&mut self) {
        let last = self.plane.len() - 1;
        let now = self.plane[..last].iter().map(|c| c * c).sum::<f32>().sqrt();
        if now > 0.0 {
            self.plane.iter_mut().for_each(|c| *c *= self.length / now);
        }
    }

    /// Keep so many leading features; those that one split may read together once that is all that is left.
    pub(crate) fn keep_leading(&mut self, prepared: &Prepared, state: &State, size: usize) {
        let last = self.plane.len() - 1;
        let mut order: Vec<u32> = (0..last as u32).filter(|&f| self.is_active[f as usize]).collect();
        let is_final = size <= prepared.split_size();
        if order.len() <= size && !is_final {
            return;
        }
        order.sort_by(|&a, &b| self.plane[b as usize].abs().total_cmp(&self.plane[a as usize].abs()));
        let mut kept = if is_final {
            Allowance::at(prepared.problem, state, self.v).first_admitted(&order, size)
        } else {
            order.into_iter().take(size).collect()
        };
        kept.sort_unstable();
        for f in 0..last {
            self.is_active[f] = kept.binary_search(&(f as u32)).is_ok();
            if !self.is_active[f] {
                self.plane[f] = 0.0;
            }
        }
        self.rescale();
    }

    /// The plane over the values as given.
    pub(crate) fn rule(&self, prepared: &Prepared) -> Option<Rule> {
        let last = self.plane.len() - 1;
        let raw = |f: usize| f64::from(self.plane[f]) / prepared.deviations[f];
        let terms: Vec<(u32, f64)> = (0..last).filter(|&f| self.plane[f] != 0.0).map(|f| (f as u32, raw(f))).collect();
        let shift: f64 = terms.iter().map(|&(f, c)| c * prepared.means[f as usize]).sum();
        let offset = shift - f64::from(self.plane[last]);
        let is_finite = offset.is_finite() && terms.iter().all(|term| term.1.is_finite());
        if is_finite { prepared.values.rule(&terms, offset, 0) } else { None }
    }
}

fn spread_of_heights(prepared: &Prepared, plane: &[f32], samples: &[u32]) -> f32 {
    let (mut sum, mut square) = (0.0, 0.0);
    for &i in samples {
        let z = prepared.standardised(i);
        let height = dot(&plane[..z.len()], z);
        sum += height;
        square += height * height;
    }
    let n = samples.len().max(1) as f32;
    let variance = square / n - (sum / n) * (sum / n);
    if variance > 1e-12 { variance.sqrt() } else { 1.0 }
}

/// Dot product in eight running sums, which the compiler turns into vector instructions.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f32 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a_chunks.zip(b_chunks) {
        (0..8).for_each(|k| sums[k] += x[k] * y[k]);
    }
    sums.iter().sum::<f32>() + rest
}

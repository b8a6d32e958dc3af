//! One plane while it is soft: its features, its steps, and the hard plane that it becomes.

use crate::search::prepared::Ground;
use crate::search::soft_tree::schedule::{Heat, Opening};
use crate::search::tree::allowance::Room;
use crate::search::tree::rule::Rule;
use crate::search::tree::state::State;

const MOMENTUM: f32 = 0.9;
const SPREAD: f32 = 0.98;

/// One soft plane; the last entry of its vectors stands for `-offset`.
pub(crate) struct Soft {
    /// Its node.
    pub(crate) v: u32,
    plane: Vec<f32>,
    is_open: Vec<bool>,
    length: f32,
    /// Of the expected gain.
    pub(crate) gradient: Vec<f32>,
    momentum: Vec<f32>,
    spread: Vec<f32>,
}

impl Soft {
    /// The plane of a node, its features open or closed as the heat says.
    pub(crate) fn new(ground: &Ground, state: &State, v: u32, heat: Heat, rng: &mut fastrand::Rng) -> Self {
        let p = ground.problem.p;
        let is_opened = heat.opening == Opening::All || heat.opening == Opening::One(v);
        let (mut plane, mut is_open) = (vec![0.0; p + 1], vec![is_opened; p + 1]);
        let (terms, offset) = ground.plane_of(&state.nodes[v as usize].rule).unwrap_or_default();
        let mut intercept = -offset;
        for &(f, c) in &terms {
            let f = f as usize;
            plane[f] = (c * ground.deviations[f]) as f32;
            intercept += c * ground.means[f];
            is_open[f] = true;
        }
        if !is_opened {
            let support: Vec<u32> = terms.iter().map(|term| term.0).collect();
            let first = support.len();
            let mut order = support;
            order.extend((0..p as u32).filter(|&f| !is_open[f as usize]));
            rng.shuffle(&mut order[first..]);
            let room = Room::at(ground.problem, state, v);
            room.first_admitted(&order, ground.split_size()).iter().for_each(|&f| is_open[f as usize] = true);
        }
        plane[p] = intercept as f32;
        is_open[p] = true;
        // Heights of a node's own samples have unit spread, so that one sharpness means the same in every node.
        let spread = spread_of_heights(ground, &plane, &state.samples(v));
        plane.iter_mut().for_each(|c| *c /= spread);
        let length = plane[..p].iter().map(|c| c * c).sum::<f32>().sqrt();
        let zeros = vec![0.0; p + 1];
        Self { v, plane, is_open, length, gradient: zeros.clone(), momentum: zeros.clone(), spread: zeros }
    }

    /// Height of a standardised sample.
    pub(crate) fn height(&self, z: &[f32]) -> f32 {
        dot(&self.plane[..z.len()], z) + self.plane[z.len()]
    }

    /// Add a sample's gradient.
    pub(crate) fn pull(&mut self, z: &[f32], pull: f32) {
        self.gradient.iter_mut().zip(z).for_each(|(g, z)| *g += pull * z);
        self.gradient[z.len()] += pull;
    }

    /// One step of Adam upwards, the normal's length held.
    pub(crate) fn advance(&mut self, step: f32, n_before: usize) {
        let n = n_before as i32 + 1;
        let (fade, fade_spread) = (1.0 - MOMENTUM.powi(n), 1.0 - SPREAD.powi(n));
        let size = step * self.length / (self.plane.len() as f32).sqrt();
        for f in 0..self.plane.len() {
            if !self.is_open[f] {
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
    pub(crate) fn close(&mut self, ground: &Ground, state: &State, size: usize) {
        let last = self.plane.len() - 1;
        let mut order: Vec<u32> = (0..last as u32).filter(|&f| self.is_open[f as usize]).collect();
        let is_final = size <= ground.split_size();
        if order.len() <= size && !is_final {
            return;
        }
        order.sort_by(|&a, &b| self.plane[b as usize].abs().total_cmp(&self.plane[a as usize].abs()));
        let mut kept = if is_final {
            Room::at(ground.problem, state, self.v).first_admitted(&order, size)
        } else {
            order.into_iter().take(size).collect()
        };
        kept.sort_unstable();
        for f in 0..last {
            self.is_open[f] = kept.binary_search(&(f as u32)).is_ok();
            if !self.is_open[f] {
                self.plane[f] = 0.0;
            }
        }
        self.rescale();
    }

    /// The plane over the values as given.
    pub(crate) fn rule(&self, ground: &Ground) -> Option<Rule> {
        let last = self.plane.len() - 1;
        let raw = |f: usize| f64::from(self.plane[f]) / ground.deviations[f];
        let terms: Vec<(u32, f64)> = (0..last).filter(|&f| self.plane[f] != 0.0).map(|f| (f as u32, raw(f))).collect();
        let shift: f64 = terms.iter().map(|&(f, c)| c * ground.means[f as usize]).sum();
        let offset = shift - f64::from(self.plane[last]);
        let is_finite = offset.is_finite() && terms.iter().all(|term| term.1.is_finite());
        if is_finite { ground.values.rule(&terms, offset, 0) } else { None }
    }
}

fn spread_of_heights(ground: &Ground, plane: &[f32], samples: &[u32]) -> f32 {
    let (mut sum, mut square) = (0.0, 0.0);
    for &i in samples {
        let z = ground.standardised(i);
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

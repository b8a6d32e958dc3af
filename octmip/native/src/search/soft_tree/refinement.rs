//! Melting: all hyperplanes of a subtree are made soft, moved together by gradient steps, and frozen again.
//!
//! At sharpness s a sample of height h = a . z - b (z standardised) goes left with chance p = 1 / (1 + exp(s h)). The
//! expected gain of a sample, E(node) = p E(left) + (1 - p) E(right), is differentiable in all planes at once:
//!
//! `dE/dh = -s p (1 - p) reach (E(left) - E(right))`, reach = chance of coming to the node.
//!
//! Steps follow Adam (Kingma & Ba, 2015) over random batches while s rises, so that the planes end as hard ones. Leaves
//! predict the class of largest expected gain. One plane alone is what a line of hyperplanes improves; planes that
//! must move together are what this finds.

use crate::search::prepared::Ground;
use crate::search::prepared::values::{exponent_of, times_power};
use crate::search::tree::allowance::keeps_limits;
use crate::search::tree::state::State;
use crate::search::watch::Supervisor;

use crate::search::soft_tree::plane::Soft;
use crate::search::soft_tree::schedule::{Heat, Opening};

/// Share of the steps after which no plane looks at more features than it may read.
const CLOSED_AT: f32 = 0.7;
const LAST_SHARPNESS: f32 = 40.0;
const BATCH: usize = 200;
/// Length of the first step, as a share of the normal; the last is a tenth of it.
const STEP: f32 = 0.1;
/// Samples that come to a node with less than this chance move it no more.
const LEAST_REACH: f32 = 1e-3;
/// Planes x features of a subtree from which on every sample of a batch is work enough to look at the watch again.
const LARGE: usize = 1 << 16;
/// Steps between two looks at which class each leaf predicts.
const RELABEL: usize = 10;

/// The subtree while it is soft.
struct Molten<'a> {
    ground: &'a Ground<'a>,
    planes: Vec<Soft>,
    /// Per node in preorder: index in `planes`, or of the leaf; children as positions in preorder.
    shape: Vec<Place>,
    labels: Vec<usize>,
    merits: Vec<f64>,
    supervisor: Supervisor<'a>,
    /// Brings what a sample costs at worst to about 1 on average, a power of two.
    unit: f64,
}

enum Place {
    Leaf(usize),
    Split { plane: usize, children: [usize; 2] },
}

/// Melt the subtree at `v` and freeze it again; whether what came out keeps the limits of leaves and sensors. If not,
/// the state is of no use any more.
pub(crate) fn melt(
    (ground, supervisor): (&Ground, Supervisor),
    state: &mut State,
    v: u32,
    heat: Heat,
    rng: &mut fastrand::Rng,
) -> bool {
    let samples = state.samples(v);
    let Some(mut molten) = Molten::new((ground, supervisor), state, v, &samples, heat, rng) else {
        return false;
    };
    if !molten.run(&samples, heat, state, rng) {
        return false;
    }
    for soft in &molten.planes {
        match soft.rule(ground) {
            Some(rule) => state.nodes[soft.v as usize].rule = rule,
            None => return false,
        }
    }
    state.pour(ground.problem, v, samples);
    state.remove_empty_sides(v);
    keeps_limits(ground.problem, state)
}

impl<'a> Molten<'a> {
    fn new(
        (ground, supervisor): (&'a Ground<'a>, Supervisor<'a>),
        state: &State,
        v: u32,
        samples: &[u32],
        heat: Heat,
        rng: &mut fastrand::Rng,
    ) -> Option<Self> {
        let order = state.below(v);
        let mut position = vec![0; state.nodes.len()];
        order.iter().enumerate().for_each(|(k, &node)| position[node as usize] = k);
        let (mut planes, mut n_leaves) = (Vec::new(), 0);
        let mut shape = Vec::new();
        for &node in &order {
            if !supervisor.goes_on() {
                return None;
            }
            if state.is_leaf(node) {
                shape.push(Place::Leaf(n_leaves));
                n_leaves += 1;
            } else {
                let children = state.nodes[node as usize].children.map(|child| position[child as usize]);
                shape.push(Place::Split { plane: planes.len(), children });
                planes.push(Soft::new(ground, state, node, heat, rng));
            }
        }
        let n_classes = ground.problem.n_classes;
        let merits = vec![0.0; n_leaves * n_classes];
        let unit = times_power(1.0, -exponent_of(ground.prices.mean_cost() / std::f64::consts::SQRT_2));
        let mut molten = Self { ground, planes, shape, labels: vec![0; n_leaves], merits, supervisor, unit };
        molten.run_batch(samples, heat.first_sharpness);
        molten.relabel();
        Some(molten)
    }

    /// Take all steps; false where the watch says stop before.
    fn run(&mut self, samples: &[u32], heat: Heat, state: &State, rng: &mut fastrand::Rng) -> bool {
        let growth = (LAST_SHARPNESS / heat.first_sharpness).max(1.0);
        let mut batch = Vec::with_capacity(BATCH);
        for step in 0..heat.n_steps {
            if !self.supervisor.goes_on() {
                return false;
            }
            let share = step as f32 / heat.n_steps as f32;
            batch.clear();
            if samples.len() <= BATCH {
                batch.extend_from_slice(samples);
            } else {
                batch.extend((0..BATCH).map(|_| samples[rng.usize(..samples.len())]));
            }
            self.planes.iter_mut().for_each(|soft| soft.gradient.fill(0.0));
            self.run_batch(&batch, heat.first_sharpness * growth.powf(share));
            self.planes.iter_mut().for_each(|soft| soft.advance(STEP * 0.1_f32.powf(share), step));
            if step % RELABEL == RELABEL - 1 {
                self.relabel();
            }
            if heat.opening != Opening::None {
                let size = n_open(self.ground, share);
                self.planes.iter_mut().for_each(|soft| soft.close(self.ground, state, size));
            }
        }
        true
    }

    /// Add the gradients and the merits of the leaves' classes over a batch.
    fn run_batch(&mut self, batch: &[u32], sharpness: f32) {
        let n = self.shape.len();
        let (mut reach, mut chance, mut expected) = (vec![0.0_f32; n], vec![0.0_f32; n], vec![0.0_f32; n]);
        let n_classes = self.ground.problem.n_classes;
        let is_large = n * self.ground.problem.p > LARGE;
        for &i in batch {
            if is_large && !self.supervisor.goes_on() {
                return;
            }
            let z = self.ground.standardised(i);
            reach[0] = 1.0;
            for (k, place) in self.shape.iter().enumerate() {
                match place {
                    Place::Leaf(leaf) => {
                        expected[k] = (self.unit * self.ground.prices.gain_of(i, self.labels[*leaf]) as f64) as f32;
                        if reach[k] >= LEAST_REACH {
                            let merits = &mut self.merits[leaf * n_classes..(leaf + 1) * n_classes];
                            self.ground.prices.add_gains(i, f64::from(reach[k]), merits);
                        }
                    }
                    Place::Split { plane, children } => {
                        chance[k] = 0.5;
                        if reach[k] >= LEAST_REACH {
                            chance[k] = 1.0 / (1.0 + (sharpness * self.planes[*plane].height(z)).exp());
                        }
                        reach[children[0]] = reach[k] * chance[k];
                        reach[children[1]] = reach[k] * (1.0 - chance[k]);
                    }
                }
            }
            for (k, place) in self.shape.iter().enumerate().rev() {
                if let Place::Split { plane, children } = place {
                    let [left, right] = children.map(|child| expected[child]);
                    expected[k] = chance[k] * left + (1.0 - chance[k]) * right;
                    let pull = -sharpness * chance[k] * (1.0 - chance[k]) * reach[k] * (left - right);
                    if pull.abs() > 1e-4 {
                        self.planes[*plane].pull(z, pull);
                    }
                }
            }
        }
    }

    /// Let every leaf predict the class of largest merit, and fade the merits.
    fn relabel(&mut self) {
        let n_classes = self.ground.problem.n_classes;
        for (label, merits) in self.labels.iter_mut().zip(self.merits.chunks_mut(n_classes)) {
            let best = (0..n_classes).max_by(|&a, &b| merits[a].total_cmp(&merits[b]));
            *label = best.unwrap_or(*label);
            merits.iter_mut().for_each(|merit| *merit *= 0.5);
        }
    }
}

/// How many features a plane may look at when this share of the steps is done: all, falling to the split size.
fn n_open(ground: &Ground, share: f32) -> usize {
    let (most, least) = (ground.problem.p as f32, ground.split_size() as f32);
    let left = ((CLOSED_AT - share) / CLOSED_AT).clamp(0.0, 1.0);
    (least * (most / least).powf(left)).round() as usize
}

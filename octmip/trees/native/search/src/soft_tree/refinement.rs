//! Soft-tree refinement: all hyperplanes of a subtree are made soft, moved together by gradient steps, and hardened.
//!
//! At inverse temperature s a sample of height h = a . z - b (z standardised) goes left with chance
//! p = 1 / (1 + exp(s h)). The expected gain of a sample, E(node) = p E(left) + (1 - p) E(right), is differentiable in
//! all planes at once:
//!
//! `dE/dh = -s p (1 - p) reach (E(left) - E(right))`, reach = chance of coming to the node.
//!
//! Steps follow Adam (Kingma & Ba, 2015) over random batches while s rises, so that the planes end as hard ones. Leaves
//! predict the class of largest expected gain. One plane alone is what a line of hyperplanes improves; planes that
//! must move together are what this finds.

use crate::prepared::Prepared;
use crate::prepared::values::{exponent_of, times_power};
use crate::soft_tree::plane::SoftPlane;
use crate::soft_tree::schedule::{Reselection, Schedule};
use crate::tree::allowance::keeps_limits;
use crate::tree::state::State;
use crate::watch::Supervisor;

/// Share of the steps after which no plane looks at more features than it may read.
const RESTRICTED_AT: f32 = 0.7;
const LAST_INVERSE_TEMPERATURE: f32 = 40.0;
const BATCH: usize = 200;
/// Length of the first step, as a share of the normal; the last is a tenth of it.
const STEP: f32 = 0.1;
/// Samples that come to a node with less than this chance move it no more.
const LEAST_REACH: f32 = 1e-3;
/// Planes x features of a subtree from which on every sample of a batch is work enough to look at the watch again.
const LARGE: usize = 1 << 16;
/// Steps after which every leaf chooses its class again.
const RELABEL: usize = 10;

/// The subtree while it is soft.
struct SoftTree<'a> {
    prepared: &'a Prepared<'a>,
    planes: Vec<SoftPlane>,
    /// Per node in preorder: index in `planes`, or of the leaf; children as positions in preorder.
    shape: Vec<SoftNode>,
    labels: Vec<usize>,
    label_gains: Vec<f64>,
    supervisor: Supervisor<'a>,
    /// The power of two that brings the highest cost of a sample to about 1 on average.
    unit: f64,
}

/// A node of the subtree, by index.
enum SoftNode {
    Leaf(usize),
    Split { plane: usize, children: [usize; 2] },
}

/// Refine the subtree at `v` as a soft tree and harden it; whether the result keeps the limits of leaves and sensors.
/// If not, the state is of no use any more.
pub(crate) fn refine_soft_tree(
    (prepared, supervisor): (&Prepared, Supervisor),
    state: &mut State,
    v: u32,
    schedule: Schedule,
    rng: &mut fastrand::Rng,
) -> bool {
    let samples = state.samples(v);
    let Some(mut soft_tree) = SoftTree::new((prepared, supervisor), state, v, &samples, schedule, rng) else {
        return false;
    };
    if !soft_tree.run(&samples, schedule, state, rng) {
        return false;
    }
    for soft in &soft_tree.planes {
        match soft.rule(prepared) {
            Some(rule) => state.nodes[soft.v as usize].rule = rule,
            None => return false,
        }
    }
    state.reroute(prepared.problem, v, samples);
    state.remove_empty_sides(v);
    keeps_limits(prepared.problem, state)
}

impl<'a> SoftTree<'a> {
    fn new(
        (prepared, supervisor): (&'a Prepared<'a>, Supervisor<'a>),
        state: &State,
        v: u32,
        samples: &[u32],
        schedule: Schedule,
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
                shape.push(SoftNode::Leaf(n_leaves));
                n_leaves += 1;
            } else {
                let children = state.nodes[node as usize].children.map(|child| position[child as usize]);
                shape.push(SoftNode::Split { plane: planes.len(), children });
                planes.push(SoftPlane::new(prepared, state, node, schedule, rng));
            }
        }
        let n_classes = prepared.problem.n_classes;
        let label_gains = vec![0.0; n_leaves * n_classes];
        let unit = times_power(1.0, -exponent_of(prepared.prices.mean_cost() / std::f64::consts::SQRT_2));
        let mut soft_tree = Self { prepared, planes, shape, labels: vec![0; n_leaves], label_gains, supervisor, unit };
        soft_tree.run_batch(samples, schedule.first_inverse_temperature);
        soft_tree.relabel();
        Some(soft_tree)
    }

    /// Take all steps; false where the watch says stop before.
    fn run(&mut self, samples: &[u32], schedule: Schedule, state: &State, rng: &mut fastrand::Rng) -> bool {
        let growth = (LAST_INVERSE_TEMPERATURE / schedule.first_inverse_temperature).max(1.0);
        let mut batch = Vec::with_capacity(BATCH);
        for step in 0..schedule.n_steps {
            if !self.supervisor.goes_on() {
                return false;
            }
            let share = step as f32 / schedule.n_steps as f32;
            batch.clear();
            if samples.len() <= BATCH {
                batch.extend_from_slice(samples);
            } else {
                batch.extend((0..BATCH).map(|_| samples[rng.usize(..samples.len())]));
            }
            self.planes.iter_mut().for_each(|soft| soft.gradient.fill(0.0));
            self.run_batch(&batch, schedule.first_inverse_temperature * growth.powf(share));
            self.planes.iter_mut().for_each(|soft| soft.advance(STEP * 0.1_f32.powf(share), step));
            if step % RELABEL == RELABEL - 1 {
                self.relabel();
            }
            if schedule.reselection != Reselection::None {
                let size = n_active(self.prepared, share);
                self.planes.iter_mut().for_each(|soft| soft.keep_leading(self.prepared, state, size));
            }
        }
        true
    }

    /// Add the gradients, and the gains of the leaves' classes, over a batch.
    fn run_batch(&mut self, batch: &[u32], inverse_temperature: f32) {
        let n = self.shape.len();
        let (mut reach, mut chance, mut expected) = (vec![0.0_f32; n], vec![0.0_f32; n], vec![0.0_f32; n]);
        let n_classes = self.prepared.problem.n_classes;
        let is_large = n * self.prepared.problem.p > LARGE;
        for &i in batch {
            if is_large && !self.supervisor.goes_on() {
                return;
            }
            let z = self.prepared.standardised(i);
            reach[0] = 1.0;
            for (k, place) in self.shape.iter().enumerate() {
                match place {
                    SoftNode::Leaf(leaf) => {
                        expected[k] = (self.unit * self.prepared.prices.gain_of(i, self.labels[*leaf]) as f64) as f32;
                        if reach[k] >= LEAST_REACH {
                            let label_gains = &mut self.label_gains[leaf * n_classes..(leaf + 1) * n_classes];
                            self.prepared.prices.add_gains(i, f64::from(reach[k]), label_gains);
                        }
                    }
                    SoftNode::Split { plane, children } => {
                        chance[k] = 0.5;
                        if reach[k] >= LEAST_REACH {
                            chance[k] = 1.0 / (1.0 + (inverse_temperature * self.planes[*plane].height(z)).exp());
                        }
                        reach[children[0]] = reach[k] * chance[k];
                        reach[children[1]] = reach[k] * (1.0 - chance[k]);
                    }
                }
            }
            for (k, place) in self.shape.iter().enumerate().rev() {
                if let SoftNode::Split { plane, children } = place {
                    let [left, right] = children.map(|child| expected[child]);
                    expected[k] = chance[k] * left + (1.0 - chance[k]) * right;
                    let slope = -inverse_temperature * chance[k] * (1.0 - chance[k]) * reach[k] * (left - right);
                    if slope.abs() > 1e-4 {
                        self.planes[*plane].add_gradient(z, slope);
                    }
                }
            }
        }
    }

    /// Let every leaf predict the class of largest gain, and fade the gains.
    fn relabel(&mut self) {
        let n_classes = self.prepared.problem.n_classes;
        for (label, label_gains) in self.labels.iter_mut().zip(self.label_gains.chunks_mut(n_classes)) {
            let best = (0..n_classes).max_by(|&a, &b| label_gains[a].total_cmp(&label_gains[b]));
            *label = best.unwrap_or(*label);
            label_gains.iter_mut().for_each(|gain| *gain *= 0.5);
        }
    }
}

/// Number of features that a plane may look at when this share of the steps is done: all, falling to the split size.
fn n_active(prepared: &Prepared, share: f32) -> usize {
    let (most, least) = (prepared.problem.p as f32, prepared.split_size() as f32);
    let left = ((RESTRICTED_AT - share) / RESTRICTED_AT).clamp(0.0, 1.0);
    (least * (most / least).powf(left)).round() as usize
}

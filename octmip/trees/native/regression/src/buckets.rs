//! Best cuts by buckets: weights above 0; squared errors, or sloped ones of few distinct targets. Leaves have any size;
//! where they have a least one, a pass gives bounds alone.
//!
//! The samples of a node are parted into buckets along each feature, samples of one rank never into two. A cut of
//! another feature that moves by one sample changes one bucket of each feature, and a pass reads buckets, not samples
//! (`sweep`). Where a bound says that a bucket may hold a better cut than all edges, it is looked into (`inside`).

use crate::inside::{Inside, Piles, sloped_error};
use crate::samples::Samples;
use crate::sides::Sides;
use crate::sweep::{CAPS, LANES, Line, MOST_VALUES, Reached, SQUARED_ROWS, Sloped, Squared};
use crate::view::View;

/// Most buckets of a feature.
const MOST_SQUARED: usize = 64;
const MOST_SLOPED: usize = 48;

/// Buckets of all features of a node.
#[derive(Debug)]
pub(crate) struct Buckets {
    arch: pulp::Arch,
    /// Whether leaves of any size will do, so that what is reached is found; else it is a bound.
    pub(crate) is_exact: bool,
    /// Feature of each slot, and slot of each feature.
    pub(crate) features: Vec<usize>,
    slots: Vec<usize>,
    /// Buckets of each slot, the last ones empty where a feature has fewer.
    n_buckets: usize,
    /// First sample of each bucket in the list of its feature, and the end (`slots * (n_buckets + 1)`).
    starts: Vec<u32>,
    rows: usize,
    /// Cells (`groups * n_buckets * rows`).
    lines: Vec<Line>,
    /// First line of each sample's cell, by sample and slot.
    of_sample: Vec<u32>,
    /// Bounds inside buckets, from the last pass over each group (`groups * n_buckets * CAPS`), and what it reached.
    caps: Vec<Line>,
    reached: Vec<Reached>,
    has_inside: bool,
    /// Samples left of the cut that each group stands at.
    at: Vec<usize>,
    /// Weight of each target on both sides; of sloped errors.
    by_target: [[f64; MOST_VALUES]; 2],
    inside: Inside,
}

impl Buckets {
    /// Buckets of these samples, None where they do not serve.
    pub(crate) fn new(samples: &Samples) -> Option<Self> {
        let has_weights = samples.sums.iter().all(|own| own.weight > 0.0);
        let is_few = samples.slopes.is_none() || samples.values.len() <= MOST_VALUES;
        (has_weights && is_few).then(|| Self {
            arch: pulp::Arch::new(),
            is_exact: samples.leaf_size == 1,
            features: (0..samples.p).collect(),
            slots: (0..samples.p).collect(),
            n_buckets: 0,
            starts: Vec::new(),
            rows: if samples.slopes.is_some() { 2 * samples.values.len().max(2) + 1 } else { SQUARED_ROWS },
            lines: Vec::new(),
            of_sample: Vec::new(),
            caps: Vec::new(),
            reached: vec![Reached::NOTHING; samples.p.div_ceil(LANES)],
            has_inside: false,
            at: Vec::new(),
            by_target: [[0.0; MOST_VALUES]; 2],
            inside: Inside::default(),
        })
    }

    /// Groups of features that a pass takes together.
    pub(crate) fn n_groups(&self) -> usize {
        self.features.len().div_ceil(LANES)
    }

    /// Features of a group.
    pub(crate) fn group(&self, group: usize) -> &[usize] {
        &self.features[group * LANES..((group + 1) * LANES).min(self.features.len())]
    }

    /// Put the features in their own order: what was found at other nodes must not matter.
    pub(crate) fn begin(&mut self) {
        self.reorder(&vec![0.0; self.features.len()]);
    }

    /// Put the features in another order before the next node: those that are passed over together side by side.
    pub(crate) fn reorder(&mut self, errors: &[f64]) {
        self.features.sort_by(|&f, &g| errors[f].total_cmp(&errors[g]).then(f.cmp(&g)));
        for (slot, &f) in self.features.iter().enumerate() {
            self.slots[f] = slot;
        }
    }

    /// Part the samples of a node, all on the right.
    pub(crate) fn load(&mut self, samples: &Samples, view: &View) {
        self.lay_starts(samples, view);
        let (p, b, rows) = (samples.p, self.n_buckets, self.rows);
        self.lines.clear();
        self.lines.resize(self.n_groups() * b * rows, Line::ZERO);
        self.caps.resize(self.n_groups() * b * CAPS, Line::ZERO);
        self.of_sample.resize(samples.n * p, 0);
        for slot in 0..p {
            let f = self.features[slot];
            let (list, ranks, lane) = (view.list(f), samples.ranks_of(f), slot % LANES);
            for bucket in 0..b {
                let first = (slot / LANES * b + bucket) * rows;
                let ends = [0, 1].map(|end| self.starts[slot * (b + 1) + bucket + end] as usize);
                let own = &list[ends[0]..ends[1]];
                for &i in own {
                    self.of_sample[i as usize * p + slot] = first as u32;
                }
                let is_open = own.len() > 1 && ranks[own[0] as usize] != ranks[own[own.len() - 1] as usize];
                fill(&mut self.lines[first..first + rows], lane, samples, own, is_open);
            }
        }
        self.rewind(samples, view);
    }

    fn lay_starts(&mut self, samples: &Samples, view: &View) {
        let most = if samples.slopes.is_some() { MOST_SLOPED } else { MOST_SQUARED };
        // Passes cost as much as there are buckets, walks as much as samples are in one.
        let size = view.len.div_ceil(most.max(view.len.isqrt()));
        let mut all: Vec<Vec<u32>> = Vec::with_capacity(samples.p);
        self.has_inside = false;
        for &f in &self.features {
            let (list, ranks) = (view.list(f), samples.ranks_of(f));
            let mut starts = vec![0u32];
            let mut is_mixed = false;
            for k in 1..view.len {
                if ranks[list[k] as usize] == ranks[list[k - 1] as usize] {
                    continue;
                }
                if k - starts[starts.len() - 1] as usize >= size {
                    starts.push(k as u32);
                } else {
                    is_mixed = true;
                }
            }
            self.has_inside |= is_mixed;
            all.push(starts);
        }
        self.n_buckets = all.iter().map(Vec::len).max().unwrap_or(0);
        self.starts.clear();
        for starts in all {
            let more = self.n_buckets + 1 - starts.len();
            self.starts.extend(starts);
            self.starts.extend(std::iter::repeat_n(view.len as u32, more));
        }
    }

    /// All samples on the right again.
    pub(crate) fn rewind(&mut self, samples: &Samples, view: &View) {
        let (first, n) = if samples.slopes.is_some() { (self.rows / 2, self.rows / 2) } else { (2, 2) };
        self.at.clear();
        self.at.resize(self.n_groups(), 0);
        for cell in self.lines.chunks_exact_mut(self.rows) {
            cell[first..first + n].fill(Line::ZERO);
        }
        self.by_target = [[0.0; MOST_VALUES]; 2];
        if samples.slopes.is_some() {
            for &i in view.list(samples.p) {
                let target = samples.ranks_of(samples.p)[i as usize] as usize;
                self.by_target[1][target] += samples.sums[i as usize].weight;
            }
        }
    }

    /// A sample changes sides, 0 is to the left.
    #[inline]
    pub(crate) fn pass(&mut self, samples: &Samples, i: u32, to: usize) {
        if samples.slopes.is_some() {
            let target = samples.ranks_of(samples.p)[i as usize] as usize;
            self.by_target[to][target] += samples.sums[i as usize].weight;
            self.by_target[1 - to][target] -= samples.sums[i as usize].weight;
        }
    }

    /// Bring the cells of a group to a cut with so many samples of a list on its left.
    fn shift(&mut self, samples: &Samples, group: usize, list: &[u32], k: usize) {
        let at = std::mem::replace(&mut self.at[group], k);
        let sign = if at < k { 1.0 } else { -1.0 };
        let (p, first) = (self.features.len(), group * LANES);
        let used = LANES.min(p - first);
        for &i in &list[at.min(k)..at.max(k)] {
            let own = &samples.sums[i as usize];
            let cells = &self.of_sample[i as usize * p + first..][..used];
            let (weight, target) = (sign * own.weight, sign * own.target);
            if samples.slopes.is_some() {
                let row = self.rows / 2 + samples.ranks_of(samples.p)[i as usize] as usize;
                for (lane, &cell) in cells.iter().enumerate() {
                    self.lines[cell as usize + row].0[lane % LANES] += weight;
                }
                continue;
            }
            for (lane, &cell) in cells.iter().enumerate() {
                if let [weights, targets] = &mut self.lines[cell as usize + 2..cell as usize + 4] {
                    weights.0[lane % LANES] += weight;
                    targets.0[lane % LANES] += target;
                }
            }
        }
    }

    /// Least error of one constant on either side.
    pub(crate) fn leaves(&self, samples: &Samples, sides: &Sides) -> [f64; 2] {
        match samples.slopes {
            Some(slopes) => self.by_target.map(|weights| sloped_error(slopes, &weights, &samples.gaps)),
            None => sides.sums.map(|sums| sums.squared_error()),
        }
    }

    /// Pass over the buckets of a group of features at a cut with so many samples of a list on its left.
    pub(crate) fn sweep(
        &mut self,
        samples: &Samples,
        sides: &Sides,
        group: usize,
        list: &[u32],
        needs: [bool; 2],
    ) -> Reached {
        self.shift(samples, group, list, sides.counts[0]);
        let size = self.n_buckets * self.rows;
        let (lines, has_inside) = (&self.lines[group * size..][..size], self.has_inside);
        let caps = &mut self.caps[group * self.n_buckets * CAPS..][..self.n_buckets * CAPS];
        let reached = if let Some(slopes) = samples.slopes {
            let (totals, gaps, n_values) = (self.by_target, samples.gaps, self.rows / 2);
            self.arch.dispatch(Sloped { slopes, lines, caps, totals, gaps, n_values, has_inside, needs })
        } else {
            let totals = sides.sums.map(|sums| (sums.weight, sums.target, sums.square));
            self.arch.dispatch(Squared { lines, caps, totals, has_inside, needs })
        };
        self.reached[group] = reached;
        reached
    }

    /// Look into the buckets of feature `g` that may err by less than `beat` on a side, after a pass: the least error
    /// found, and a bound of all cuts.
    pub(crate) fn look_inside(
        &mut self,
        samples: &Samples,
        view: &View,
        g: usize,
        sides: &Sides,
        (side, beat): (usize, f64),
    ) -> (f64, f64) {
        let (slot, b) = (self.slots[g], self.n_buckets);
        let group = slot / LANES;
        let piles = Piles {
            lines: &self.lines[group * b * self.rows..][..b * self.rows],
            caps: &self.caps[group * b * CAPS..][..b * CAPS],
            starts: &self.starts[slot * (b + 1)..][..b + 1],
            lane: slot % LANES,
            list: view.list(g),
            ranks: samples.ranks_of(g),
            side,
            rows: self.rows,
        };
        let (found, lower) = match samples.slopes {
            Some(slopes) => self.inside.sloped(slopes, (samples, sides), &piles, &self.by_target[side], beat),
            None => self.inside.squared(samples, sides, &piles, beat),
        };
        (found, lower.min(self.reached[group].edge[side][slot % LANES]))
    }
}

/// Enter a bucket's samples in the rows of its cell.
fn fill(cell: &mut [Line], lane: usize, samples: &Samples, own: &[u32], is_open: bool) {
    let last = cell.len() - 1;
    if samples.slopes.is_some() {
        for &i in own {
            let target = samples.ranks_of(samples.p)[i as usize] as usize;
            cell[target].0[lane] += samples.sums[i as usize].weight;
        }
        cell[last].0[lane] = f64::from(u8::from(is_open));
        return;
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for &i in own {
        let i = i as usize;
        cell[0].0[lane] += samples.sums[i].weight;
        cell[1].0[lane] += samples.sums[i].target;
        (low, high) = (low.min(samples.targets[i]), high.max(samples.targets[i]));
    }
    if is_open && high > low {
        (cell[4].0[lane], cell[5].0[lane], cell[6].0[lane]) = (low, high, 1.0 / (high - low));
    }
}

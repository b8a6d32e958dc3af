//! The buckets of one feature on one side of a cut, one after the other: which may hold a better cut, and what they do.
//!
//! Squared errors: what a cut explains, `S_left^2 / W_left + S_right^2 / W_right`, is convex in the weight W and the
//! weighted target S left of it. A cut inside a bucket has a part of the bucket's samples left of it, with targets
//! between the bucket's least and greatest: its (W, S) lies in the parallelogram with the corners nothing, all, as much
//! as can be of the greatest target only, and as much as can be of the least only. So it explains at most what the best
//! corner does.
//!
//! Sloped errors: for each gap between targets the error is concave in what more is passed below than above it, so
//! least with all that is below passed, or all that is above (`sweep`).

use crate::samples::Samples;
use crate::sides::Sides;
use crate::slopes::Slopes;
use crate::sweep::{CAPS, LANES, Line, MOST_VALUES, SQUARED_ROWS};

/// Weight and weighted target.
type Pile = (f64, f64);
/// Weight of each target.
pub(crate) type Weights = [f64; MOST_VALUES];
/// Weight at or below each target; the last is that of all.
type Below = [f64; MOST_VALUES];

/// Buckets of one feature and side.
#[derive(Debug)]
pub(crate) struct Piles<'a> {
    /// Cells of the feature's group.
    pub(crate) lines: &'a [Line],
    /// Bounds of their insides.
    pub(crate) caps: &'a [Line],
    /// First sample of each bucket in the list, and the end.
    pub(crate) starts: &'a [u32],
    /// Of the feature in its group.
    pub(crate) lane: usize,
    /// The node's samples in the order of the feature.
    pub(crate) list: &'a [u32],
    /// Ranks of the feature.
    pub(crate) ranks: &'a [u32],
    /// Which side, 0 is left.
    pub(crate) side: usize,
    /// Lines of a cell.
    pub(crate) rows: usize,
}

impl Piles<'_> {
    /// Weight of each target in the buckets before one; of sloped errors.
    fn before(&self, bucket: usize) -> Weights {
        let n_values = self.rows / 2;
        let mut found = [0.0; MOST_VALUES];
        for cell in self.lines.chunks_exact(self.rows).take(bucket) {
            let (all, left) = cell.split_at(n_values);
            for (v, weight) in found.iter_mut().take(n_values).enumerate() {
                let own = left[v].0[self.lane];
                *weight += if self.side == 0 { own } else { all[v].0[self.lane] - own };
            }
        }
        found
    }

    /// The cuts inside a bucket: `cut` is called at each with what the samples before it have been added to.
    fn walk<T: Copy>(
        &self,
        bucket: usize,
        sides: &Sides,
        start: T,
        add: impl Fn(&mut T, usize),
        mut cut: impl FnMut(&T),
    ) {
        let (mut left, mut before) = (start, None);
        for &i in &self.list[self.starts[bucket] as usize..self.starts[bucket + 1] as usize] {
            let i = i as usize;
            if sides.of_sample[i] as usize != self.side {
                continue;
            }
            if before.is_some_and(|rank| rank != self.ranks[i]) {
                cut(&left);
            }
            before = Some(self.ranks[i]);
            add(&mut left, i);
        }
    }
}

/// Buffers of buckets that may hold a better cut: bucket, bound, and for squared errors what stands left of it.
#[derive(Debug, Default)]
pub(crate) struct Inside {
    squared: Vec<(usize, f64, Pile)>,
    sloped: Vec<(usize, f64)>,
}

/// What a cut explains; of nothing where a side is empty.
#[inline(always)]
fn explained(left: Pile, total: Pile) -> f64 {
    let right = (total.0 - left.0, total.1 - left.1);
    if left.0 > 0.0 && right.0 > 0.0 {
        (left.1 * left.1 * right.0 + right.1 * right.1 * left.0) / (left.0 * right.0)
    } else {
        0.0
    }
}

impl Inside {
    /// Least squared error of cuts inside buckets that may err by less than `beat`, and a bound of those in all.
    pub(crate) fn squared(&mut self, samples: &Samples, sides: &Sides, piles: &Piles<'_>, beat: f64) -> (f64, f64) {
        let (side, lane) = (piles.side, piles.lane % LANES);
        let (total, square) = ((sides.sums[side].weight, sides.sums[side].target), sides.sums[side].square);
        let (mut left, mut most): (Pile, f64) = ((0.0, 0.0), 0.0);
        self.squared.clear();
        let cells = piles.lines.as_chunks::<SQUARED_ROWS>().0.iter().zip(piles.caps.as_chunks::<CAPS>().0);
        for (bucket, (cell, caps)) in cells.enumerate() {
            let row = |row: usize| cell[row].0[lane];
            let (above, below) = (caps[2 * side].0[lane], caps[2 * side + 1].0[lane]);
            if row(SQUARED_ROWS - 1) > 0.0 {
                if (square - beat) * below < above {
                    self.squared.push((bucket, above / below, left));
                } else {
                    most = square - beat;
                }
            }
            let own = if side == 0 { (row(2), row(3)) } else { (row(0) - row(2), row(1) - row(3)) };
            left = (left.0 + own.0, left.1 + own.1);
        }
        // The most promising first: the others are then mostly left alone.
        self.squared.sort_unstable_by(|a, b| b.1.total_cmp(&a.1));
        let mut best = 0.0;
        for &(bucket, cap, start) in &self.squared {
            if cap <= f64::max(best, square - beat) {
                most = most.max(cap);
                break;
            }
            let add = |left: &mut Pile, i: usize| {
                *left = (left.0 + samples.sums[i].weight, left.1 + samples.sums[i].target);
            };
            piles.walk(bucket, sides, start, add, |left| best = f64::max(best, explained(*left, total)));
        }
        let error = |explained: f64| (square - explained).max(0.0);
        (error(best), error(most.max(best)))
    }

    /// The same of sloped errors.
    pub(crate) fn sloped(
        &mut self,
        slopes: Slopes,
        (samples, sides): (&Samples, &Sides),
        piles: &Piles<'_>,
        total: &Weights,
        beat: f64,
    ) -> (f64, f64) {
        let (lane, mut lower) = (piles.lane % LANES, f64::INFINITY);
        self.sloped.clear();
        for (bucket, caps) in piles.caps.as_chunks::<CAPS>().0.iter().enumerate() {
            let cap = caps[piles.side].0[lane];
            if cap < beat {
                self.sloped.push((bucket, cap));
            } else {
                lower = lower.min(cap);
            }
        }
        self.sloped.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
        let (all, mut best) = (below(total), f64::INFINITY);
        for (bucket, cap) in &self.sloped {
            if *cap >= best.min(beat) {
                lower = lower.min(*cap);
                break;
            }
            let targets = samples.ranks_of(samples.p);
            let add = |left: &mut Below, i: usize| {
                let (weight, steps) = (samples.sums[i].weight, &STEPS[targets[i] as usize % MOST_VALUES]);
                (0..MOST_VALUES).for_each(|v| left[v] += weight * steps[v]);
            };
            let start = below(&piles.before(*bucket)); // of most buckets nobody asks
            let mut see = |error: f64| best = if error < best { error } else { best };
            if slopes.are_even() {
                let error = |left: &Below| split_error::<true>(slopes, left, &all, &samples.gaps);
                piles.walk(*bucket, sides, start, add, |left| see(error(left)));
            } else {
                let error = |left: &Below| split_error::<false>(slopes, left, &all, &samples.gaps);
                piles.walk(*bucket, sides, start, add, |left| see(error(left)));
            }
        }
        (best, lower.min(best))
    }
}

/// Which entries of `Below` a sample of each target adds to.
const STEPS: [Below; MOST_VALUES] = {
    let mut steps = [[0.0; MOST_VALUES]; MOST_VALUES];
    let mut target = 0;
    while target < MOST_VALUES {
        let mut v = target;
        while v < MOST_VALUES {
            steps[target][v] = 1.0;
            v += 1;
        }
        target += 1;
    }
    steps
};

fn below(weights: &Weights) -> Below {
    let mut sum = 0.0;
    weights.map(|weight| {
        sum += weight;
        sum
    })
}

/// Least sloped error of one constant for weights of the targets.
#[inline(always)]
pub(crate) fn sloped_error(slopes: Slopes, weights: &Weights, gaps: &Weights) -> f64 {
    let below = below(weights);
    let terms: Weights =
        std::array::from_fn(|v| gaps[v] * less::<false>(slopes, below[v], below[MOST_VALUES - 1] - below[v]));
    sum(&terms)
}

/// Least sloped error of two constants, one left of a cut and one right of it.
#[inline(always)]
fn split_error<const EVEN: bool>(slopes: Slopes, left: &Below, all: &Below, gaps: &Weights) -> f64 {
    let (total, rest) = (left[MOST_VALUES - 1], all[MOST_VALUES - 1] - left[MOST_VALUES - 1]);
    let terms: Weights = std::array::from_fn(|v| {
        let right = all[v] - left[v];
        gaps[v] * (less::<EVEN>(slopes, left[v], total - left[v]) + less::<EVEN>(slopes, right, rest - right))
    });
    sum(&terms)
}

/// The lesser of what weights below and above a gap cost; not NaN: one instruction, where `f64::min` is several.
#[inline(always)]
fn less<const EVEN: bool>(slopes: Slopes, below: f64, above: f64) -> f64 {
    let Slopes { up, down } = slopes.known::<EVEN>();
    let (a, b) = (down * below, up * above);
    if a < b { a } else { b }
}

/// Added in pairs, for the machine to add side by side.
#[inline(always)]
fn sum(terms: &Weights) -> f64 {
    let [a, b, c, d, e, f, g, h] = terms;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

//! The best hyperplane along a line of hyperplanes.
//!
//! Planes `g_j + d h_j <= 0` over a step `d`: sample `j` changes sides at `d_j = -g_j / h_j` and nowhere else. The
//! samples are sorted by `|d_j|` on each side of the present plane (`d = 0`) and moved in a tally, outwards. The step
//! is the middle of the best gap between two neighbouring `d_j`, at random among equals: O(m log m) for m samples.

use crate::gains::tally::Tally;
use crate::tree::view::NodeView;

/// A hyperplane over the samples of one view.
#[derive(Debug, Clone, Default)]
pub(crate) struct SampledPlane {
    /// Coefficient of every feature of the problem, most of them 0.
    pub(crate) normal: Vec<f64>,
    /// Largest projection that goes left.
    pub(crate) offset: f64,
    /// Shift of the plane over the values as given (see `values`).
    pub(crate) shift: i32,
    /// `normal . x - offset` of each sample; left where at most 0.
    pub(crate) heights: Vec<f64>,
    /// Whether each sample goes left.
    pub(crate) is_left: Vec<bool>,
}

/// Memory for sorting and for going back.
#[derive(Debug)]
pub(crate) struct LineScratch<'a> {
    outwards: [Vec<u64>; 2],
    saved: Tally<'a>,
}

impl<'a> LineScratch<'a> {
    /// Empty scratch.
    pub(crate) fn new(tally: &Tally<'a>) -> Self {
        Self { outwards: [Vec::new(), Vec::new()], saved: tally.clone() }
    }
}

/// Longer steps are none: they are about samples that a hyperplane cannot separate, and sums of shorter ones stay far
/// from the end of the float64 range.
const LONGEST_STEP: f64 = 1e100;

/// The best step found: its way (forward or back), the number of samples that change sides, its length.
struct BestStep {
    way: usize,
    n_flips: usize,
    step: f64,
}

/// Take the best step along `slopes` (the `h_j`) that gains no less than the present plane, other than none at all.
///
/// Tally, sides and heights follow; the caller moves normal and offset by the step returned.
pub(crate) fn take_best_step<'a>(
    view: &NodeView,
    plane: &mut SampledPlane,
    slopes: &[f64],
    tally: &mut Tally<'a>,
    scratch: &mut LineScratch<'a>,
    patience: i64,
    rng: &mut fastrand::Rng,
) -> Option<f64> {
    let index_mask = sort_by_way(plane, slopes, &mut scratch.outwards);
    scratch.saved.copy_from(tally);
    let mut search = LineSearch { best: tally.total, n_equal: 0, place: None, patience };
    for way in [0, 1] {
        search.sweep(view, plane, slopes, tally, (way, &mut scratch.outwards[way], index_mask), rng);
        tally.copy_from(&scratch.saved);
    }
    let place = search.place?;
    for key in &scratch.outwards[place.way][..place.n_flips] {
        let j = (key & index_mask) as usize;
        view.members[j].cross(tally, plane.is_left[j]);
        plane.is_left[j] = !plane.is_left[j];
    }
    plane.heights.iter_mut().zip(slopes).for_each(|(height, slope)| *height += place.step * slope);
    Some(place.step)
}

/// The search for the best step along one line.
struct LineSearch {
    best: i64,
    n_equal: u32,
    place: Option<BestStep>,
    patience: i64,
}

/// Samples that are sorted first; most lines are given up within them.
const FIRST_RUN: usize = 128;

impl LineSearch {
    /// Move samples across in the order of the steps of one way, sorted run by run, each run twice as long.
    fn sweep(
        &mut self,
        view: &NodeView,
        plane: &SampledPlane,
        slopes: &[f64],
        tally: &mut Tally,
        (way, keys, index_mask): (usize, &mut [u64], u64),
        rng: &mut fastrand::Rng,
    ) {
        let (mut n_sorted, mut run) = (0, FIRST_RUN);
        for k in 1..keys.len() {
            if k >= n_sorted {
                let end = (n_sorted + run).min(keys.len());
                if end < keys.len() {
                    keys[n_sorted..].select_nth_unstable(end - 1 - n_sorted);
                }
                keys[n_sorted..end].sort_unstable();
                (n_sorted, run) = (end, 2 * run);
            }
            let j = (keys[k - 1] & index_mask) as usize;
            view.members[j].cross(tally, plane.is_left[j]);
            if tally.total < self.best {
                if tally.total < self.best - self.patience {
                    return;
                }
                continue;
            }
            if keys[k - 1] & !index_mask == keys[k] & !index_mask || !tally.is_large_enough() {
                continue;
            }
            let next = (keys[k] & index_mask) as usize;
            let (near, far) = (-plane.heights[j] / slopes[j], -plane.heights[next] / slopes[next]);
            let step = near / 2.0 + far / 2.0;
            if step.abs() > LONGEST_STEP {
                return;
            }
            self.n_equal = if tally.total > self.best { 1 } else { self.n_equal + 1 };
            self.best = tally.total;
            if self.n_equal == 1 || rng.u32(..self.n_equal) == 0 {
                self.place = Some(BestStep { way, n_flips: k, step });
            }
        }
    }
}

/// Part the samples by the way in which they change sides, steps forward and steps back; returns the mask of the
/// sample's position in a key.
///
/// A positive float orders as its bits do. The low bits make room for the position: steps that agree in the others
/// (28 bits of mantissa for a million samples) count as equal, which only leaves out places between them.
fn sort_by_way(plane: &SampledPlane, slopes: &[f64], outwards: &mut [Vec<u64>; 2]) -> u64 {
    let bits = usize::BITS - slopes.len().leading_zeros();
    let mask = (1_u64 << bits) - 1;
    outwards.iter_mut().for_each(Vec::clear);
    for (j, (&height, &slope)) in plane.heights.iter().zip(slopes).enumerate() {
        if slope != 0.0 {
            let step = height / slope;
            // A sample on the plane is left, and leaves it only in the way in which its height rises.
            let way = usize::from(step > 0.0 || (step == 0.0 && slope < 0.0));
            outwards[way].push(step.abs().to_bits() & !mask | j as u64);
        }
    }
    mask
}

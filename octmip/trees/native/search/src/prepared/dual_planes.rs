//! Dual planes of pairs of features, the tables of all lines over a pair: each made when a search first asks for it and
//! kept for all its nodes.

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use crate::prepared::values::{Values, exponent_of, times_power};
use octmip_check::problem::Problem;
use octmip_frame::ranks::Ranker;
use octmip_two_feature::{DualPlane, Line, Loss, Plane, Switches, WeightedSamples, best_of_dual_planes};

/// Slope intervals of a dual plane.
const SLOPE_INTERVALS: usize = 8;
/// Regions of one pair that are split at most: what is left out is nearly always what could not win.
const MOST_TRIED: usize = 24;
/// Values closer than this share of their feature's range count as equal in the tables: regions are split little
/// further.
const GRID: f64 = 1.0 / (1_u64 << 32) as f64;
/// Tables of more bytes than this are not made at all.
const MOST_BYTES: usize = 200_000_000;

/// The dual planes of all pairs, made as they are asked for.
#[derive(Debug)]
pub(crate) struct DualPlanes {
    plane: Plane,
    dual_planes: Vec<OnceLock<DualPlane>>,
    /// Costs of the problem, and its weights in the unit of these costs.
    pub(crate) loss: Loss,
    pub(crate) weights: Vec<i64>,
    /// Right and wrong sides, where the leaves keep their labels.
    pub(crate) sides: Loss,
}

/// A question to a pair of features: the best line for these samples, labels and weights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairQuestion<'a> {
    pub(crate) ids: &'a [u32],
    pub(crate) labels: &'a [u32],
    pub(crate) weights: &'a [i64],
    pub(crate) loss: &'a Loss,
    pub(crate) need: i64,
    /// Only splits that cost less are of interest.
    pub(crate) cutoff: i64,
}

impl DualPlanes {
    /// No tables yet; None where they would be too large.
    pub(crate) fn new(problem: &Problem, own: &Values) -> Option<Self> {
        let n_dual_planes = problem.p * (problem.p - 1);
        if n_dual_planes.saturating_mul(problem.n * (SLOPE_INTERVALS + 1)) > MOST_BYTES {
            return None;
        }
        problem.planes.as_ref()?;
        let (loss, unit) = Loss::of(problem);
        Some(Self {
            plane: plane_of(problem, own),
            dual_planes: (0..n_dual_planes).map(|_| OnceLock::new()).collect(),
            loss,
            weights: problem.weights.iter().map(|weight| weight * unit).collect(),
            sides: Loss::two_sides(),
        })
    }

    /// The best line over two features that costs less than the cutoff, as far as a few regions show.
    pub(crate) fn best_line(&self, pair: (usize, usize), asked: PairQuestion, stop: &AtomicBool) -> Option<Line> {
        let samples = WeightedSamples {
            plane: &self.plane,
            labels: asked.labels,
            weights: asked.weights,
            loss: asked.loss,
            switches: Switches::default(),
        };
        let dual_planes = [pair, (pair.1, pair.0)].map(|features| self.dual_plane(features));
        let answer = best_of_dual_planes(samples, dual_planes, asked.ids, asked.need, asked.cutoff, MOST_TRIED, stop);
        answer.line.filter(|_| answer.incumbent < asked.cutoff)
    }

    fn dual_plane(&self, (f, g): (usize, usize)) -> &DualPlane {
        let others = self.plane.p - 1;
        let slot = f * others + if g > f { g - 1 } else { g };
        self.dual_planes[slot].get_or_init(|| DualPlane::new(&self.plane, (f, g), SLOPE_INTERVALS))
    }

    /// Whether a line sends a sample left.
    pub(crate) fn sends_left(&self, line: &Line, sample: u32) -> bool {
        line.sends_left(&self.plane, sample)
    }

    /// Coefficients of a line for the values as given, the first 1.
    pub(crate) fn coefficients(&self, line: &Line) -> [f64; 2] {
        let (f, g) = line.features;
        [1.0, line.t * (self.plane.half_spans[f] / self.plane.half_spans[g])]
    }
}

/// The values in units of their own, on a grid where they lie so close that the splitting of regions would not end.
fn plane_of(problem: &Problem, own: &Values) -> Plane {
    let mut ranker = Ranker::default();
    let (mut values, mut ranks) = (Vec::with_capacity(problem.n * problem.p), problem.ranks.to_vec());
    for (f, ranks) in ranks.chunks_mut(problem.n).enumerate() {
        let column: Vec<f64> = own.rows().map(|row| row[f]).collect();
        match on_grid(&column) {
            None => values.extend(column),
            Some(column) => {
                ranker.rank(column.iter().copied(), ranks);
                values.extend(column);
            }
        }
    }
    Plane::new(problem.n, problem.p, &values, &ranks)
}

/// The values rounded to `GRID` of their range, where two of them lie closer than that.
fn on_grid(column: &[f64]) -> Option<Vec<f64>> {
    let mut sorted = column.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
    let step = times_power(1.0, exponent_of(GRID * (high - low)));
    let is_close = sorted.windows(2).any(|pair| pair[0] < pair[1] && pair[1] - pair[0] < step);
    is_close.then(|| column.iter().map(|value| (value / step).round() * step).collect())
}

//! A problem prepared for searching: the data that all restarts share, made once.

pub(crate) mod dual_planes;
pub(crate) mod orders;
pub(crate) mod values;

use std::ops::Deref;
use std::sync::OnceLock;

use crate::gains::prices::Prices;
use crate::prepared::dual_planes::DualPlanes;
use crate::prepared::orders::Orders;
use crate::prepared::values::{Terms, Values};
use crate::tree::rule::{AxisCut, Rule};
use octmip_check::problem::Problem;

/// A problem prepared for searching.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prepared<'a> {
    /// The problem.
    pub(crate) problem: &'a Problem,
    /// What is made of it.
    pub(crate) made: &'a Made,
}

/// What is made of a problem, apart from it, so that whoever keeps the problem can keep this, too.
#[derive(Debug)]
pub(crate) struct Made {
    /// Its gains.
    pub(crate) prices: Prices,
    /// Its samples in every feature's order.
    pub(crate) orders: Orders,
    /// The values of the features in units of their own, those of all that follows; empty without planes.
    pub(crate) values: Values,
    /// Mean of each feature; empty without planes.
    pub(crate) means: Vec<f64>,
    /// Standard deviation of each feature, 1 where it is constant; empty without planes.
    pub(crate) deviations: Vec<f64>,
    /// Values less the mean, by the deviation, sample-major; empty without planes.
    standardised: Vec<f32>,
    /// The most promising cuts of the root, looked for when they are first wanted.
    pub(crate) root_cuts: OnceLock<Vec<AxisCut>>,
    dual_planes: OnceLock<Option<DualPlanes>>,
}

impl Deref for Prepared<'_> {
    type Target = Made;

    fn deref(&self) -> &Made {
        self.made
    }
}

impl Made {
    /// Prepare a problem.
    pub(crate) fn new(problem: &Problem) -> Self {
        let values = Values::new(problem);
        let (means, deviations) = moments(&values, problem.n, problem.p);
        let standardised = standardise(&values, &means, &deviations);
        let (prices, orders) = (Prices::new(problem), Orders::new(problem));
        Self {
            prices,
            orders,
            values,
            means,
            deviations,
            standardised,
            root_cuts: OnceLock::new(),
            dual_planes: OnceLock::new(),
        }
    }
}

impl Prepared<'_> {
    /// Tables of the lines over pairs of features, where they are not too large.
    pub(crate) fn dual_planes(&self) -> Option<&DualPlanes> {
        self.dual_planes.get_or_init(|| DualPlanes::new(self.problem, &self.values)).as_ref()
    }

    /// The standardised values of a sample.
    #[inline]
    pub(crate) fn standardised(&self, sample: u32) -> &[f32] {
        &self.standardised[sample as usize * self.problem.p..][..self.problem.p]
    }

    /// A rule's terms and offset; a cut's offset is the largest value of its rank. None where it is a leaf, or too far
    /// away to be held.
    pub(crate) fn plane_of(&self, rule: &Rule) -> Option<(Terms, f64)> {
        match rule {
            Rule::Leaf => None,
            Rule::Axis { feature, cut } => Some((vec![(*feature, 1.0)], self.value_at(*feature, *cut))),
            Rule::Plane { terms, offset } => {
                self.values.scaled_plane(terms, *offset).map(|(terms, offset, _)| (terms, offset))
            }
        }
    }

    fn value_at(&self, feature: u32, rank: u32) -> f64 {
        let ranks = self.problem.feature(feature as usize);
        let order = self.orders.of(feature);
        let at_rank = order.partition_point(|&i| ranks[i as usize] < rank);
        self.values.row(order[at_rank])[feature as usize]
    }

    /// Whether splits may be hyperplanes.
    pub(crate) fn has_planes(&self) -> bool {
        self.problem.planes.is_some()
    }

    /// Whether splits may be hyperplanes with real coefficients.
    pub(crate) fn has_real_planes(&self) -> bool {
        self.problem.planes.as_ref().is_some_and(|planes| planes.integer_normals.is_none())
    }

    /// Most features in one split.
    pub(crate) fn split_size(&self) -> usize {
        self.problem.planes.as_ref().map_or(1, |planes| planes.split_size.min(self.problem.p))
    }
}

fn moments(values: &Values, n: usize, p: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut means, mut squares) = (vec![0.0; p], vec![0.0; p]);
    let n = n as f64;
    for row in values.rows() {
        means.iter_mut().zip(row).for_each(|(mean, x)| *mean += x / n);
    }
    for row in values.rows() {
        let deviations = row.iter().zip(&means).map(|(x, mean)| x - mean);
        squares.iter_mut().zip(deviations).for_each(|(square, d)| *square += d * d / n);
    }
    let deviation = |square: f64| if square > 0.0 { square.sqrt() } else { 1.0 };
    (means, squares.into_iter().map(deviation).collect())
}

fn standardise(values: &Values, means: &[f64], deviations: &[f64]) -> Vec<f32> {
    let of_row = |row: &[f64]| {
        let terms = row.iter().zip(means).zip(deviations);
        terms.map(|((x, mean), deviation)| ((x - mean) / deviation) as f32).collect::<Vec<f32>>()
    };
    values.rows().flat_map(of_row).collect()
}

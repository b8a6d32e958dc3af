//! The best hyperplane of one node, the rest of the tree fixed: many lines of hyperplanes, one after the other.

use crate::gains::tally::Tally;
use crate::planes::line::{LineScratch, SampledPlane, take_best_step};
use crate::planes::random::normal;
use crate::prepared::Prepared;
use crate::prepared::values::{Terms, normalise};
use crate::tree::allowance::Allowance;
use crate::tree::rule::Rule;
use crate::tree::view::NodeView;
use crate::watch::Supervisor;

/// The search for a node's plane: the present one, its view's samples on both sides, counted in the tally.
pub(crate) struct PlaneSearch<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    /// Asked between two lines whether to go on.
    pub(crate) supervisor: Supervisor<'a>,
    pub(super) plane: SampledPlane,
    /// Sides counted by slot.
    pub(crate) tally: Tally<'a>,
    slopes: Vec<f64>,
    line: LineScratch<'a>,
    kept: (SampledPlane, Tally<'a>),
    /// Gain that a line may lose before it is given up.
    pub(super) patience: i64,
    /// By sample, the side that it prefers and by how much.
    pub(super) preferred: (Vec<u32>, Vec<i64>),
}

/// Share of the gain that a line may lose before it is given up; one line in so many may lose all.
const PATIENCE: f64 = 0.03;
const PATIENT_ONE_IN: u32 = 8;

impl<'a> PlaneSearch<'a> {
    /// A search without a plane yet.
    pub(crate) fn new(prepared: &'a Prepared<'a>, supervisor: Supervisor<'a>) -> Self {
        let tally = Tally::new(&prepared.prices);
        let (line, kept) = (LineScratch::new(&tally), (SampledPlane::default(), tally.clone()));
        Self {
            prepared,
            supervisor,
            plane: SampledPlane::default(),
            slopes: Vec::new(),
            line,
            kept,
            tally,
            patience: 0,
            preferred: Default::default(),
        }
    }

    /// Take up the rule of a node that is no leaf; whether it can be held here.
    pub(crate) fn load(&mut self, view: &NodeView, rule: &Rule) -> bool {
        let values = &self.prepared.values;
        let plane = match rule {
            Rule::Leaf => None,
            Rule::Axis { feature, .. } => {
                Some((vec![(*feature, 1.0)], self.middle_of_gap(view, *feature), values.exponent(*feature)))
            }
            Rule::Plane { terms, offset } => values.scaled_plane(terms, *offset),
        };
        let Some((terms, offset, shift)) = plane else {
            return false;
        };
        self.plane.normal.clear();
        self.plane.normal.resize(self.prepared.problem.p, 0.0);
        self.set(&terms, offset);
        self.plane.shift += shift;
        self.place(view);
        self.patience = (PATIENCE * self.tally.total as f64) as i64;
        true
    }

    fn middle_of_gap(&self, view: &NodeView, f: u32) -> f64 {
        let values = view.samples.iter().map(|&i| self.prepared.values.row(i)[f as usize]);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (value, &is_left) in values.zip(&view.is_left) {
            if is_left { low = low.max(value) } else { high = high.min(value) }
        }
        let middle = low / 2.0 + high / 2.0;
        if low <= middle && middle < high { middle } else { low }
    }

    /// Put all samples where normal and offset send them.
    pub(super) fn place(&mut self, view: &NodeView) {
        let (terms, offset) = (self.terms(), self.plane.offset);
        let height = |&i: &u32| self.prepared.values.project(&terms, i) - offset;
        self.plane.heights.clear();
        self.plane.heights.extend(view.samples.iter().map(height));
        self.plane.is_left.clear();
        self.plane.is_left.extend(self.plane.heights.iter().map(|&height| height <= 0.0));
        view.fill(&mut self.tally, |j| self.plane.is_left[j]);
    }

    pub(super) fn terms(&self) -> Terms {
        let all = self.plane.normal.iter().enumerate();
        all.filter(|(_, c)| **c != 0.0).map(|(f, &c)| (f as u32, c)).collect()
    }

    pub(super) fn support(&self) -> Vec<u32> {
        self.terms().into_iter().map(|(f, _)| f).collect()
    }

    /// The rule as it stands, none where float64 cannot hold it or where it would leave too few samples in some leaf.
    ///
    /// Heights were summed up along the way, and in units of their own: what counts is what the rule itself says of the
    /// samples, which the tally is left with.
    pub(crate) fn rule(&mut self, view: &NodeView) -> Option<Rule> {
        let rule = self.prepared.values.rule(&self.terms(), self.plane.offset, self.plane.shift)?;
        view.fill(&mut self.tally, |j| rule.goes_left(self.prepared.problem, view.samples[j]));
        self.tally.is_large_enough().then_some(rule)
    }

    /// Gain of the sides as they stand, less the price of the features.
    pub(crate) fn gain(&self) -> i64 {
        let size = self.plane.normal.iter().filter(|c| **c != 0.0).count();
        self.tally.total - self.prepared.prices.price(size as i64)
    }

    /// The features read if `f` were read too.
    pub(super) fn support_with(&self, f: u32) -> Vec<u32> {
        let mut support = self.support();
        if let Err(position) = support.binary_search(&f) {
            support.insert(position, f);
        }
        support
    }

    /// Move the offset.
    pub(super) fn shift(&mut self, view: &NodeView, rng: &mut fastrand::Rng) {
        self.slopes.clear();
        self.slopes.resize(view.samples.len(), -1.0);
        let step = self.step(view, rng);
        self.plane.offset += step;
    }

    /// Turn about the points of the plane where `direction . x` is that of a random sample or of the mean.
    pub(super) fn turn(&mut self, view: &NodeView, direction: &[(u32, f64)], rng: &mut fastrand::Rng) {
        let anchor = if rng.u32(..4) == 0 {
            direction.iter().map(|&(f, c)| c * self.prepared.means[f as usize]).sum()
        } else {
            self.prepared.values.project(direction, view.samples[rng.usize(..view.samples.len())])
        };
        self.turn_about(view, direction, anchor, rng);
    }

    pub(super) fn turn_about(
        &mut self,
        view: &NodeView,
        direction: &[(u32, f64)],
        anchor: f64,
        rng: &mut fastrand::Rng,
    ) {
        let values = &self.prepared.values;
        self.slopes.clear();
        self.slopes.extend(view.samples.iter().map(|&i| values.project(direction, i) - anchor));
        let reads_more = direction.iter().any(|&(f, _)| self.plane.normal[f as usize] == 0.0);
        let floor = self.gain();
        let is_priced = reads_more && self.prepared.prices.has_penalty();
        if is_priced {
            self.keep();
        }
        let step = self.step(view, rng);
        if step != 0.0 {
            direction.iter().for_each(|&(f, c)| self.plane.normal[f as usize] += step * c);
            self.plane.offset += step * anchor;
        }
        if is_priced && self.gain() < floor {
            self.go_back();
        }
    }

    fn step(&mut self, view: &NodeView, rng: &mut fastrand::Rng) -> f64 {
        let patience = if rng.u32(..PATIENT_ONE_IN) == 0 { i64::MAX / 2 } else { self.patience };
        let (plane, line) = (&mut self.plane, &mut self.line);
        take_best_step(view, plane, &self.slopes, &mut self.tally, line, patience, rng).unwrap_or(0.0)
    }

    fn keep(&mut self) {
        self.kept.0.clone_from(&self.plane);
        self.kept.1.copy_from(&self.tally);
    }

    fn go_back(&mut self) {
        self.plane.clone_from(&self.kept.0);
        self.tally.copy_from(&self.kept.1);
    }

    /// Try a plane of its own, offset refined; keep it when it gains no less and leaves stay large enough.
    pub(super) fn try_plane(&mut self, view: &NodeView, terms: &[(u32, f64)], offset: f64, rng: &mut fastrand::Rng) {
        self.keep();
        let floor = self.gain();
        self.set(terms, offset);
        self.place(view);
        if !self.tally.is_large_enough() {
            return self.go_back();
        }
        self.shift(view, rng);
        if self.gain() < floor {
            self.go_back();
        }
    }

    /// Set normal and offset, the largest coefficient brought to between a half and 1; `place` must follow.
    pub(super) fn set(&mut self, terms: &[(u32, f64)], offset: f64) {
        let (mut terms, mut offset) = (terms.to_vec(), offset);
        self.plane.shift = normalise(&mut terms, &mut offset);
        self.plane.normal.iter_mut().for_each(|c| *c = 0.0);
        terms.iter().for_each(|&(f, c)| self.plane.normal[f as usize] = c);
        self.plane.offset = offset;
    }

    /// A random direction over as many features as may be read.
    pub(super) fn random_direction(&self, allowance: &Allowance, rng: &mut fastrand::Rng) -> Terms {
        let features = self.some_features(allowance, rng);
        features.into_iter().map(|f| (f, normal(rng) / self.prepared.deviations[f as usize])).collect()
    }

    /// The features read now, and at random others that may be read beside them.
    pub(super) fn some_features(&self, allowance: &Allowance, rng: &mut fastrand::Rng) -> Vec<u32> {
        let mut features = self.support();
        let first = features.len();
        features.extend((0..self.prepared.problem.p as u32).filter(|&f| self.plane.normal[f as usize] == 0.0));
        rng.shuffle(&mut features[first..]);
        allowance.first_admitted(&features, self.prepared.split_size())
    }
}

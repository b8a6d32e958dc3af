//! Best stumps from histograms: a vector pass over bucket edges, then a walk inside the few buckets that may hide more.
//!
//! Slots hold a feature's two sides next to each other; moving the cut over a sample moves it from the one to the
//! other in every feature.

use crate::samples::Samples;
use crate::stumps::groups::{Histogram, Profiles};
use crate::stumps::place::{Place, Stump, StumpSolver, Sums};
use crate::stumps::sweep::Lane;
use crate::stumps::table::{Shape, Table};
use crate::stumps::uncertainty::{Candidate, Sides};
use crate::switches::Switches;
use crate::view::View;

/// Samples of a bucket on average, at most: in long tables a walk inside is the price.
const LONGEST: usize = 128;

/// Buckets of features of so few values are passed sooner than buckets are laid out anew.
const FEW_VALUES: u32 = 64;

/// Stump solver from histograms.
pub(crate) struct Buckets<T: Lane, const N: usize, const S: usize> {
    arch: pulp::Arch,
    pub(super) shape: Shape,
    pub(super) profiles: Profiles<T>,
    /// The change of a sample's cells when it moves from right to left; of differences second, where there are any.
    changes: [Vec<T::Pair>; 2],
    tightens: bool,
    pub(super) tables: [Table; 2],
    /// Whether the first table is laid out for all samples and stays: each feature has few values.
    stays: bool,
    /// 0: the table shared with other views, 1: the view's own.
    pub(super) used: usize,
    pub(super) groups: Vec<Histogram<T, N, S>>,
    scores: Vec<i64>,
    /// Gain that each group may reach on both sides of the cut (`[group][side]`).
    pub(super) reaches: Vec<[i64; 2]>,
    /// The same of each feature, by lane.
    lane_reaches: Vec<[T; N]>,
    k: usize,
    pub(super) totals: [Vec<i64>; 2],
    pub(super) whole: Vec<i64>,
    total_range: [i64; 2],
    lane_totals: Vec<[T; N]>,
    pub(super) candidates: Vec<Candidate>,
    pub(super) left: Vec<i64>,
}

impl<T: Lane, const N: usize, const S: usize> Buckets<T, N, S> {
    /// Without tables yet.
    pub(crate) fn new(samples: &Samples, switches: &Switches) -> Self {
        let profiles = Profiles::new(samples);
        let rows = profiles.rows(samples.n_labels);
        let labels = vec![0; samples.n_labels];
        let has_differences = samples.is_single && samples.n_labels == 2;
        let plain = samples.multiplicity.iter().map(|&multiplicity| T::shift(multiplicity)).collect::<Vec<_>>();
        let signed = plain.iter().zip(&samples.profile).map(|(&by, &label)| if label == 1 { T::back(by) } else { by });
        let differences = if has_differences { signed.collect() } else { Vec::new() };
        Self {
            arch: if switches.vectors { pulp::Arch::new() } else { pulp::Arch::Scalar },
            shape: Shape { slots: S, rows, has_differences },
            profiles,
            changes: [plain, differences],
            tightens: switches.distinct_labels && samples.is_single,
            tables: [Table::default(), Table::default()],
            stays: !samples.order.is_empty() && samples.ranks.iter().all(|&rank| rank < FEW_VALUES),
            used: 1,
            groups: (0..samples.p.div_ceil(S)).map(|group| Histogram::new(group, samples.p)).collect(),
            scores: vec![0; samples.p],
            reaches: Vec::new(),
            lane_reaches: vec![[T::default(); N]; samples.p.div_ceil(S)],
            k: 0,
            totals: [labels.clone(), labels.clone()],
            whole: labels,
            total_range: [0; 2],
            lane_totals: Vec::new(),
            candidates: Vec::new(),
            left: Vec::new(),
        }
    }

    /// Most buckets of a feature: few where the vector pass is the price, more where walks inside are. Under a cost
    /// matrix more is uncertain inside a bucket, so there are more walks.
    fn most_buckets(&self, len: usize) -> usize {
        let cheap = 256 / (self.groups.len() * self.shape.rows);
        let many = if self.profiles.ranges.is_empty() { 2 } else { 4 };
        cheap.max(64).max(many * len.isqrt()).max(len / LONGEST)
    }

    /// Move the totals of both sides.
    fn shift_totals(&mut self, samples: &Samples, place: &Place<'_>) {
        let (from, to) = (self.k.min(place.k), self.k.max(place.k));
        let sign = if place.k > self.k { 1 } else { -1 };
        for &i in &place.view.list(place.f)[from..to] {
            samples.count(i, sign, &mut self.totals[0]);
            if !samples.is_single {
                self.total_range[0] += sign * samples.ranges[i as usize];
            }
        }
        if samples.is_single {
            self.total_range[0] = self.totals[0].iter().sum(); // each gains its cost range, in one label
        }
        for (c, whole) in self.whole.iter().enumerate() {
            self.totals[1][c] = whole - self.totals[0][c];
        }
        self.total_range[1] = place.view.total_range - self.total_range[0];
        self.k = place.k;
    }

    fn set_lane_totals(&mut self) {
        self.lane_totals.clear();
        for (left, right) in self.totals[0].iter().zip(&self.totals[1]) {
            let pair = [T::narrow(*left), T::narrow(*right)];
            self.lane_totals.push(std::array::from_fn(|lane| pair[lane % 2]));
        }
    }

    fn sides(&self, penalty: i64) -> Sides {
        let leaf = [0, 1].map(|side| self.totals[side].iter().copied().max().unwrap_or(0));
        Sides { total_range: self.total_range, leaf, best: leaf, penalty }
    }

    /// By lane, the best gain of a group at a bucket edge and the largest that any of its stumps may have.
    fn sweep(&mut self, group: usize) -> ([T; N], [T; N]) {
        let histogram = &mut self.groups[group];
        if self.tables[self.used].is_difference {
            let best = histogram.sweep_differences(self.arch, &self.lane_totals);
            return (best, best);
        }
        histogram.sweep(self.arch, &self.lane_totals, &self.profiles)
    }

    /// Lower what a group may reach inside its buckets on both sides; whether that was still to be done.
    pub(super) fn tighten(&mut self, group: usize, known: [i64; 2], reach: &mut [i64; 2]) -> bool {
        if !self.tightens || self.groups[group].is_tight {
            return false;
        }
        let left = self.groups[group].tighten(self.arch, &self.lane_totals, known);
        *reach = [0, 1].map(|side| reach[side].min(left[side]));
        true
    }

    /// Sweep a group: its best gain joins `sides.best`, the gain that it may reach is returned.
    fn visit(&mut self, group: usize, sides: &mut Sides) -> [i64; 2] {
        let (best, reach) = self.sweep(group);
        self.lane_reaches[group] = reach;
        let mut reachable = [0; 2];
        for lane in 0..N {
            sides.best[lane % 2] = sides.best[lane % 2].max(best[lane].widen());
            reachable[lane % 2] = reachable[lane % 2].max(reach[lane].widen());
        }
        reachable
    }
}

impl<T: Lane, const N: usize, const S: usize> StumpSolver for Buckets<T, N, S> {
    fn prepare(&mut self, samples: &Samples, view: &View) {
        if !self.stays {
            let most = self.most_buckets(view.len);
            self.tables[0].lay(samples, view, self.shape, most);
        }
    }

    fn forget(&mut self) {
        if !self.stays {
            self.tables[0].len = 0;
        }
    }

    fn load(&mut self, samples: &Samples, view: &View) -> Stump {
        if self.stays && self.tables[0].len == 0 {
            self.tables[0].lay(samples, &View::root(samples), self.shape, FEW_VALUES as usize);
        }
        let is_own = !self.stays && (view.len * 3 < self.tables[0].len || self.tables[0].len == 0);
        self.used = usize::from(is_own);
        if self.used == 1 {
            let most = self.most_buckets(view.len);
            self.tables[1].lay(samples, view, self.shape, most);
        }
        self.totals[0].fill(0);
        self.whole.clone_from(&view.totals);
        self.totals[1].clone_from(&view.totals);
        self.total_range = [0, view.total_range];
        self.k = 0;
        let place = Place::whole(view);
        self.set_lane_totals();
        let mut sides = self.sides(samples.penalty);
        for group in 0..self.groups.len() {
            let table = &self.tables[self.used];
            let changes = &self.changes[usize::from(table.is_difference)];
            self.groups[group].load(samples, view, (table, changes), self.shape);
            let (best, reach) = self.sweep(group);
            self.lane_reaches[group] = reach;
            let first = group * self.shape.slots;
            for f in first..(first + self.shape.slots).min(samples.p) {
                let lane = 2 * (f - first) + 1;
                self.scores[f] = best[lane].widen();
                sides.best[1] = sides.best[1].max(best[lane].widen());
            }
            let mut reachable = [0, reach.iter().skip(1).step_by(2).map(|r| r.widen()).max().unwrap_or(0)];
            if reachable[1] > sides.best[1] {
                self.tighten(group, sides.best, &mut reachable);
                self.refine(samples, &place, (group, 1), &mut sides, &mut reachable, i64::MAX);
            }
        }
        let cost = sides.cost(1, sides.best[1]);
        Stump { lower: cost, value: cost }
    }

    fn scores(&self) -> &[i64] {
        &self.scores
    }

    fn sums(&self, side: usize) -> Sums<'_> {
        (&self.totals[side], self.total_range[side])
    }

    fn reach(&self, f: usize, side: usize) -> i64 {
        self.lane_reaches[f / self.shape.slots][2 * (f % self.shape.slots) + side].widen()
    }

    fn rewind(&mut self) {
        self.groups.iter_mut().for_each(Histogram::rewind);
        self.totals[0].fill(0);
        self.total_range[0] = 0;
        self.k = 0;
    }

    fn both(&mut self, samples: &Samples, place: &Place<'_>, threshold: i64) -> [Stump; 2] {
        self.shift_totals(samples, place);
        self.set_lane_totals();
        let mut sides = self.sides(samples.penalty);
        self.reaches.clear();
        for group in 0..self.groups.len() {
            let table = &self.tables[self.used];
            self.groups[group].shift(place, table, &self.changes[usize::from(table.is_difference)]);
            let reach = self.visit(group, &mut sides);
            self.reaches.push(reach);
        }
        if let Some(side) = place.leaf_side {
            sides.best[side] = sides.leaf[side];
            self.reaches.iter_mut().for_each(|reach| reach[side] = 0);
        }
        self.finish(samples, place, &mut sides, threshold);
        let reach = [0, 1].map(|side| {
            let open = self.reaches.iter().map(|reach| reach[side]).max();
            open.unwrap_or(0).max(sides.best[side])
        });
        [0, 1].map(|side| Stump { lower: sides.cost(side, reach[side]), value: sides.cost(side, sides.best[side]) })
    }
}

//! The best single split of any subset of the samples, exactly: leaf, axis-aligned or over two features.
//!
//! A strip's bins give every one of its regions a bound in one pass: a sample counts as left wherever its lower bin is at
//! or below the region, as right wherever its higher bin is at or above it. Regions that could still win are split as
//! cells, the most promising first, until all their open samples can be parted in a few ways.

use std::sync::atomic::{AtomicBool, Ordering};

use super::cell::{Cell, EPS};
use super::chart::{Chart, REGIONS};
use super::ends::{End, can_part, end_of};
use super::loss::{INFEASIBLE, Loss};
use super::margin::widest_line;
use super::plane::Plane;

/// Lines that keep this clear of all samples part them in floating point as they do in exact arithmetic.
pub const THICK: f64 = 2.0 * EPS;

/// Neighbouring strips that are bounded together at first.
const GROUP: usize = 16;
/// So few samples leave most regions of most strips empty: cells over many strips settle them faster.
const FEW: usize = 96;

/// The line `x_f + t x_g = r` in scaled coordinates; samples at or below it go left.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Line {
    pub features: (usize, usize),
    pub t: f64,
    pub r: f64,
}

impl Line {
    /// Whether a sample goes left.
    #[inline]
    pub fn sends_left(&self, plane: &Plane, i: u32) -> bool {
        let (f, g) = self.features;
        plane.column(f)[i as usize] + self.t * plane.column(g)[i as usize] <= self.r
    }

    /// Whether the line keeps clear of some samples by more than rounding can matter.
    pub fn is_clear_of(&self, plane: &Plane, ids: &[u32]) -> bool {
        let (x, y) = (plane.column(self.features.0), plane.column(self.features.1));
        let distance = |i: u32| (x[i as usize] + self.t * y[i as usize] - self.r).abs();
        ids.iter().all(|&i| distance(i) > EPS)
    }
}

/// The samples of a problem as a stump sees them: labels and weights may be others than the problem's.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Coordinates.
    pub plane: &'a Plane,
    /// Class of each sample.
    pub labels: &'a [u32],
    /// Weight of each sample.
    pub weights: &'a [i64],
    /// Costs and prices.
    pub loss: &'a Loss,
}

impl View<'_> {
    /// Class weights and number of some samples.
    pub fn tally(&self, ids: &[u32]) -> Vec<i64> {
        let mut tally = vec![0; self.loss.lanes()];
        for &i in ids {
            self.add(&mut tally, i);
        }
        tally
    }

    /// Count one sample.
    #[inline]
    pub fn add(&self, tally: &mut [i64], i: u32) {
        tally[self.labels[i as usize] as usize] += self.weights[i as usize];
        tally[self.loss.k] += 1;
    }

    /// Price of a split over these features.
    pub fn price(&self, features: (usize, usize)) -> i64 {
        self.loss.prices[usize::from(features.1 != self.plane.p)]
    }

    /// What a line costs with the best label on both sides.
    pub fn cost_of(&self, line: &Line, ids: &[u32], total: &[i64], need: i64) -> i64 {
        let mut left = vec![0; self.loss.lanes()];
        for &i in ids {
            if line.sends_left(self.plane, i) {
                self.add(&mut left, i);
            }
        }
        let right = difference(total, &left);
        let cost = self.loss.sides(&left, &right, need);
        (cost + self.price(line.features)).min(INFEASIBLE)
    }
}

pub(super) fn difference(a: &[i64], b: &[i64]) -> Vec<i64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// A strip of a chart, and a lower bound of what a split in it costs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Strip {
    pub chart: u32,
    pub strip: u32,
    pub bound: i64,
}

/// What is asked of a search for the best split.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// The samples.
    pub ids: &'a [u32],
    /// Fewest samples on a side.
    pub need: i64,
    /// Answers of this much and more need not be told apart.
    pub cutoff: i64,
    /// No split is known to cost less.
    pub floor: i64,
    /// Once less than this is attained, the answer no longer matters.
    pub hopeless: i64,
    /// Regions that are split at most; fewer than all give a good split, but no bound.
    pub most_tried: usize,
    /// Strips whose own bound is this much or more are left out.
    pub dead: i64,
}

/// The answer: every split outside dead strips costs at least `lower`; `line` (none: a leaf) costs `attained`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Answer {
    pub lower: i64,
    pub attained: i64,
    pub line: Option<Line>,
}

/// A region that could still win.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    bound: i64,
    order: u32,
    features: (usize, usize),
    cell: Cell,
}

/// A search for the best split of one set of samples.
pub struct Search<'a> {
    view: View<'a>,
    ids: &'a [u32],
    total: Vec<i64>,
    need: i64,
    stop: &'a AtomicBool,
    /// Splits that cost this much or more are of no interest.
    current: i64,
    attained: i64,
    line: Option<Line>,
    /// Least cost of a way of parting that no line does with room for rounding.
    thin: i64,
    candidates: Vec<Candidate>,
    chart_start: usize,
    /// So many regions are split at most: all of them for an exact answer.
    most_tried: usize,
    low: Vec<i64>,
    high: Vec<i64>,
}

impl<'a> Search<'a> {
    /// Begin with a leaf as the answer.
    pub fn new(
        view: View<'a>,
        ids: &'a [u32],
        need: i64,
        cutoff: i64,
        stop: &'a AtomicBool,
    ) -> Self {
        let total = view.tally(ids);
        let leaf = if total[view.loss.k] >= need {
            view.loss.leaf(&total).0
        } else {
            INFEASIBLE
        };
        let size = REGIONS * view.loss.lanes().next_power_of_two();
        Self {
            view,
            ids,
            total,
            need,
            stop,
            current: leaf.min(cutoff),
            attained: leaf,
            line: None,
            thin: INFEASIBLE,
            candidates: Vec::new(),
            chart_start: 0,
            most_tried: usize::MAX,
            low: vec![0; size],
            high: vec![0; size],
        }
    }

    /// Try lines that were good elsewhere.
    pub fn try_lines(&mut self, lines: impl IntoIterator<Item = Line>) {
        for line in lines {
            let cost = self.view.cost_of(&line, self.ids, &self.total, self.need);
            if cost < self.attained && line.is_clear_of(self.view.plane, self.ids) {
                self.offer(cost, line);
            }
        }
    }

    fn offer(&mut self, cost: i64, line: Line) {
        if cost < self.attained {
            self.attained = cost;
            self.line = Some(line);
            self.current = self.current.min(cost);
        }
    }

    /// Bound the lines between two strip boundaries by their regions and return the least bound.
    ///
    /// `keeps`: remember the regions that could still win.
    pub fn scan(&mut self, chart: &Chart, (from, to): (usize, usize), keeps: bool) -> i64 {
        let lanes = self.view.loss.lanes();
        let lane_bits = lanes.next_power_of_two().trailing_zeros();
        // Few samples need few regions: neighbours are taken together.
        let merged = (REGIONS / (self.ids.len() / 4).clamp(8, REGIONS)).ilog2();
        self.count_bins(chart.bins(from), chart.bins(to), merged, lane_bits);
        let price = self.view.price(chart.features);
        let mut may_left = vec![0i64; lanes];
        let mut may_right = self.total.clone();
        let mut least = INFEASIBLE;
        for region in 0..REGIONS >> merged {
            let slot = region << lane_bits;
            for (sum, count) in may_left.iter_mut().zip(&self.low[slot..]) {
                *sum += count;
            }
            let loss = self.view.loss;
            let bound = loss.bound(&self.total, &may_left, &may_right, self.need) + price;
            if bound < least.max(self.current) {
                // A region without room between its edges holds no line of its own.
                let regions = (region << merged, (region + 1) << merged);
                let cell = chart.cell((from, to), regions);
                if cell.has_room() {
                    least = least.min(bound);
                    if keeps && bound < self.current {
                        let features = chart.features;
                        let order = self.candidates.len() as u32;
                        self.candidates.push(Candidate {
                            bound,
                            order,
                            features,
                            cell,
                        });
                    }
                }
            }
            for (sum, count) in may_right.iter_mut().zip(&self.high[slot..]) {
                *sum -= count;
            }
        }
        least
    }

    fn count_bins(&mut self, first: &[u8], last: &[u8], merged: u32, lane_bits: u32) {
        let used = (REGIONS >> merged) << lane_bits;
        self.low[..used].fill(0);
        self.high[..used].fill(0);
        let (labels, weights) = (self.view.labels, self.view.weights);
        let k = self.view.loss.k;
        let counts_samples = self.need > 1;
        for &i in self.ids {
            let i = i as usize;
            let (a, b) = (first[i] >> merged, last[i] >> merged);
            let low = (a.min(b) as usize) << lane_bits;
            let high = (a.max(b) as usize) << lane_bits;
            let class = labels[i] as usize;
            self.low[low + class] += weights[i];
            self.high[high + class] += weights[i];
            if counts_samples {
                self.low[low + k] += 1;
                self.high[high + k] += 1;
            }
        }
        if !counts_samples {
            // Without counts no region may look too empty for a leaf.
            self.low[k] = self.total[k];
        }
    }

    /// Bound neighbouring strips of one chart, many at once where that is enough.
    fn scan_group(&mut self, chart: &Chart, strips: &mut [Strip], dead: i64) {
        let limit = self.current.min(dead);
        if strips.iter().all(|strip| strip.bound >= limit) || self.is_stopped() {
            return;
        }
        let from = strips[0].strip as usize;
        let bound = self.scan(chart, (from, from + strips.len()), strips.len() == 1);
        for strip in strips.iter_mut() {
            strip.bound = strip.bound.max(bound);
        }
        if bound < self.current && strips.len() > 1 {
            for part in strips.chunks_mut(strips.len().div_ceil(4)) {
                self.scan_group(chart, part, dead);
            }
        }
    }

    /// Bound neighbouring strips as one cell each, for few samples.
    fn scan_runs(&mut self, charts: &[Chart], strips: &[Strip], dead: i64) {
        let alive = |strip: &&Strip| strip.bound < dead.min(self.current);
        let alive: Vec<Strip> = strips.iter().filter(alive).copied().collect();
        let runs = alive.chunk_by(|a, b| a.chart == b.chart && a.strip + 1 == b.strip);
        for run in runs {
            let chart = &charts[run[0].chart as usize];
            let (first, last) = (run[0].strip as usize, run[run.len() - 1].strip as usize);
            let cell = self.cell_around(chart.features, chart.t[first], chart.t[last + 1]);
            self.candidates.push(Candidate {
                bound: run.iter().map(|strip| strip.bound).min().unwrap_or(0),
                order: self.candidates.len() as u32,
                features: chart.features,
                cell,
            });
        }
    }

    /// The cell of all lines that part the samples at all, between two values of t.
    fn cell_around(&self, (f, g): (usize, usize), t0: f64, t1: f64) -> Cell {
        let (x, y) = (self.view.plane.column(f), self.view.plane.column(g));
        let range = |t: f64| {
            let reach = self.ids.iter().map(|&i| x[i as usize] + t * y[i as usize]);
            reach.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| {
                (l.min(r), h.max(r))
            })
        };
        const ROOM: f64 = 1e-6;
        let ((l0, u0), (l1, u1)) = (range(t0), range(t1));
        Cell {
            t0,
            t1,
            l0: l0 - ROOM,
            l1: l1 - ROOM,
            u0: u0 + ROOM,
            u1: u1 + ROOM,
        }
    }

    /// Note where the regions of the next chart begin.
    pub fn begin_chart(&mut self) {
        self.chart_start = self.candidates.len();
    }

    /// Try the middle of the most promising region since `begin_chart`: a better incumbent spares later charts.
    pub fn try_best_of_chart(&mut self) {
        let newest = &self.candidates[self.chart_start..];
        if let Some(best) = newest
            .iter()
            .min_by_key(|candidate| candidate.bound)
            .copied()
        {
            let (t, r) = best.cell.center();
            self.try_lines([Line {
                features: best.features,
                t,
                r,
            }]);
            let current = self.current;
            self.candidates
                .retain(|candidate| candidate.bound < current);
        }
    }

    /// Split the regions that could still win until none is left; returns the answer.
    pub fn finish(mut self, floor: i64) -> Answer {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable_by_key(|candidate| (candidate.bound, candidate.order));
        for candidate in candidates.into_iter().take(self.most_tried) {
            if candidate.bound >= self.current || self.current <= floor || self.is_stopped() {
                break;
            }
            self.refine(candidate);
        }
        Answer {
            lower: self.current.min(self.thin).max(floor),
            attained: self.attained,
            line: self.line,
        }
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn refine(&mut self, candidate: Candidate) {
        let root = self.part_of(candidate.features, candidate.cell, self.ids, None);
        let mut stack = vec![root];
        while let Some(part) = stack.pop() {
            if part.bound >= self.current || self.is_stopped() {
                continue;
            }
            self.try_center(candidate.features, &part);
            match end_of(self.view.plane, candidate.features, &part.cell, &part.open) {
                End::Parts { points, ways } => {
                    self.close(candidate.features, &part, &points, &ways);
                }
                End::Stuck => self.thin = self.thin.min(part.bound),
                End::Split => {
                    let cells = split(
                        self.view.plane,
                        candidate.features,
                        &part.cell,
                        &part.open,
                        None,
                    );
                    let mut parts = cells.map(|cell| {
                        self.part_of(candidate.features, cell, &part.open, Some(&part))
                    });
                    if parts[0].bound < parts[1].bound {
                        parts.reverse(); // the better one on top of the stack
                    }
                    stack.extend(parts);
                }
            }
        }
    }

    fn part_of(
        &self,
        features: (usize, usize),
        cell: Cell,
        ids: &[u32],
        parent: Option<&Part>,
    ) -> Part {
        let zero = || vec![0; self.view.loss.lanes()];
        let mut left = parent.map_or_else(zero, |part| part.left.clone());
        let mut right = parent.map_or_else(zero, |part| part.right.clone());
        let (x, y) = (
            self.view.plane.column(features.0),
            self.view.plane.column(features.1),
        );
        let open = cell.sort(x, y, ids, |i, goes_left| {
            self.view
                .add(if goes_left { &mut left } else { &mut right }, i);
        });
        let may_left = difference(&self.total, &right);
        let may_right = difference(&self.total, &left);
        let bound = self
            .view
            .loss
            .bound(&self.total, &may_left, &may_right, self.need)
            + self.view.price(features);
        Part {
            cell,
            left,
            right,
            open,
            bound,
        }
    }

    fn try_center(&mut self, features: (usize, usize), part: &Part) {
        let (t, r) = part.cell.center();
        let line = Line { features, t, r };
        let mut left = part.left.clone();
        for &i in &part.open {
            if line.sends_left(self.view.plane, i) {
                self.view.add(&mut left, i);
            }
        }
        let cost = self.cost_of_left(features, &left);
        if cost < self.attained && line.is_clear_of(self.view.plane, &part.open) {
            self.offer(cost, line);
        }
    }

    fn cost_of_left(&self, features: (usize, usize), left: &[i64]) -> i64 {
        let right = difference(&self.total, left);
        let cost = self.view.loss.sides(left, &right, self.need);
        cost + self.view.price(features)
    }

    /// Look at every way in which a line of the cell can part its open points.
    fn close(
        &mut self,
        features: (usize, usize),
        part: &Part,
        points: &[Vec<u32>],
        ways: &[Vec<bool>],
    ) {
        for way in ways {
            let mut left = part.left.clone();
            for (point, _) in points.iter().zip(way).filter(|(_, goes_left)| **goes_left) {
                for &i in point {
                    self.view.add(&mut left, i);
                }
            }
            let cost = self.cost_of_left(features, &left);
            if cost >= self.current {
                continue;
            }
            match realise(self.view.plane, features, &part.cell, self.ids, points, way) {
                Realised::Line(line) => self.offer(cost, line),
                Realised::Thin => self.thin = self.thin.min(cost),
                Realised::Never => {}
            }
        }
    }
}

struct Part {
    cell: Cell,
    left: Vec<i64>,
    right: Vec<i64>,
    open: Vec<u32>,
    bound: i64,
}

/// Split a cell in t (at `at`, or in the middle) or in r, whichever leaves fewer samples open.
pub(super) fn split(
    plane: &Plane,
    (f, g): (usize, usize),
    cell: &Cell,
    open: &[u32],
    at: Option<f64>,
) -> [Cell; 2] {
    let (x, y) = (plane.column(f), plane.column(g));
    let (m0, m1) = cell.middle_edge(x, y, open);
    let by_r = cell.split_r(m0, m1);
    if !cell.is_wide() {
        return by_r;
    }
    let by_t = cell.split_t(at.unwrap_or((cell.t0 + cell.t1) / 2.0));
    if !cell.is_high() || Cell::count_open(&by_t, x, y, open) <= Cell::count_open(&by_r, x, y, open)
    {
        by_t
    } else {
        by_r
    }
}

/// Whether a line parts the samples in a given way.
pub(super) enum Realised {
    /// This one does, with room for rounding.
    Line(Line),
    /// One does, but too close to some samples for floating point.
    Thin,
    /// None does, in this cell at least.
    Never,
}

/// Find a line of the cell that parts the open points in this way.
pub(super) fn realise(
    plane: &Plane,
    features: (usize, usize),
    cell: &Cell,
    ids: &[u32],
    points: &[Vec<u32>],
    way: &[bool],
) -> Realised {
    let side = |wanted: bool| -> Vec<u32> {
        let chosen = points.iter().zip(way).filter(|(_, w)| **w == wanted);
        chosen.map(|(point, _)| point[0]).collect()
    };
    let (distance, t, r) = cell.clearest(plane, features, &side(true), &side(false));
    if distance > THICK {
        return Realised::Line(Line { features, t, r });
    }
    if distance < -THICK {
        return Realised::Never;
    }
    // On the cell's edge, or between samples nearly on one line: all samples decide, in exact arithmetic.
    let (mut left, mut right) = (Vec::new(), Vec::new());
    let (x, y) = (plane.column(features.0), plane.column(features.1));
    cell.sort(x, y, ids, |i, goes_left| {
        if goes_left { &mut left } else { &mut right }.push(i);
    });
    for (point, goes_left) in points.iter().zip(way) {
        if *goes_left { &mut left } else { &mut right }.extend(point);
    }
    match can_part(plane, features, &left, &right) {
        Some(false) => Realised::Never,
        None => Realised::Thin,
        Some(true) => match widest_line(plane, features, &left, &right) {
            Some((line, margin)) if margin > THICK => Realised::Line(line),
            _ => Realised::Thin,
        },
    }
}

/// Find the best split, looking only at strips that could hold it; their bounds are raised to what was learnt.
///
/// A raised bound holds for these samples and for every set that contains them.
pub fn best_split(
    view: View<'_>,
    charts: &[Chart],
    question: Question<'_>,
    lines: impl IntoIterator<Item = Line>,
    strips: &mut [Strip],
    stop: &AtomicBool,
) -> Answer {
    let mut search = Search::new(view, question.ids, question.need, question.cutoff, stop);
    search.most_tried = question.most_tried;
    search.try_lines(lines);
    if search.attained <= question.floor {
        return search.finish(question.floor);
    }
    if question.ids.len() <= FEW {
        search.scan_runs(charts, strips, question.dead);
        return search.finish(question.floor);
    }
    let neighbours = |a: &Strip, b: &Strip| a.chart == b.chart && a.strip + 1 == b.strip;
    for run in strips.chunk_by_mut(neighbours) {
        let chart = &charts[run[0].chart as usize];
        search.begin_chart();
        for group in run.chunks_mut(GROUP) {
            search.scan_group(chart, group, question.dead);
        }
        search.try_best_of_chart();
        if search.attained < question.hopeless {
            // The strips have learnt something; the answer is not worth the rest.
            return Answer {
                lower: question.floor,
                attained: search.attained,
                line: search.line,
            };
        }
    }
    search.finish(question.floor)
}

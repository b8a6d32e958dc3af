//! Histograms of the two sides of a cut, one for each group of features.

use crate::samples::Samples;
use crate::stumps::aligned::Aligned;
use crate::stumps::cells::{Cell, Cells};
use crate::stumps::place::Place;
use crate::stumps::sweep::{Difference, Distinct, Group, Lane, STRIDE};
use crate::stumps::table::{Shape, Table};
use crate::view::View;

/// Gains of one sample of each cost profile, as the lanes count them.
#[derive(Debug)]
pub(crate) struct Profiles<T> {
    /// In each label (`profiles * labels`); empty where each profile gains in its own label.
    pub(crate) gains: Vec<T>,
    /// At most (`profiles`); empty likewise.
    pub(crate) ranges: Vec<T>,
    /// Twice the span that is left beside each direction (`directions * profiles`); empty likewise.
    pub(crate) spans: Vec<i64>,
    /// The largest of them (`profiles`); empty likewise.
    pub(crate) largest_spans: Vec<T>,
}

impl<T: Lane> Profiles<T> {
    /// Gains of the cost profiles of these samples.
    pub(crate) fn new(samples: &Samples) -> Self {
        let profiles = if samples.is_single { 0 } else { samples.n_profiles() };
        let largest = |profile| samples.spans.iter().skip(profile).step_by(profiles).copied().max().unwrap_or(0);
        let range = |profile| samples.gains_of(profile).iter().copied().max().unwrap_or(0);
        Self {
            gains: (0..profiles).flat_map(|profile| samples.gains_of(profile)).map(|&gain| T::narrow(gain)).collect(),
            ranges: (0..profiles).map(|profile| T::narrow(range(profile))).collect(),
            spans: samples.spans.clone(),
            largest_spans: (0..profiles).map(|profile| T::narrow(largest(profile))).collect(),
        }
    }

    /// Rows of a bucket: one per profile.
    pub(crate) fn rows(&self, n_labels: usize) -> usize {
        if self.ranges.is_empty() { n_labels } else { self.ranges.len() }
    }
}

/// A histogram of the slots of one group: pairs `[bucket][row][slot]`.
pub(crate) struct Histogram<T: Lane, const N: usize, const S: usize> {
    pairs: Aligned<T::Pair>,
    start: Vec<T::Pair>,
    open: Vec<[T; N]>,
    /// Largest gain inside each bucket, from the last pass.
    pub(crate) caps: Vec<[T; N]>,
    /// The same over `STRIDE` buckets.
    pub(crate) tops: Vec<[T; N]>,
    /// The larger gain of each bucket's two edges, where samples gain in several labels.
    scores: Vec<[T; N]>,
    runs: Vec<[T; N]>,
    /// Whether the bounds of the last pass were lowered.
    pub(crate) is_tight: bool,
    /// Samples left of the cut.
    k: usize,
    group: usize,
    /// Slots that have a feature.
    used: usize,
}

impl<T: Lane, const N: usize, const S: usize> Histogram<T, N, S> {
    /// The histogram of one group, empty.
    pub(crate) fn new(group: usize, p: usize) -> Self {
        Self {
            pairs: Aligned::default(),
            start: Vec::new(),
            open: Vec::new(),
            caps: Vec::new(),
            tops: Vec::new(),
            scores: Vec::new(),
            runs: Vec::new(),
            is_tight: false,
            k: 0,
            group,
            used: (p - group * S).min(S),
        }
    }

    /// Enter all samples of a view on the right.
    pub(crate) fn load(
        &mut self,
        samples: &Samples,
        view: &View,
        (table, changes): (&Table, &[T::Pair]),
        shape: Shape,
    ) {
        let b = table.n_buckets;
        let per_group = b * table.rows(shape) * shape.slots;
        self.pairs.zero(per_group);
        if table.is_difference {
            let bias = T::BIAS.widen();
            let both = T::change(T::enter(T::shift(2 * bias)), T::shift(bias));
            self.pairs.get_mut().fill(both);
        }
        self.open.clear();
        self.open.resize(b, [T::default(); N]);
        self.caps.resize(b, [T::default(); N]);
        self.scores.resize(if samples.is_single { 0 } else { b }, [T::default(); N]);
        self.tops.resize(b / STRIDE, [T::default(); N]);
        self.runs.resize(b / STRIDE * samples.n_labels, [T::default(); N]);
        for f in self.group * shape.slots..((self.group + 1) * shape.slots).min(samples.p) {
            let lane = 2 * (f % shape.slots);
            for bucket in (0..b).filter(|bucket| table.is_open[f * b + bucket]) {
                self.open[bucket][lane..lane + 2].fill(T::MAX);
            }
        }
        view.with_ids(|ids| self.apply(table, ids, changes, T::enter));
        self.start.clear();
        self.start.extend_from_slice(self.pairs.get());
        self.k = 0;
    }

    /// Put the cut back to 0.
    pub(crate) fn rewind(&mut self) {
        if self.k > 0 {
            self.pairs.get_mut().copy_from_slice(&self.start);
            self.k = 0;
        }
    }

    /// Move the cut.
    pub(crate) fn shift(&mut self, place: &Place<'_>, table: &Table, changes: &[T::Pair]) {
        let list = place.view.list(place.f);
        if place.k > self.k {
            self.apply(table, &list[self.k..place.k], changes, |by| by);
        } else {
            self.apply(table, &list[place.k..self.k], changes, T::back);
        }
        self.k = place.k;
    }

    /// Apply a change to all slots for every sample of `ids`.
    fn apply(&mut self, table: &Table, ids: &[u32], changes: &[T::Pair], change: impl Fn(T::Pair) -> T::Pair) {
        match &table.cells {
            Cells::Narrow(cells) => self.apply_to(cells, ids, changes, change),
            Cells::Wide(cells) => self.apply_to(cells, ids, changes, change),
        }
    }

    fn apply_to<C: Cell>(
        &mut self,
        cells: &[C],
        ids: &[u32],
        changes: &[T::Pair],
        change: impl Fn(T::Pair) -> T::Pair,
    ) {
        let n = changes.len();
        let cells = &cells.as_chunks::<S>().0[self.group * n..(self.group + 1) * n];
        let pairs = self.pairs.with_room();
        for &i in ids {
            let by = change(changes[i as usize]);
            let mut move_to = |cell: C| {
                let pair = cell.of(pairs);
                *pair = T::change(*pair, by);
            };
            let row = &cells[i as usize];
            if self.used == S {
                row.iter().for_each(|&cell| move_to(cell));
            } else {
                row[..self.used].iter().for_each(|&cell| move_to(cell));
            }
        }
    }

    /// The vector pass: by lane, the best gain at a bucket edge and the largest that any stump may have.
    pub(crate) fn sweep(&mut self, arch: pulp::Arch, totals: &[[T; N]], profiles: &Profiles<T>) -> ([T; N], [T; N]) {
        let rows = profiles.rows(totals.len());
        let histogram: &[T] = pulp::bytemuck::cast_slice(self.pairs.get());
        let mut group = Group {
            histogram: &histogram.as_chunks::<N>().0[..self.open.len() * rows],
            open: &self.open,
            totals,
            caps: &mut self.caps,
            tops: &mut self.tops,
            runs: &mut self.runs,
            gains: &profiles.gains,
            ranges: &profiles.ranges,
            scores: &mut self.scores,
            spans: &profiles.largest_spans,
            is_half: 4 * self.used <= N,
            best: [T::default(); N],
            reach: [T::default(); N],
        };
        arch.dispatch(&mut group);
        self.is_tight = false;
        (group.best, group.reach)
    }

    /// Lower the bounds of what lies inside the buckets, where they are above the gains of both sides that are `known`:
    /// the largest that is left on each side.
    pub(crate) fn tighten(&mut self, arch: pulp::Arch, totals: &[[T; N]], known: [i64; 2]) -> [i64; 2] {
        let histogram: &[T] = pulp::bytemuck::cast_slice(self.pairs.get());
        let mut left = known.map(|gain| T::narrow(gain));
        arch.dispatch(&mut Distinct {
            histogram: &histogram.as_chunks::<N>().0[..self.open.len() * totals.len()],
            totals,
            runs: &self.runs,
            known: std::array::from_fn(|lane| left[lane % 2]),
            caps: &mut self.caps,
            tops: &mut self.tops,
        });
        self.is_tight = true;
        for top in &self.tops {
            for lane in 0..N {
                left[lane % 2] = left[lane % 2].max(top[lane]);
            }
        }
        left.map(Lane::widen)
    }

    /// The vector pass over differences: by lane, the best gain, which no stump surpasses.
    pub(crate) fn sweep_differences(&self, arch: pulp::Arch, totals: &[[T; N]]) -> [T; N] {
        let histogram: &[T] = pulp::bytemuck::cast_slice(self.pairs.get());
        let mut pass =
            Difference { histogram: &histogram.as_chunks::<N>().0[..self.open.len()], totals, best: [T::default(); N] };
        arch.dispatch(&mut pass);
        pass.best
    }

    /// Largest gain inside a bucket on one lane, `cap` that of the last pass.
    ///
    /// The pass takes the largest span of each profile beside any direction, all but the largest of these products. So
    /// it takes no less than is left beside the best direction, which is what this counts.
    pub(crate) fn cap(&self, lane: usize, bucket: usize, profiles: &Profiles<T>, cap: i64) -> i64 {
        let rows = profiles.ranges.len();
        if rows == 0 {
            return cap;
        }
        let histogram: &[T] = pulp::bytemuck::cast_slice(self.pairs.get());
        let held = |profile: usize| histogram[(bucket * rows + profile) * N + lane].widen();
        let left = |spans: &[i64]| spans.iter().enumerate().map(|(profile, span)| held(profile) * span).sum::<i64>();
        let doubled = profiles.spans.chunks_exact(rows).map(left).min().unwrap_or(0);
        cap.min(self.scores[bucket][lane].widen() + doubled / 2)
    }

    /// Gains left of a bucket's start on one lane, from the last checkpoint of the last pass.
    pub(crate) fn running_sums(&self, lane: usize, bucket: usize, profiles: &Profiles<T>, sums: &mut [i64]) {
        let checkpoint = &self.runs[bucket / STRIDE * sums.len()..][..sums.len()];
        for (sum, row) in sums.iter_mut().zip(checkpoint) {
            *sum = row[lane].widen();
        }
        let histogram: &[T] = pulp::bytemuck::cast_slice(self.pairs.get());
        let rows = profiles.rows(sums.len());
        let (first, past) = (bucket / STRIDE * STRIDE * rows, bucket * rows);
        for row in 0..rows {
            let held =
                (first..past).step_by(rows).map(|bucket| histogram[(bucket + row) * N + lane].widen()).sum::<i64>();
            if profiles.ranges.is_empty() {
                sums[row] += held;
            } else {
                let gains = &profiles.gains[row * sums.len()..];
                for (sum, gain) in sums.iter_mut().zip(gains) {
                    *sum += held * gain.widen();
                }
            }
        }
    }
}

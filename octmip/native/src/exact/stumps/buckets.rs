//! Best stumps from histograms: a vector pass over bucket edges, then a walk inside the few buckets that may hide more.
//!
//! Lane `2 f` holds feature `f` of the left side, lane `2 f + 1` of the right; moving the cut over a sample moves it
//! from the one to the other in every feature.

use crate::exact::Switches;
use crate::exact::samples::Samples;
use crate::exact::stumps::sweep::{Group, Lane, STRIDE};
use crate::exact::stumps::table::{Shape, Table};
use crate::exact::stumps::{Place, Stump, Stumps};
use crate::exact::view::View;

/// See the module.
pub struct Buckets<T, const N: usize> {
    arch: pulp::Arch,
    shape: Shape,
    n_groups: usize,
    shared: Table,
    own: Table,
    uses_own: bool,
    histogram: Vec<[T; N]>,
    start: Vec<[T; N]>,
    open: Vec<[T; N]>,
    caps: Vec<[T; N]>,
    runs: Vec<[T; N]>,
    best: Vec<[T; N]>,
    k: usize,
    totals: [Vec<i64>; 2],
    mass: [i64; 2],
    candidates: Vec<Candidate>,
    left: Vec<i64>,
}

/// A bucket that may hide a better stump.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    cap: i64,
    feature: usize,
    bucket: usize,
}

impl<T: Lane, const N: usize> Buckets<T, N> {
    /// Without tables yet.
    pub fn new(samples: &Samples, switches: &Switches) -> Self {
        let rows = samples.n_columns + usize::from(!samples.is_single);
        Self {
            arch: if switches.vectors {
                pulp::Arch::new()
            } else {
                pulp::Arch::Scalar
            },
            shape: Shape { lanes: N, rows },
            n_groups: (2 * samples.p).div_ceil(N),
            shared: Table::default(),
            own: Table::default(),
            uses_own: true,
            histogram: Vec::new(),
            start: Vec::new(),
            open: Vec::new(),
            caps: Vec::new(),
            runs: Vec::new(),
            best: Vec::new(),
            k: 0,
            totals: [vec![0; samples.n_columns], vec![0; samples.n_columns]],
            mass: [0; 2],
            candidates: Vec::new(),
            left: Vec::new(),
        }
    }

    fn table(&self) -> &Table {
        if self.uses_own {
            &self.own
        } else {
            &self.shared
        }
    }

    /// Move the cut to `k`.
    fn shift(&mut self, samples: &Samples, place: &Place<'_>) {
        let list = place.view.list(place.f);
        let (from, to) = (self.k.min(place.k), self.k.max(place.k));
        let sign = if place.k > self.k { 1 } else { -1 };
        for &i in &list[from..to] {
            samples.count(i, sign, &mut self.totals[0]);
            samples.count(i, -sign, &mut self.totals[1]);
            self.mass[0] += sign * samples.swing[i as usize];
            self.mass[1] -= sign * samples.swing[i as usize];
        }
        let table = if self.uses_own {
            &self.own
        } else {
            &self.shared
        };
        let flat = self.histogram.as_flattened_mut();
        for &i in &list[from..to] {
            let offsets = &table.offsets[i as usize * samples.p..][..samples.p];
            if samples.is_single {
                let amount = T::narrow(sign * samples.swing[i as usize]);
                for &offset in offsets {
                    let pair = &mut flat[offset as usize..][..2];
                    pair[0] = pair[0].plus(amount);
                    pair[1] = pair[1].minus(amount);
                }
            } else {
                for &offset in offsets {
                    move_rows(samples, i, sign, &mut flat[offset as usize..], N);
                }
            }
        }
        self.k = place.k;
    }

    /// The vector pass: attained gain and reach of both sides.
    fn sweep(&mut self) -> ([i64; 2], [i64; 2]) {
        let columns = self.totals[0].len();
        let b = self.table().n_buckets;
        let totals: Vec<[T; N]> = (0..columns)
            .map(|c| std::array::from_fn(|lane| T::narrow(self.totals[lane % 2][c])))
            .collect();
        let (mut best, mut reach) = ([i64::MIN; 2], [i64::MIN; 2]);
        self.best.clear();
        let per_group = b * self.shape.rows;
        let checkpoints = b / STRIDE * columns;
        for g in 0..self.n_groups {
            let mut group = Group {
                histogram: &self.histogram[g * per_group..][..per_group],
                open: &self.open[g * b..][..b],
                totals: &totals,
                caps: &mut self.caps[g * b..][..b],
                runs: &mut self.runs[g * checkpoints..][..checkpoints],
                rows: self.shape.rows,
                best: [T::default(); N],
                reach: [T::default(); N],
            };
            self.arch.dispatch(&mut group);
            for lane in 0..N {
                best[lane % 2] = best[lane % 2].max(group.best[lane].widen());
                reach[lane % 2] = reach[lane % 2].max(group.reach[lane].widen());
            }
            self.best.push(group.best);
        }
        (best, reach)
    }

    /// Buckets of a side whose cap is above `best`, the most promising first.
    fn collect(&mut self, side: usize, best: i64, p: usize) {
        let n_buckets = self.table().n_buckets;
        let least = T::narrow(best);
        self.candidates.clear();
        for (index, cap) in self.caps.iter().enumerate() {
            if cap.iter().fold(false, |any, &c| any | (c > least)) {
                for lane in (side..N).step_by(2).filter(|&lane| cap[lane] > least) {
                    let feature = (index / n_buckets * N + lane) / 2;
                    if feature < p {
                        let bucket = index % n_buckets;
                        self.candidates.push(Candidate {
                            cap: cap[lane].widen(),
                            feature,
                            bucket,
                        });
                    }
                }
            }
        }
        self.candidates.sort_unstable_by(|a, b| b.cmp(a));
    }

    /// Largest gain of a cut inside a bucket, on one side.
    fn walk(
        &mut self,
        samples: &Samples,
        place: &Place<'_>,
        side: usize,
        candidate: Candidate,
    ) -> i64 {
        let Candidate {
            feature, bucket, ..
        } = candidate;
        self.running_sums(feature, side, bucket);
        let ranks = samples.ranks_of(feature);
        let members = self
            .table()
            .members(samples, place.view.list(feature), feature, bucket);
        let mut left = std::mem::take(&mut self.left);
        let (mut best, mut last) = (i64::MIN, None);
        for &i in members.iter().filter(|&&i| place.is_on(side, i)) {
            let rank = ranks[i as usize];
            if last.is_some_and(|before| before != rank) {
                best = best.max(super::scan::split_gain(&left, &self.totals[side]));
            }
            samples.count(i, 1, &mut left);
            last = Some(rank);
        }
        self.left = left;
        best
    }

    /// Gains left of a bucket's start, from the last checkpoint.
    fn running_sums(&mut self, feature: usize, side: usize, bucket: usize) {
        let columns = self.totals[0].len();
        let b = self.table().n_buckets;
        let (group, lane) = ((2 * feature + side) / N, (2 * feature + side) % N);
        let checkpoint = (group * (b / STRIDE) + bucket / STRIDE) * columns;
        self.left.clear();
        self.left.extend(
            self.runs[checkpoint..checkpoint + columns]
                .iter()
                .map(|row| row[lane].widen()),
        );
        for between in bucket / STRIDE * STRIDE..bucket {
            let rows = &self.histogram[(group * b + between) * self.shape.rows..][..columns];
            for (sum, row) in self.left.iter_mut().zip(rows) {
                *sum += row[lane].widen();
            }
        }
    }
}

/// Move all gains and the swing of a sample between the sides of one feature.
fn move_rows<T: Lane>(samples: &Samples, i: u32, sign: i64, flat: &mut [T], lanes: usize) {
    let gains = &samples.gains[i as usize * samples.n_columns..][..samples.n_columns];
    for (row, gain) in gains.iter().chain([&samples.swing[i as usize]]).enumerate() {
        let pair = &mut flat[row * lanes..][..2];
        pair[0] = pair[0].plus(T::narrow(sign * gain));
        pair[1] = pair[1].minus(T::narrow(sign * gain));
    }
}

impl<T: Lane, const N: usize> Stumps for Buckets<T, N> {
    fn prepare(&mut self, samples: &Samples, view: &View) {
        self.shared
            .lay(samples, view, self.shape, 8, most_buckets(view.len));
    }

    fn load(&mut self, samples: &Samples, view: &View) {
        self.uses_own = view.len * 3 < self.shared.len || self.shared.len == 0;
        if self.uses_own {
            self.own
                .lay(samples, view, self.shape, 6, most_buckets(view.len));
        }
        let b = self.table().n_buckets;
        self.histogram.clear();
        self.histogram
            .resize(self.n_groups * b * self.shape.rows, [T::default(); N]);
        self.caps.resize(self.n_groups * b, [T::default(); N]);
        self.runs.resize(
            self.n_groups * b / STRIDE * samples.n_columns,
            [T::default(); N],
        );
        self.open.clear();
        self.open.resize(self.n_groups * b, [T::default(); N]);
        for f in 0..samples.p {
            let (group, lane) = (2 * f / N, 2 * f % N);
            for bucket in 0..b {
                if self.table().is_open[f * b + bucket] {
                    self.open[group * b + bucket][lane] = T::MAX;
                    self.open[group * b + bucket][lane + 1] = T::MAX;
                }
            }
        }
        // All samples enter on the left from nothing, then the sides are exchanged: everything is right of the cut.
        self.k = 0;
        self.shift(
            samples,
            &Place {
                view,
                f: 0,
                k: view.len,
                positions: &[],
            },
        );
        for row in self.histogram.as_flattened_mut().chunks_exact_mut(2) {
            (row[0], row[1]) = (T::default(), row[0]);
        }
        self.start.clone_from(&self.histogram);
        self.totals[0].fill(0);
        self.totals[1].clone_from(&view.totals);
        self.mass = [0, view.mass];
        self.k = 0;
    }

    fn rewind(&mut self) {
        if self.k != 0 {
            self.histogram.clone_from(&self.start);
            self.rewind_totals();
        }
    }

    fn both(&mut self, samples: &Samples, place: &Place<'_>, close: i64) -> [Stump; 2] {
        self.shift(samples, place);
        let (mut best, mut reach) = self.sweep();
        let leaf = [0, 1].map(|side| self.totals[side].iter().copied().max().unwrap_or(0));
        let mass = self.mass;
        let cost = |side: usize, gain: i64| mass[side] - leaf[side].max(gain - samples.penalty);
        let first = usize::from(reach[1] - best[1] > reach[0] - best[0]);
        for side in [first, 1 - first] {
            if reach[side] <= best[side] {
                continue;
            }
            self.collect(side, best[side], samples.p);
            for index in 0..=self.candidates.len() {
                let next = self.candidates.get(index).copied();
                reach[side] = next.map_or(best[side], |candidate| best[side].max(candidate.cap));
                let is_closed = cost(0, reach[0]) + cost(1, reach[1]) >= close;
                let Some(candidate) =
                    next.filter(|candidate| candidate.cap > best[side] && !is_closed)
                else {
                    break;
                };
                best[side] = best[side].max(self.walk(samples, place, side, candidate));
            }
        }
        [0, 1].map(|side| Stump {
            lower: cost(side, reach[side]),
            value: cost(side, best[side]),
        })
    }

    fn attained(&self, scores: &mut Vec<i64>) {
        scores.clear();
        scores.extend(
            self.best
                .as_flattened()
                .iter()
                .skip(1)
                .step_by(2)
                .map(|&gain| gain.widen()),
        );
    }

    fn bytes(&self) -> usize {
        let rows = self.histogram.len()
            + self.start.len()
            + self.open.len()
            + self.caps.len()
            + self.runs.len();
        let tables = self.shared.offsets.len() + self.own.offsets.len();
        rows * std::mem::size_of::<[T; N]>() + tables * 4
    }
}

impl<T: Lane, const N: usize> Buckets<T, N> {
    /// The totals with everything right of the cut.
    fn rewind_totals(&mut self) {
        for c in 0..self.totals[0].len() {
            self.totals[1][c] += self.totals[0][c];
            self.totals[0][c] = 0;
        }
        self.mass = [0, self.mass[0] + self.mass[1]];
        self.k = 0;
    }
}

/// Most buckets of a feature: few where a vector pass is the price, more where a walk inside would be.
fn most_buckets(len: usize) -> usize {
    128.max(2 * len.isqrt())
}

//! Best cuts by buckets: squared errors, leaves of any size, weights above 0.
//!
//! The samples of a node are parted into buckets along each feature, samples of one rank never into two. A cut of
//! another feature that moves by one sample changes one bucket of each feature, and a scan reads buckets, not samples.
//! What a cut explains, `S_left^2 / W_left + S_right^2 / W_right`, is convex in the weight W and the weighted target S
//! left of it. A cut inside a bucket has a part of the bucket's samples left of it, with targets between the bucket's
//! least and greatest: its (W, S) lies in the parallelogram with the corners nothing, all, as much as can be of the
//! greatest target only, and as much as can be of the least only. So it explains at most what the best corner does, and
//! only buckets that may hold a better cut are looked into.

use crate::regression::clusters::Sums;
use crate::regression::samples::Samples;
use crate::regression::scan::BestCut;
use crate::regression::sides::Sides;
use crate::regression::view::View;

/// Samples of a bucket, about.
const BUCKET: usize = 8;
/// Most buckets of a feature.
const MOST_BUCKETS: usize = 2048;

/// Weight and weighted target.
type Pile = (f64, f64);

/// Buckets of all features of a node.
#[derive(Debug, Default)]
pub(crate) struct Histograms {
    /// First bucket of each feature, and the number of all (`p + 1`).
    first: Vec<usize>,
    /// First sample of each bucket in the list of its feature.
    starts: Vec<u32>,
    /// Least and greatest target of each bucket.
    ends: Vec<Pile>,
    /// One over the difference of the two; 0 where there is none.
    slopes: Vec<f64>,
    totals: Vec<Pile>,
    left: Vec<Pile>,
    /// Bucket of each sample among those of a feature (`n * p`, by sample).
    of_sample: Vec<u16>,
    /// Buckets that may hold a better cut: side, bucket, what they explain at most, what stands left of them.
    open: Vec<(usize, usize, Explained, Pile)>,
}

/// What a cut explains, as a fraction: divisions would take most of the time.
#[derive(Debug, Clone, Copy)]
struct Explained {
    above: f64,
    below: f64,
}

impl Explained {
    #[inline(always)]
    fn of(left: Pile, total: Pile) -> Self {
        let right = (total.0 - left.0, total.1 - left.1);
        if left.0 > 0.0 && right.0 > 0.0 {
            let above = left.1 * left.1 * right.0 + right.1 * right.1 * left.0;
            Self { above, below: left.0 * right.0 }
        } else {
            Self { above: total.1 * total.1, below: if total.0 > 0.0 { total.0 } else { 1.0 } }
        }
    }

    #[inline(always)]
    fn exceeds(&self, other: &Self) -> bool {
        self.above * other.below > other.above * self.below
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if other.exceeds(&self) { other } else { self }
    }

    #[inline(always)]
    fn value(&self) -> f64 {
        self.above / self.below
    }

    #[inline(always)]
    fn whole(value: f64) -> Self {
        Self { above: value, below: 1.0 }
    }
}

impl Histograms {
    /// Whether buckets serve these samples.
    pub(crate) fn serve(samples: &Samples) -> bool {
        !samples.is_absolute && samples.leaf_size == 1 && samples.sums.iter().all(|own| own.weight > 0.0)
    }

    /// Part the samples of a node, all on the right.
    pub(crate) fn load(&mut self, samples: &Samples, view: &View) {
        let (n, p) = (samples.n, samples.p);
        self.of_sample.resize(n * p, 0);
        self.first.clear();
        self.starts.clear();
        self.ends.clear();
        self.totals.clear();
        let size = view.len.div_ceil(MOST_BUCKETS).max(BUCKET);
        for g in 0..p {
            let ranks = samples.ranks_of(g);
            self.first.push(self.starts.len());
            let mut before = u32::MAX;
            for (k, &i) in view.list(g).iter().enumerate() {
                let (i, start) = (i as usize, self.starts.last().map_or(0, |&start| start as usize));
                if k == 0 || (k - start >= size && ranks[i] != before) {
                    self.starts.push(k as u32);
                    self.ends.push((f64::INFINITY, f64::NEG_INFINITY));
                    self.totals.push((0.0, 0.0));
                }
                before = ranks[i];
                let bucket = self.starts.len() - 1;
                let (own, target) = (&samples.sums[i], samples.targets[i]);
                self.ends[bucket] = (self.ends[bucket].0.min(target), self.ends[bucket].1.max(target));
                self.totals[bucket] = (self.totals[bucket].0 + own.weight, self.totals[bucket].1 + own.target);
                self.of_sample[i * p + g] = (bucket - self.first[g]) as u16;
            }
        }
        self.first.push(self.starts.len());
        self.slopes.clear();
        self.slopes.extend(self.ends.iter().map(|(low, high)| if high > low { 1.0 / (high - low) } else { 0.0 }));
        self.rewind();
    }

    /// All samples on the right again.
    pub(crate) fn rewind(&mut self) {
        self.left.clear();
        self.left.resize(self.starts.len(), (0.0, 0.0));
    }

    /// A sample changes sides, 0 is to the left.
    #[inline]
    pub(crate) fn pass(&mut self, i: u32, own: &Sums, to: usize) {
        let sign = if to == 0 { 1.0 } else { -1.0 };
        let (weight, target) = (sign * own.weight, sign * own.target);
        let p = self.first.len() - 1;
        for (&bucket, &first) in self.of_sample[i as usize * p..][..p].iter().zip(&self.first) {
            let pile = &mut self.left[first + bucket as usize];
            *pile = (pile.0 + weight, pile.1 + target);
        }
    }

    /// The best cuts of feature `g` on both sides, as far as they cost less than `beat`.
    ///
    /// A side on which none does may get a bound in place of the least error, and another cut than the best.
    pub(crate) fn scan(
        &mut self,
        samples: &Samples,
        view: &View,
        g: usize,
        sides: &Sides,
        beat: [f64; 2],
    ) -> [BestCut; 2] {
        let sums = sides.sums;
        let totals = sums.map(|own| (own.weight, own.target));
        let none = totals.map(|total| Explained::of((0.0, 0.0), total));
        // What a cut must explain to be of use, the best cut and the largest rank left of it, a bound of the others.
        let mut least = [0, 1].map(|m| none[m].most(Explained::whole((sums[m].square - beat[m]).max(0.0))));
        let mut best = [(Explained::whole(-1.0), 0u32); 2];
        let mut most = none;
        self.open.clear();
        let mut left = [(0.0, 0.0); 2];
        for bucket in self.first[g]..self.first[g + 1] {
            let ((low, high), slope, own) = (self.ends[bucket], self.slopes[bucket], self.left[bucket]);
            let piles = [own, (self.totals[bucket].0 - own.0, self.totals[bucket].1 - own.1)];
            for m in [0, 1] {
                let (pile, start) = (piles[m], left[m]);
                if pile.0 <= 0.0 {
                    continue;
                }
                if slope > 0.0 {
                    let greatest = ((pile.1 - low * pile.0) * slope).clamp(0.0, pile.0);
                    let rest = pile.0 - greatest;
                    let first = Explained::of((start.0 + greatest, start.1 + high * greatest), totals[m]);
                    let top = first.most(Explained::of((start.0 + rest, start.1 + low * rest), totals[m]));
                    if top.exceeds(&least[m]) {
                        self.open.push((m, bucket, top, start));
                    } else {
                        most[m] = most[m].most(top);
                    }
                }
                left[m] = (start.0 + pile.0, start.1 + pile.1);
                if left[m].0 < totals[m].0 {
                    let found = Explained::of(left[m], totals[m]);
                    if found.exceeds(&best[m].0) {
                        best[m] = (found, self.last_rank(samples, view, g, bucket));
                        least[m] = least[m].most(found);
                    }
                }
            }
        }
        self.look_inside(samples, view, g, sides, totals, least, (&mut best, &mut most));
        std::array::from_fn(|m| {
            let error = |explained: f64| (sums[m].square - explained).max(0.0);
            let found = best[m].0.value();
            let relaxed = error(most[m].most(best[m].0).value());
            BestCut { relaxed, error: if found < 0.0 { f64::INFINITY } else { error(found) }, rank: best[m].1 }
        })
    }

    fn last_rank(&self, samples: &Samples, view: &View, g: usize, bucket: usize) -> u32 {
        let end = self.end_of(view, g, bucket);
        samples.ranks_of(g)[view.list(g)[end - 1] as usize]
    }

    fn end_of(&self, view: &View, g: usize, bucket: usize) -> usize {
        if bucket + 1 < self.first[g + 1] { self.starts[bucket + 1] as usize } else { view.len }
    }

    #[allow(clippy::too_many_arguments)]
    fn look_inside(
        &self,
        samples: &Samples,
        view: &View,
        g: usize,
        sides: &Sides,
        totals: [Pile; 2],
        mut least: [Explained; 2],
        (best, most): (&mut [(Explained, u32); 2], &mut [Explained; 2]),
    ) {
        let (list, ranks) = (view.list(g), samples.ranks_of(g));
        for &(m, bucket, top, start) in &self.open {
            if !top.exceeds(&least[m]) {
                most[m] = most[m].most(top);
                continue;
            }
            let (mut left, end) = (start, self.end_of(view, g, bucket));
            for k in self.starts[bucket] as usize..end {
                let i = list[k] as usize;
                if sides.of_sample[i] as usize == m {
                    left = (left.0 + samples.sums[i].weight, left.1 + samples.sums[i].target);
                }
                // Cuts between samples of the other side alone come again: they explain the same.
                if k + 1 < end && ranks[list[k + 1] as usize] != ranks[i] && left.0 > 0.0 && left.0 < totals[m].0 {
                    let found = Explained::of(left, totals[m]);
                    if found.exceeds(&best[m].0) {
                        best[m] = (found, ranks[i]);
                        least[m] = least[m].most(found);
                    }
                }
            }
        }
    }
}

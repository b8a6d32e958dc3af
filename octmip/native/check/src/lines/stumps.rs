//! What trees of one split cost at least on some samples, counted for sets of lines.

use super::{BINS, Checker, EPS, FEW, MOST, Strip, TINY, Tally};

/// Strips narrower than this in t are not sifted any finer.
const THIN: f64 = 1.0 / 24.0;

/// The lines r = c + slope (t - middle) for t0 <= t <= t1 and low <= c <= high, over two features.
struct Band {
    chart: (usize, usize),
    t: [f64; 2],
    slope: f64,
    c: [f64; 2],
}

/// Samples that a band was cut out of: those of `open` with a last bin before `begin` go left of it.
struct Cut<'a> {
    open: &'a [u32],
    places: &'a [[usize; 2]],
    begin: usize,
    chart: (usize, usize),
    around: Option<&'a Cut<'a>>,
}

impl Cut<'_> {
    /// The samples left of the band.
    fn left(&self) -> Vec<u32> {
        let mut left = self.around.map_or_else(Vec::new, Cut::left);
        let own = self.open.iter().zip(self.places).filter(|(_, place)| place[1] < self.begin);
        left.extend(own.map(|(&i, _)| i));
        left
    }
}

/// Samples, and the fewest that each of two leaves is to hold of them.
struct Samples<'a> {
    ids: &'a [u32],
    total: Tally,
    need: i64,
}

impl Checker<'_> {
    /// Whether a leaf, or a split in these strips with so many samples on either side, costs `claim` or more for these
    /// samples, and so for all sets that contain them.
    pub(super) fn child_costs(&self, ids: &[u32], need: i64, strips: &[Strip], claim: i64) -> bool {
        let samples = Samples { ids, total: self.tally(ids), need };
        let k = self.q.n_classes;
        let mut pairs = (0..k).flat_map(|a| (a..k).map(move |b| [a, b]));
        if pairs.all(|pair| self.choosing(&samples.total, &pair) >= claim) {
            return true; // a child gives two answers at most
        }
        let is_leaf_dear = self.leaf(&samples.total) >= claim || samples.total[k] < need;
        is_leaf_dear
            && strips.iter().all(|strip| {
                let band = self.around(&samples, strip);
                self.is_closed(&samples, &band, ids, (&vec![0; k + 1], None), claim)
            })
    }

    /// The parts of strips where not all splits cost `dead` or more.
    pub(super) fn sift(&self, ids: &[u32], need: i64, strips: &[Strip], dead: i64) -> Vec<Strip> {
        let samples = Samples { ids, total: self.tally(ids), need };
        let none = vec![0; self.q.n_classes + 1];
        let mut kept = Vec::new();
        let mut waiting: Vec<Strip> = strips.iter().rev().copied().collect();
        while let Some((chart, t0, t1)) = waiting.pop() {
            let band = self.around(&samples, &(chart, t0, t1));
            let (_, alive) = self.scan(&samples, &band, ids, &none, dead);
            if !alive.contains(&true) {
                continue;
            }
            if t1 - t0 <= THIN {
                kept.push((chart, t0, t1));
                continue;
            }
            let middle = (t0 + t1) / 2.0;
            waiting.extend([(chart, middle, t1), (chart, t0, middle)]);
        }
        kept
    }

    /// The band of a strip that holds every line with samples on both sides.
    ///
    /// One with an empty side costs what a leaf costs, at least.
    fn around(&self, samples: &Samples<'_>, &(chart, t0, t1): &Strip) -> Band {
        let mut band = Band { chart, t: [t0, t1], slope: 0.0, c: [-8.0, 8.0] };
        band.slope = self.slope(chart, samples.ids);
        let (mut low, mut high) = (8.0f64, -8.0f64);
        for &i in samples.ids {
            let reach = self.reach(&band, i);
            (low, high) = (low.min(reach[0]), high.max(reach[1]));
        }
        band.c = [low, high];
        band
    }

    fn slope(&self, (_, g): (usize, usize), ids: &[u32]) -> f64 {
        let y = self.points.coordinates(g);
        let sum: f64 = ids.iter().map(|&i| y[i as usize]).sum();
        sum / ids.len().max(1) as f64
    }

    /// Between which values of c the line of a sample runs, rounding included.
    fn reach(&self, band: &Band, i: u32) -> [f64; 2] {
        let [x, y] = [band.chart.0, band.chart.1].map(|f| self.points.coordinates(f)[i as usize]);
        let middle = (band.t[0] + band.t[1]) / 2.0;
        let [a, b] = band.t.map(|t| x + t * y - band.slope * (t - middle));
        [a.min(b) - EPS, a.max(b) + EPS]
    }

    /// For each sample the first bin of c where it may go left and the last where it may go right; for each bin
    /// whether a line of it may cost less than `claim`.
    ///
    /// The bin of a number never falls as it grows, whatever the rounding: so a line of bin b has at its left only
    /// samples whose first bin is b or less, and likewise on the right. `left` are samples left of the whole band.
    fn scan(
        &self,
        samples: &Samples<'_>,
        band: &Band,
        open: &[u32],
        left: &Tally,
        claim: i64,
    ) -> (Vec<[usize; 2]>, Vec<bool>) {
        let (lanes, n_bins) = (self.q.n_classes + 1, (2 * open.len()).clamp(8, BINS));
        let scale = n_bins as f64 / (band.c[1] - band.c[0]).max(EPS);
        let bin = |c: f64| (((c - band.c[0]) * scale) as usize).min(n_bins - 1);
        let (mut first, mut last) = (vec![0; n_bins * lanes], vec![0; n_bins * lanes]);
        let mut may_right: Tally = samples.total.iter().zip(left).map(|(a, b)| a - b).collect();
        let mut may_left = left.clone();
        let places: Vec<[usize; 2]> = open.iter().map(|&i| self.reach(band, i).map(bin)).collect();
        for (&i, place) in open.iter().zip(&places) {
            self.join(&mut first[place[0] * lanes..], i);
            self.join(&mut last[place[1] * lanes..], i);
        }
        let (mut alive, mut is_same) = (Vec::with_capacity(n_bins), false);
        let owed = claim - self.price(band.chart);
        let mut scratch = Vec::with_capacity(2 * lanes);
        for (more, less) in first.chunks_exact(lanes).zip(last.chunks_exact(lanes)) {
            may_left.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            alive.push(match alive.last() {
                Some(&alive) if is_same && more[lanes - 1] == 0 => alive,
                _ => self.may_be_below(samples, &may_left, &may_right, owed, &mut scratch),
            });
            may_right.iter_mut().zip(less).for_each(|(sum, less)| *sum -= less);
            is_same = less[lanes - 1] == 0;
        }
        (places, alive)
    }

    /// Whether two different answers may cost samples less than `owed`, by those that may go left and those that may go
    /// right: one that may do both has the cheaper answer.
    fn may_be_below(
        &self,
        samples: &Samples<'_>,
        may_left: &[i64],
        may_right: &[i64],
        owed: i64,
        scratch: &mut Vec<i64>,
    ) -> bool {
        let (q, k, total) = (self.q, self.q.n_classes, &samples.total);
        if may_left[k] < samples.need || may_right[k] < samples.need {
            return false;
        }
        let sure = |may: &[i64], answer| -> i64 { (0..k).map(|c| (total[c] - may[c]) * q.cost(c, answer)).sum() };
        scratch.clear();
        scratch.extend((0..k).map(|answer| sure(may_left, answer)));
        scratch.extend((0..k).map(|c| may_left[c] + may_right[c] - total[c]));
        let (right, both) = scratch.split_at(k);
        (0..k).any(|a| {
            let left = sure(may_right, a);
            (0..k).any(|b| {
                let spare = |cheaper: &[i64]| cheaper.iter().zip(both).map(|(cost, n)| cost * n).sum::<i64>();
                let known = left + right[b];
                a != b && known < owed && known + spare(&self.cheaper[(a * k + b) * k..][..k]) < owed
            })
        })
    }

    /// Whether every split by a line of the band costs `claim` or more; only the lines of `open` samples run in it.
    fn is_closed(
        &self,
        samples: &Samples<'_>,
        band: &Band,
        open: &[u32],
        (left, around): (&Tally, Option<&Cut<'_>>),
        claim: i64,
    ) -> bool {
        let (places, alive) = self.scan(samples, band, open, left, claim);
        let (is_thin, width) = (band.t[1] - band.t[0] <= TINY, band.c[1] - band.c[0]);
        let (n_bins, mut begin) = (alive.len(), 0);
        while begin < n_bins {
            let mut end = begin + 1;
            if !alive[begin] {
                begin = end;
                continue;
            }
            while !is_thin && end < n_bins && alive[end] {
                end += 1;
            }
            let (mut inside, mut below) = (Vec::new(), left.clone());
            for (&i, place) in open.iter().zip(&places) {
                if place[1] < begin {
                    self.join(&mut below, i);
                } else if place[0] < end {
                    inside.push(i);
                }
            }
            let is_end = is_thin && width <= TINY;
            let edge = |bin: usize| band.c[0] + bin as f64 * (width.max(EPS) / n_bins as f64);
            let part = [edge(begin) - EPS, edge(end) + EPS];
            let cut = Cut { open, places: &places, begin, chart: band.chart, around };
            let is_parted = self.is_parted(samples, band, &inside, (&below, &cut), claim, is_end);
            let is_half_closed = |half: &Band| self.is_closed(samples, half, &inside, (&below, Some(&cut)), claim);
            if !is_parted && (is_end || !self.halves(band, part, &inside).iter().all(is_half_closed)) {
                return false;
            }
            begin = end;
        }
        true
    }

    /// Bands that together hold the lines between two values of c: halves in t, or one as it is where that is thin.
    fn halves(&self, band: &Band, part: [f64; 2], inside: &[u32]) -> Vec<Band> {
        let [t0, t1] = band.t;
        if t1 - t0 <= TINY {
            return vec![Band { c: part, ..*band }];
        }
        let (middle, slope) = ((t0 + t1) / 2.0, self.slope(band.chart, inside));
        let half = |t: [f64; 2]| {
            let own = (t[0] + t[1]) / 2.0;
            let moved = t.map(|t| band.slope * (t - middle) - slope * (t - own));
            let c = [part[0] + moved[0].min(moved[1]) - EPS, part[1] + moved[0].max(moved[1]) + EPS];
            Band { chart: band.chart, t, slope, c }
        };
        vec![half([t0, middle]), half([middle, t1])]
    }

    /// Whether every way of parting the different points in a band costs `claim` or more; false if they are not few.
    ///
    /// At the end of splitting, ways that no line goes with the samples below and above on their sides do not count.
    fn is_parted(
        &self,
        samples: &Samples<'_>,
        band: &Band,
        inside: &[u32],
        (below, cut): (&Tally, &Cut<'_>),
        claim: i64,
        is_end: bool,
    ) -> bool {
        let plane = self.points.plane(band.chart);
        let points = if is_end { plane.end_points(inside, MOST) } else { plane.few_points(inside, FEW) };
        let Some(points) = points else {
            return false;
        };
        let places = plane.places(&points, inside);
        plane.ways(&points, band.t[0], band.t[1]).iter().all(|way| {
            let mut left = below.clone();
            let joined = || inside.iter().zip(&places).filter(|(_, place)| way[**place]).map(|(&i, _)| i);
            joined().for_each(|i| self.join(&mut left, i));
            let right: Tally = samples.total.iter().zip(&left).map(|(a, b)| a - b).collect();
            let k = self.q.n_classes;
            let is_small = left[k].min(right[k]) < samples.need;
            let costs = |left: &Tally, right: &Tally| self.leaf(left) + self.leaf(right) + self.price(band.chart);
            is_small || costs(&left, &right) >= claim || (is_end && !self.is_line_between(samples, cut, joined()))
        })
    }

    /// Whether a line has those below a band and some inside it on one side, all other samples on the other.
    fn is_line_between(&self, samples: &Samples<'_>, cut: &Cut<'_>, joined: impl Iterator<Item = u32>) -> bool {
        let mut left = cut.left();
        left.extend(joined);
        left.sort_unstable();
        let right: Vec<u32> = samples.ids.iter().copied().filter(|i| left.binary_search(i).is_err()).collect();
        self.points.plane(cut.chart).can_part(&left, &right)
    }
}

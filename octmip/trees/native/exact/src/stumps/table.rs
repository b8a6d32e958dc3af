//! Buckets: runs of neighbouring values of a feature, so that a set's stumps are seen at the edges of runs first.

use crate::samples::Samples;
use crate::stumps::cells::Cells;
use crate::view::View;

/// Bucket of every sample in every feature, as a cell of a histogram.
///
/// The histogram is laid out `[group][bucket][row][slot]`; a slot holds the two sides of a feature.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// Cell `(bucket * rows + row) * slots + s` of sample `i` in slot `s` of group `g`, at `(g * n + i) * slots + s`.
    pub(crate) cells: Cells,
    /// Smallest rank in each bucket (`p * n_buckets`), past the largest for buckets without values.
    pub(crate) edges: Vec<u32>,
    /// Whether a bucket holds two values or more (`p * n_buckets`).
    pub(crate) is_open: Vec<bool>,
    /// Buckets of a feature.
    pub(crate) n_buckets: usize,
    /// Whether buckets hold one label each and histograms the difference of the two labels.
    pub(crate) is_difference: bool,
    /// Size of the view that it was laid out for.
    pub(crate) len: usize,
    /// Ends of each feature's buckets in its list.
    ends: Vec<Vec<u32>>,
}

/// Buckets of one label each are used where so many samples share one on average: the pass over them is then no longer
/// than it would be with buckets of mixed labels, and nothing is walked.
const PER_PURE_BUCKET: usize = 6;

/// The same where a bucket holds only a difference: its pass is a quarter as long. Up to `MANY` it is always worth it.
const PER_DIFFERENCE: usize = 3;
const MANY: usize = 512;

/// A walk over so few samples needs no shorter buckets.
const SHORT: usize = 8;

/// Shape of a histogram.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape {
    /// Slots of a group.
    pub(crate) slots: usize,
    /// Rows of a bucket of mixed labels.
    pub(crate) rows: usize,
    /// Whether a bucket of one label can do with one row, the difference of the two labels that there are.
    pub(crate) has_differences: bool,
}

impl Table {
    /// Lay out buckets for a view, never splitting equal values; at most `most` of them where labels mix.
    ///
    /// Inside a bucket a gain is uncertain by the bucket's cost range outside its largest label (or beside one
    /// direction) at most. So buckets hold one label each where that makes few of them: then nothing is ever uncertain,
    /// however rare a label is. Else a bucket ends where it would pass a quota of that range, or would be long to walk.
    pub(crate) fn lay(&mut self, samples: &Samples, view: &View, shape: Shape, most: usize) {
        let p = samples.p;
        self.len = view.len;
        let mut ends = std::mem::take(&mut self.ends);
        ends.resize_with(p, Vec::new);
        let most_pure = most.max(view.len / PER_PURE_BUCKET);
        let most_differences = most_pure.max(view.len / PER_DIFFERENCE).max(MANY);
        self.is_difference =
            shape.has_differences && mark_all(samples, view, (0, view.len), most_differences, &mut ends);
        if !self.is_difference && !mark_all(samples, view, (0, view.len), most_pure, &mut ends) {
            let minor = Uncertainty::of(samples, view.ids(samples)).minor();
            let (mut quota, mut longest) = (minor / most as i64, (view.len / most).max(SHORT));
            while !mark_all(samples, view, (quota, longest), most, &mut ends) {
                quota += quota / 2 + 1;
                longest += longest / 2;
            }
        }
        let longest = ends.iter().map(Vec::len).max().unwrap_or(1);
        self.n_buckets = longest.next_multiple_of(8);
        let n_slots = samples.p.div_ceil(shape.slots) * shape.slots;
        self.cells.make_room(n_slots * samples.n, self.n_buckets * self.rows(shape) * shape.slots);
        self.edges.clear();
        self.edges.resize(samples.p * self.n_buckets, u32::MAX);
        self.is_open.clear();
        self.is_open.resize(samples.p * self.n_buckets, false);
        for (f, ends) in ends.iter().enumerate() {
            view.with_list(f, |list| self.lay_feature(samples, list, f, shape, ends));
        }
        self.ends = ends;
    }

    /// Rows of a bucket.
    pub(crate) fn rows(&self, shape: Shape) -> usize {
        if self.is_difference { 1 } else { shape.rows }
    }

    fn lay_feature(&mut self, samples: &Samples, list: &[u32], f: usize, shape: Shape, ends: &[u32]) {
        let ranks = samples.ranks_of(f);
        let rows = self.rows(shape);
        let first = f / shape.slots * samples.n * shape.slots + f % shape.slots;
        let mut start = 0;
        for (bucket, &end) in ends.iter().enumerate() {
            let members = &list[start..end as usize];
            let rank = ranks[members[0] as usize];
            self.edges[f * self.n_buckets + bucket] = if bucket == 0 { 0 } else { rank };
            self.is_open[f * self.n_buckets + bucket] = ranks[members[members.len() - 1] as usize] != rank;
            let is_difference = self.is_difference;
            self.cells.set(members.iter().map(|&i| {
                let row = if is_difference { 0 } else { samples.profile[i as usize] as usize };
                (first + i as usize * shape.slots, (bucket * rows + row) * shape.slots + f % shape.slots)
            }));
            start = end as usize;
        }
    }

    /// The samples of a bucket among a list in the order of feature `f`.
    pub(crate) fn members<'a>(&self, samples: &Samples, list: &'a [u32], f: usize, bucket: usize) -> &'a [u32] {
        let ranks = samples.ranks_of(f);
        let edges = &self.edges[f * self.n_buckets..(f + 1) * self.n_buckets];
        let from = list.partition_point(|&i| ranks[i as usize] < edges[bucket]);
        let rest = &list[from..];
        let to = match edges.get(bucket + 1) {
            Some(&edge) => rest.iter().position(|&i| ranks[i as usize] >= edge),
            None => None,
        };
        &rest[..to.unwrap_or(rest.len())]
    }
}

/// Remaining uncertainty inside a bucket: its cost range outside its largest label, or beside its best direction.
struct Uncertainty<'a> {
    samples: &'a Samples,
    /// Cost range of each label, or twice the span that is left beside each direction.
    parts: Vec<i64>,
    total_range: i64,
    top: i64,
}

impl<'a> Uncertainty<'a> {
    fn none(samples: &'a Samples) -> Self {
        let n_parts = if samples.is_single { samples.n_labels } else { samples.spans.len() / samples.n_profiles() };
        Self { samples, parts: vec![0; n_parts], total_range: 0, top: 0 }
    }

    fn of(samples: &'a Samples, ids: impl Iterator<Item = u32>) -> Self {
        let mut uncertainty = Self::none(samples);
        ids.for_each(|i| uncertainty.join(i as usize));
        uncertainty
    }

    #[inline(always)]
    fn join(&mut self, i: usize) {
        let (profile, multiplicity) = (self.samples.profile[i] as usize, self.samples.multiplicity[i]);
        if self.samples.is_single {
            self.total_range += multiplicity;
            self.parts[profile] += multiplicity;
            self.top = self.top.max(self.parts[profile]);
        } else {
            for (part, spans) in self.parts.iter_mut().zip(self.samples.spans.chunks_exact(self.samples.n_profiles())) {
                *part += multiplicity * spans[profile];
            }
        }
    }

    #[inline(always)]
    fn minor(&self) -> i64 {
        if self.samples.is_single {
            self.total_range - self.top
        } else {
            self.parts.iter().copied().min().unwrap_or(0) / 2
        }
    }

    fn clear(&mut self) {
        self.parts.fill(0);
        (self.total_range, self.top) = (0, 0);
    }
}

/// Mark the ends of buckets in a list: as long as the cost range outside the largest label keeps to the quota, and
/// mixed ones as long as few samples have to be walked; given up past `most` of them.
fn mark_ends(
    samples: &Samples,
    list: &[u32],
    f: usize,
    (quota, longest, most): (i64, usize, usize),
    ends: &mut Vec<u32>,
) {
    let ranks = samples.ranks_of(f);
    let mut uncertainty = Uncertainty::none(samples);
    let mut first = 0;
    ends.clear();
    let mut start = 0;
    while start < list.len() && ends.len() <= most {
        let rank = ranks[list[start] as usize];
        let mut end = start;
        loop {
            while end < list.len() && ranks[list[end] as usize] == rank {
                uncertainty.join(list[end] as usize);
                end += 1;
            }
            let minor = uncertainty.minor();
            let is_full = minor > quota || (minor > 0 && end - first > longest);
            if !is_full || first == start {
                break;
            }
            // these values begin a bucket of their own: count them again for it
            ends.push(start as u32);
            uncertainty.clear();
            (first, end) = (start, start);
        }
        start = end;
    }
    ends.push(list.len() as u32);
}

/// Mark the ends of every feature's buckets; returns whether no feature has more than `most`.
fn mark_all(
    samples: &Samples,
    view: &View,
    (quota, longest): (i64, usize),
    most: usize,
    ends: &mut [Vec<u32>],
) -> bool {
    ends.iter_mut().enumerate().all(|(f, ends)| {
        view.with_list(f, |list| mark_ends(samples, list, f, (quota, longest, most), ends));
        ends.len() <= most
    })
}

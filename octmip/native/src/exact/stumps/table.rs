//! Buckets: runs of neighbouring values of a feature, so that a set's stumps are seen at the edges of runs first.

use crate::exact::samples::Samples;
use crate::exact::view::View;

/// Which bucket of every feature a sample lies in, as an offset into a histogram.
///
/// The histogram is laid out `[group][bucket][row][lane]`; lane `2 f + side` of all groups holds feature `f`.
#[derive(Debug, Default)]
pub struct Table {
    /// Offset of sample `i` in feature `f`, left side, its own row included: `offsets[i * p + f]`.
    pub offsets: Vec<u32>,
    /// Smallest rank in each bucket (`p * n_buckets`), past the largest for buckets without values.
    pub edges: Vec<u32>,
    /// Whether a bucket holds two values or more (`p * n_buckets`).
    pub is_open: Vec<bool>,
    /// Buckets of a feature.
    pub n_buckets: usize,
    /// Size of the view that it was laid out for.
    pub len: usize,
}

/// Shape of a histogram.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Numbers in a vector.
    pub lanes: usize,
    /// Rows of a bucket.
    pub rows: usize,
}

impl Table {
    /// Lay out buckets of about `per_bucket` samples for a view, at most `most` of them, never splitting equal values.
    pub fn lay(
        &mut self,
        samples: &Samples,
        view: &View,
        shape: Shape,
        per_bucket: usize,
        most: usize,
    ) {
        let p = samples.p;
        self.n_buckets = (view.len.div_ceil(per_bucket))
            .clamp(1, most)
            .next_multiple_of(8);
        self.len = view.len;
        self.offsets.resize(samples.n * p, 0);
        self.edges.clear();
        self.edges.resize(p * self.n_buckets, u32::MAX);
        self.is_open.clear();
        self.is_open.resize(p * self.n_buckets, false);
        let wanted = view.len.div_ceil(self.n_buckets);
        for f in 0..p {
            self.lay_feature(samples, view.list(f), f, shape, wanted);
        }
    }

    fn lay_feature(
        &mut self,
        samples: &Samples,
        list: &[u32],
        f: usize,
        shape: Shape,
        wanted: usize,
    ) {
        let ranks = samples.ranks_of(f);
        let (group, lane) = (2 * f / shape.lanes, 2 * f % shape.lanes);
        let stride = shape.rows * shape.lanes;
        let mut offset = group * self.n_buckets * stride + lane;
        let (mut bucket, mut held) = (f * self.n_buckets, 0);
        let mut last = ranks[list[0] as usize];
        self.edges[bucket] = 0;
        for &i in list {
            let rank = ranks[i as usize];
            if rank != last {
                if held >= wanted {
                    (bucket, held) = (bucket + 1, 0);
                    offset += stride;
                    self.edges[bucket] = rank;
                } else {
                    self.is_open[bucket] = true;
                }
                last = rank;
            }
            held += 1;
            let row = if samples.is_single {
                samples.column[i as usize] as usize
            } else {
                0
            };
            self.offsets[i as usize * samples.p + f] = (offset + row * shape.lanes) as u32;
        }
    }

    /// The samples of a bucket among a list in the order of feature `f`.
    pub fn members<'a>(
        &self,
        samples: &Samples,
        list: &'a [u32],
        f: usize,
        bucket: usize,
    ) -> &'a [u32] {
        let ranks = samples.ranks_of(f);
        let edges = &self.edges[f * self.n_buckets..(f + 1) * self.n_buckets];
        let from = list.partition_point(|&i| ranks[i as usize] < edges[bucket]);
        let to = match edges.get(bucket + 1) {
            Some(&edge) => from + list[from..].partition_point(|&i| ranks[i as usize] < edge),
            None => list.len(),
        };
        &list[from..to]
    }
}

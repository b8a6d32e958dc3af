//! Buckets: runs of neighbouring values of a feature, so that a set's stumps are seen at the edges of runs first.

use crate::exact::samples::Samples;
use crate::exact::view::View;

/// Which bucket of every feature a sample lies in, as an offset into a histogram.
///
/// The histogram is laid out `[group][bucket][row][slot]`; a slot holds the two sides of a feature. The features with
/// the best stumps share the first groups, so that later groups can often be passed over.
#[derive(Debug, Default)]
pub struct Table {
    /// Offset of sample `i` in slot `s` of group `g`, its own row included: `offsets[(g * n + i) * slots + s]`.
    pub offsets: Vec<u32>,
    /// Smallest rank in each bucket (`p * n_buckets`), past the largest for buckets without values.
    pub edges: Vec<u32>,
    /// Whether a bucket holds two values or more (`p * n_buckets`).
    pub is_open: Vec<bool>,
    /// Buckets of a feature.
    pub n_buckets: usize,
    /// Size of the view that it was laid out for.
    pub len: usize,
    /// Feature of each slot (`p`).
    pub feature_of_slot: Vec<usize>,
    /// Slot of each feature (`p`).
    pub slot_of_feature: Vec<usize>,
}

/// Shape of a histogram.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Slots of a group.
    pub slots: usize,
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
        self.offsets
            .resize(p.div_ceil(shape.slots) * samples.n * shape.slots, 0);
        self.edges.clear();
        self.edges.resize(p * self.n_buckets, u32::MAX);
        self.is_open.clear();
        self.is_open.resize(p * self.n_buckets, false);
        if self.feature_of_slot.len() != p {
            self.feature_of_slot = (0..p).collect();
            self.slot_of_feature = (0..p).collect();
        }
        let wanted = view.len.div_ceil(self.n_buckets);
        for f in 0..p {
            self.lay_feature(samples, view.list(f), f, shape, wanted);
        }
    }

    /// Put the features in this order; needs a new layout.
    pub fn reorder(&mut self, order: Vec<usize>) {
        for (slot, &f) in order.iter().enumerate() {
            self.slot_of_feature[f] = slot;
        }
        self.feature_of_slot = order;
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
        let slot = self.slot_of_feature[f];
        let stride = shape.rows * shape.slots;
        let mut offset = slot % shape.slots;
        let first = slot / shape.slots * samples.n * shape.slots + slot % shape.slots;
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
            self.offsets[first + i as usize * shape.slots] = (offset + row * shape.slots) as u32;
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
        let rest = &list[from..];
        let to = match edges.get(bucket + 1) {
            Some(&edge) => rest.iter().position(|&i| ranks[i as usize] >= edge),
            None => None,
        };
        &rest[..to.unwrap_or(rest.len())]
    }
}

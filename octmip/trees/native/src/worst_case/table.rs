//! Sums over the samples at cuts `lo` to `hi` of the root: what children pay at least, by zone, from counts by rank.

use crate::worst_case::boxes::Cuts;
use crate::worst_case::instance::{HIGH, Instance, LOW, TRUE};

/// Most slices of the cuts of each feature; a power of two.
const MOST_SLICES: usize = 64;
/// Most sums of a table, where more than two slices have them.
const MOST_SUMS: usize = 2_000_000;
/// Sets of samples: by true readings left or right; while the root is off surely left only, right only, both ways.
const STILL: usize = 0;
const SURE: usize = 2;
const BAND: usize = 4;
const N_SETS: usize = 5;

/// The cuts of one feature in slices, as many for every feature.
#[derive(Debug)]
pub(crate) struct Grid {
    n_slices: usize,
    lo: u32,
    n_cuts: u32,
    /// For the lowest, true and highest rank of each sample the first end that is not below it.
    ends: [Vec<u8>; 3],
}

impl Grid {
    /// The grid of a feature, over the cuts that may have full leaves on both sides.
    pub(crate) fn new(instance: &Instance, feature: usize) -> Self {
        let own = &instance.features[feature];
        let (lo, hi) = own.window(instance.leaf_size, |_| true).unwrap_or((0, 0));
        let size = |n_slices: usize| instance.features.len() * 2 * n_slices * 3 * N_SETS * instance.n_rows;
        let mut n_slices = MOST_SLICES;
        while n_slices > 2 && size(n_slices) > MOST_SUMS {
            n_slices /= 2;
        }
        let mut grid = Self { n_slices, lo, n_cuts: hi - lo + 1, ends: Default::default() };
        let both = |k: usize| [grid.first(k), (grid.first(k + 1).max(1) - 1).max(grid.first(k))];
        let cuts: Vec<u32> = (0..n_slices).flat_map(both).collect();
        let end = |&rank: &u32| cuts.partition_point(|&cut| cut < rank) as u8;
        grid.ends = [LOW, TRUE, HIGH].map(|kind| own.ranks[kind].iter().map(end).collect());
        grid
    }

    fn first(&self, slice: usize) -> u32 {
        self.lo + (slice as u64 * u64::from(self.n_cuts) / self.n_slices as u64) as u32
    }

    /// Number of ends: the lowest and the highest cut of each slice, and one beyond.
    fn n_ends(&self) -> usize {
        2 * self.n_slices + 1
    }

    /// One more than the highest node of the binary tree over the slices.
    pub(crate) fn n_nodes(&self) -> usize {
        2 * self.n_slices
    }

    /// Whether a node has nodes below it.
    pub(crate) fn has_halves(&self, node: usize) -> bool {
        node < self.n_slices
    }

    /// The first and the last slice of a node.
    fn slices(&self, node: usize) -> (usize, usize) {
        let size = self.n_slices >> node.ilog2();
        let first = (node - (1 << node.ilog2())) * size;
        (first, first + size - 1)
    }

    /// The cuts of a node, 1 for all of them; none where it has none.
    pub(crate) fn cuts(&self, feature: usize, node: usize) -> Option<Cuts> {
        let (first, last) = self.slices(node);
        let (lo, end) = (self.first(first), self.first(last + 1));
        (lo < end).then(|| Cuts { feature, lo, hi: end - 1 })
    }
}

/// Counts for one interval of cuts of the root.
#[derive(Debug)]
pub(crate) struct Table<'a> {
    instance: &'a Instance,
    grids: &'a [Grid],
    n_ends: usize,
    /// Weight up to each end: `[feature][end][kind][set][row]`.
    sums: Vec<i64>,
    /// Weight of each set by row.
    totals: [Vec<i64>; N_SETS],
    /// Samples that may come to each side by their true readings, up to each end: `[feature][end][side]`.
    members: Vec<u32>,
    n_members: [u32; 2],
    /// Weight by row whose side is not the same at all cuts: by true readings, and while the root is off.
    pub(crate) unsure: [Vec<i64>; 2],
}

impl<'a> Table<'a> {
    /// Count.
    pub(crate) fn new(instance: &'a Instance, grids: &'a [Grid], root: Cuts) -> Self {
        let n_ends = grids.first().map_or(0, Grid::n_ends);
        let n_rows = instance.n_rows;
        let (n_features, cell) = (instance.features.len(), N_SETS * n_rows);
        let mut table = Self {
            instance,
            grids,
            n_ends,
            sums: vec![0; n_features * n_ends * 3 * cell],
            totals: std::array::from_fn(|_| vec![0; n_rows]),
            members: vec![0; n_features * n_ends * 2],
            n_members: [0; 2],
            unsure: [vec![0; n_rows], vec![0; n_rows]],
        };
        let ranks = &instance.features[root.feature].ranks;
        for (i, &rank) in ranks[TRUE].iter().enumerate() {
            let (row, weight) = (instance.rows[i] as usize, instance.weights[i]);
            let mut sets = [usize::MAX; 2];
            match root.sure_ways(instance, i, false) {
                (true, _) => sets[0] = STILL,
                (_, true) => sets[0] = STILL + 1,
                _ => table.unsure[0][row] += weight,
            }
            match root.sure_ways(instance, i, true) {
                (true, true) => sets[1] = BAND,
                (true, _) => sets[1] = SURE,
                (_, true) => sets[1] = SURE + 1,
                _ => table.unsure[1][row] += weight,
            }
            let sides = [rank <= root.hi, rank > root.lo];
            table.n_members.iter_mut().zip(sides).for_each(|(n, is_in)| *n += u32::from(is_in));
            for set in sets.into_iter().filter(|&set| set != usize::MAX) {
                table.totals[set][row] += weight;
            }
            for (f, grid) in grids.iter().enumerate() {
                for kind in [LOW, TRUE, HIGH] {
                    let end = f * n_ends + grid.ends[kind][i] as usize;
                    for set in sets.into_iter().filter(|&set| set != usize::MAX) {
                        table.sums[(end * 3 + kind) * cell + set * n_rows + row] += weight;
                    }
                    if kind == TRUE {
                        for (side, is_in) in sides.into_iter().enumerate() {
                            table.members[end * 2 + side] += u32::from(is_in);
                        }
                    }
                }
            }
        }
        for f in 0..n_features {
            accumulate(&mut table.sums[f * n_ends * 3 * cell..(f + 1) * n_ends * 3 * cell], 3 * cell);
            accumulate(&mut table.members[f * n_ends * 2..(f + 1) * n_ends * 2], 2);
        }
        table
    }

    /// Whether all leaves of some child may hold enough samples.
    pub(crate) fn has_full_leaves(&self, side: usize, split: Option<(usize, usize)>) -> bool {
        let all = self.n_members[side] as usize;
        let Some((feature, node)) = split else { return all >= self.instance.leaf_size };
        let (first, last) = self.grids[feature].slices(node);
        let at = |end: usize| self.members[(feature * self.n_ends + end) * 2 + side] as usize;
        [at(2 * last + 1), all - at(2 * first)].into_iter().all(|size| size >= self.instance.leaf_size)
    }

    /// What a child pays at least: `still`, `sure` for its own sensor true and off, then `band` by row for both.
    pub(crate) fn push(&self, side: usize, split: Option<(usize, usize)>, labels: [usize; 2], to: &mut Vec<i64>) {
        for set in [STILL + side, SURE + side] {
            for is_off in [false, true] {
                let rows = 0..self.instance.n_rows;
                to.push(rows.map(|row| self.least(set, row, split, labels, is_off)).sum());
            }
        }
        for is_off in [false, true] {
            to.extend((0..self.instance.n_rows).map(|row| self.least(BAND, row, split, labels, is_off)));
        }
    }

    /// What the samples of a set and row pay at least.
    fn least(&self, set: usize, row: usize, split: Option<(usize, usize)>, labels: [usize; 2], is_off: bool) -> i64 {
        let total = self.totals[set][row];
        let [left, right] = labels.map(|label| self.instance.cost(row, label));
        let Some((feature, node)) = split else { return left * total };
        let (first, last) = self.grids[feature].slices(node);
        let sum = |end: usize, kind: usize| {
            let cell = N_SETS * self.instance.n_rows;
            self.sums[((feature * self.n_ends + end) * 3 + kind) * cell + set * self.instance.n_rows + row]
        };
        let least = left.min(right);
        if left > right {
            least * total + (left - least) * sum(2 * first, if is_off { LOW } else { TRUE })
        } else if right > left {
            least * total + (right - least) * (total - sum(2 * last + 1, if is_off { HIGH } else { TRUE }))
        } else {
            least * total
        }
    }
}

fn accumulate<T: Copy + std::ops::AddAssign>(sums: &mut [T], size: usize) {
    for k in size..sums.len() {
        let before = sums[k - size];
        sums[k] += before;
    }
}

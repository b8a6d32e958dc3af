//! Histograms of a slope interval, from which all its regions are bounded at once.

use crate::regions::dual_plane::REGIONS;
use crate::regions::slope_interval::SlopeInterval;
use crate::weighted_samples::WeightedSamples;

/// So many intervals at a time have fewest regions; runs of two to these powers are one there and in smaller groups.
const MANY: usize = 8;
const MOST_MERGED: u32 = 2;
const SOME_MERGED: u32 = 1;

/// A sample as a histogram counts it: its class and weight.
#[derive(Debug, Clone, Copy)]
struct Entry {
    id: u32,
    class: u32,
    weight: i64,
}

/// Room for the histograms of one interval.
#[derive(Debug)]
pub(crate) struct Histograms {
    pub(crate) arch: pulp::Arch,
    entries: Vec<Entry>,
    /// Regions are taken together in runs of 2 to this power: few samples need few, and where many intervals are one,
    /// their slopes leave more samples open than their regions do.
    pub(crate) merged: u32,
    least_merged: u32,
    pub(crate) low: Vec<i64>,
    pub(crate) high: Vec<i64>,
    pub(crate) bounds: Vec<i64>,
    pub(crate) running: Vec<i64>,
}

impl Histograms {
    pub(crate) fn new(samples: &WeightedSamples<'_>, ids: &[u32]) -> Self {
        let merged = (REGIONS / (ids.len() / 4).clamp(8, REGIONS)).ilog2();
        let n_regions = REGIONS >> merged;
        let entry = |&id: &u32| Entry { id, class: samples.labels[id as usize], weight: samples.weights[id as usize] };
        let size = n_regions * samples.loss.lanes();
        Self {
            arch: pulp::Arch::new(),
            entries: ids.iter().map(entry).collect(),
            merged,
            least_merged: merged,
            low: vec![0; size],
            high: vec![0; size],
            bounds: vec![0; n_regions],
            running: vec![0; n_regions],
        }
    }

    /// Number of regions of intervals that are bounded `n_intervals` at a time.
    pub(crate) fn regions(&mut self, n_intervals: usize) -> usize {
        let merged = if n_intervals >= MANY {
            MOST_MERGED
        } else if n_intervals > 1 {
            SOME_MERGED
        } else {
            0
        };
        self.merged = self.least_merged.max(merged);
        REGIONS >> self.merged
    }

    /// Count all samples by class and region; their number too where leaves have a size.
    pub(crate) fn count(&mut self, first: &[u8], last: &[u8], sizes_at: Option<usize>) {
        let (n_regions, n_rows) = (REGIONS >> self.merged, self.low.len() / self.bounds.len());
        self.low[..n_rows * n_regions].fill(0);
        self.high[..n_rows * n_regions].fill(0);
        for entry in &self.entries {
            let (a, b) = (first[entry.id as usize] >> self.merged, last[entry.id as usize] >> self.merged);
            let (low, high) = (a.min(b) as usize, a.max(b) as usize);
            let begin = entry.class as usize * n_regions;
            self.low[begin + low] += entry.weight;
            self.high[begin + high] += entry.weight;
            if let Some(start) = sizes_at {
                self.low[start + low] += 1;
                self.high[start + high] += 1;
            }
        }
    }
}

/// The limits of a scan of slope intervals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Slope intervals of this bound and more are left out.
    pub(crate) dead: i64,
    /// Reduction of a bound for it to hold for fewer samples.
    pub(crate) less: i64,
    /// What intervals may save is known, and learnt.
    pub(crate) most: Option<Most>,
}

/// The most that samples can cost: all at hand, and those of them that the gains of intervals speak of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Most {
    pub(crate) all: i64,
    pub(crate) known: i64,
}

impl Limits {
    /// What a split of the samples at hand in an interval costs at least, as far as is known.
    pub(crate) fn at_least(&self, interval: &SlopeInterval) -> i64 {
        self.most.map_or(interval.bound, |most| interval.bound.max(most.known - interval.gain))
    }

    /// What a split saves at most where it costs `bound` at least, and saves no more than `gain`.
    pub(crate) fn gain(&self, gain: i64, bound: i64) -> i64 {
        self.most.map_or(gain, |most| gain.min(most.all - bound))
    }
}

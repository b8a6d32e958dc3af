//! Histograms of a slope interval, from which all its regions are bounded at once.

use crate::two_feature::regions::dual_plane::REGIONS;
use crate::two_feature::regions::slope_interval::SlopeInterval;
use crate::two_feature::weighted_samples::WeightedSamples;

/// A sample as a histogram counts it: the place where the regions of its class begin, and its weight.
#[derive(Debug, Clone, Copy)]
struct Entry {
    id: u32,
    begin: u32,
    weight: i64,
}

/// Room for the histograms of one interval.
#[derive(Debug)]
pub(crate) struct Histograms {
    pub(crate) arch: pulp::Arch,
    entries: Vec<Entry>,
    /// Regions are taken together in runs of 2 to this power: few samples need few.
    pub(crate) merged: u32,
    pub(crate) low: Vec<i64>,
    pub(crate) high: Vec<i64>,
    pub(crate) bounds: Vec<i64>,
    pub(crate) running: Vec<i64>,
}

impl Histograms {
    pub(crate) fn new(samples: &WeightedSamples<'_>, ids: &[u32]) -> Self {
        let merged = (REGIONS / (ids.len() / 4).clamp(8, REGIONS)).ilog2();
        let n_regions = REGIONS >> merged;
        let entry = |&id: &u32| Entry {
            id,
            begin: samples.labels[id as usize] * n_regions as u32,
            weight: samples.weights[id as usize],
        };
        let size = n_regions * samples.loss.lanes();
        Self {
            arch: pulp::Arch::new(),
            entries: ids.iter().map(entry).collect(),
            merged,
            low: vec![0; size],
            high: vec![0; size],
            bounds: vec![0; n_regions],
            running: vec![0; n_regions],
        }
    }

    pub(crate) fn count(&mut self, first: &[u8], last: &[u8], sizes_at: Option<usize>) {
        self.low.fill(0);
        self.high.fill(0);
        for entry in &self.entries {
            let (a, b) = (first[entry.id as usize] >> self.merged, last[entry.id as usize] >> self.merged);
            let (low, high) = (a.min(b) as usize, a.max(b) as usize);
            self.low[entry.begin as usize + low] += entry.weight;
            self.high[entry.begin as usize + high] += entry.weight;
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

//! Strips of charts, and the histograms from which all regions of a strip are bounded at once.

use super::chart::REGIONS;
use super::view::View;

/// Neighbouring strips of one chart, and a lower bound of what a split in any of them costs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Strip {
    pub chart: u32,
    /// The first of them, and how many they are.
    pub first: u16,
    pub n_strips: u16,
    pub bound: i64,
}

/// Neighbouring strips that are bounded together at first.
pub const GROUP: u16 = 16;

/// A sample as a histogram counts it: where its class's column begins, and what it weighs.
#[derive(Debug, Clone, Copy)]
struct Entry {
    id: u32,
    column: u32,
    weight: i64,
}

/// Room for the histograms of one strip.
#[derive(Debug)]
pub(super) struct Histograms {
    pub(super) arch: pulp::Arch,
    entries: Vec<Entry>,
    /// Regions are taken together in runs of 2 to this power: few samples need few.
    pub(super) merged: u32,
    pub(super) low: Vec<i64>,
    pub(super) high: Vec<i64>,
    pub(super) bounds: Vec<i64>,
    pub(super) running: Vec<i64>,
}

impl Histograms {
    pub(super) fn new(view: &View<'_>, ids: &[u32]) -> Self {
        let merged = (REGIONS / (ids.len() / 4).clamp(8, REGIONS)).ilog2();
        let n_regions = REGIONS >> merged;
        let entry = |&id: &u32| Entry {
            id,
            column: view.labels[id as usize] * n_regions as u32,
            weight: view.weights[id as usize],
        };
        let size = n_regions * view.loss.lanes();
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

    pub(super) fn count(&mut self, first: &[u8], last: &[u8], sizes_at: Option<usize>) {
        self.low.fill(0);
        self.high.fill(0);
        for entry in &self.entries {
            let (a, b) = (first[entry.id as usize] >> self.merged, last[entry.id as usize] >> self.merged);
            let (low, high) = (a.min(b) as usize, a.max(b) as usize);
            self.low[entry.column as usize + low] += entry.weight;
            self.high[entry.column as usize + high] += entry.weight;
            if let Some(start) = sizes_at {
                self.low[start + low] += 1;
                self.high[start + high] += 1;
            }
        }
    }
}

/// What the bounds of strips are held against.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Strips of this bound and more are left out.
    pub(super) dead: i64,
    /// What a bound loses to hold for fewer samples.
    pub(super) less: i64,
}

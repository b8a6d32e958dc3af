//! The least mixed cost of a child, over all its cuts: one walk over the events of each feature.

use pulp::{Simd, WithSimd};

use crate::worst_case::instance::Event;
use crate::worst_case::label_sets::{LANES, Lanes, Table};
use crate::worst_case::zones::Zones;

/// Weight of every sample, and whether all are 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights<'a> {
    /// The weights.
    pub(crate) each: &'a [i64],
    /// Whether all are 1.
    pub(crate) are_units: bool,
}

/// What all samples right of every cut cost: the leaves of both labels.
pub(crate) fn start(table: &Table, zones: &Zones) -> Lanes {
    let mut sum = [0; LANES];
    for (lanes, &weight) in table.start.iter().zip(&zones.totals) {
        add(&mut sum, lanes, weight);
    }
    sum
}

/// The least of every lane over all cuts, the ends included.
pub(crate) fn least(events: &[Event], table: &Table, zones: &Zones, weights: Weights<'_>, start: Lanes) -> Lanes {
    let scan = Scan { events, table, slots: &zones.slots, weights, start };
    pulp::Arch::new().dispatch(scan)
}

/// Plain loops over arrays of a fixed width inside `pulp`'s dispatch: the compiler makes the widest vectors of them.
struct Scan<'a> {
    events: &'a [Event],
    table: &'a Table,
    slots: &'a [u32],
    weights: Weights<'a>,
    start: Lanes,
}

impl WithSimd for Scan<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Lanes {
        if self.weights.are_units { self.steps::<true>() } else { self.steps::<false>() }
    }
}

impl Scan<'_> {
    #[inline(always)]
    fn steps<const UNITS: bool>(&self) -> Lanes {
        let (mut value, mut least) = (self.start, self.start);
        let mut rank = self.events.first().map_or(0, |event| event.rank);
        for event in self.events {
            if event.rank != rank {
                for k in 0..LANES {
                    least[k] = if value[k] < least[k] { value[k] } else { least[k] };
                }
                rank = event.rank;
            }
            let sample = event.sample();
            let lanes = &self.table.moves[self.slots[sample] as usize][event.kind()];
            let weight = if UNITS { 1 } else { self.weights.each[sample] };
            for k in 0..LANES {
                value[k] += weight * lanes[k];
            }
        }
        least
    }
}

fn add(sum: &mut Lanes, lanes: &Lanes, weight: i64) {
    for (sum, lane) in sum.iter_mut().zip(lanes) {
        *sum += weight * lane;
    }
}

//! The best single split of many samples over many pairs: dual planes made one at a time, so memory stays small.

use std::sync::atomic::AtomicBool;

use crate::geometry::line::Line;
use crate::regions::dual_plane::DualPlane;
use crate::stumps::search::{StumpResult, StumpSearch};
use crate::weighted_samples::WeightedSamples;

/// Slope intervals of a dual plane that is used once.
const INTERVALS: usize = 8;

/// Find the best leaf or split of `ids` over these dual planes; exact if below `cutoff`.
///
/// Every side of a split holds at least `need` samples. `lines` are splits that may be good.
pub(crate) fn best_single(
    samples: WeightedSamples<'_>,
    dual_planes: &[(usize, usize)],
    ids: &[u32],
    need: i64,
    cutoff: i64,
    lines: impl IntoIterator<Item = Line>,
    stop: &AtomicBool,
) -> StumpResult {
    let mut search = StumpSearch::new(samples, ids, need, cutoff, stop);
    search.try_lines(lines);
    for &features in dual_planes {
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            break;
        }
        scan_dual_plane(&mut search, &DualPlane::new(samples.plane, features, INTERVALS));
    }
    search.finish(0)
}

/// Find a good split of `ids` over a few dual planes that costs less than `cutoff`: no more than so many regions are
/// split.
pub fn best_of_dual_planes(
    samples: WeightedSamples<'_>,
    dual_planes: [&DualPlane; 2],
    ids: &[u32],
    need: i64,
    cutoff: i64,
    most_tried: usize,
    stop: &AtomicBool,
) -> StumpResult {
    let mut search = StumpSearch::new(samples, ids, need, cutoff, stop);
    search.most_tried = most_tried;
    dual_planes.into_iter().for_each(|dual_plane| scan_dual_plane(&mut search, dual_plane));
    search.finish(0)
}

fn scan_dual_plane(search: &mut StumpSearch<'_>, dual_plane: &DualPlane) {
    search.begin_dual_plane();
    for interval in 0..dual_plane.n_intervals() {
        search.scan(dual_plane, (interval, interval + 1), true);
    }
    search.try_best_of_dual_plane();
}

//! The best single split of many samples over many pairs: charts made one at a time, so memory stays small.

use std::sync::atomic::AtomicBool;

use super::chart::Chart;
use super::stump::{Answer, Search};
use super::view::{Line, View};

/// Strips of a chart that is used once.
const STRIPS: usize = 8;

/// Find the best leaf or split of `ids` over these charts; exact if below `cutoff`.
///
/// Every side of a split holds at least `need` samples. `lines` are splits that may be good.
pub fn best_single(
    view: View<'_>,
    charts: &[(usize, usize)],
    ids: &[u32],
    need: i64,
    cutoff: i64,
    lines: impl IntoIterator<Item = Line>,
    stop: &AtomicBool,
) -> Answer {
    let mut search = Search::new(view, ids, need, cutoff, stop);
    search.try_lines(lines);
    for &features in charts {
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            break;
        }
        scan_chart(&mut search, &Chart::new(view.plane, features, STRIPS));
    }
    search.finish(0)
}

/// Find a good split of `ids` over a few charts that costs less than `cutoff`: no more than so many regions are split.
pub fn best_of_charts(
    view: View<'_>,
    charts: [&Chart; 2],
    ids: &[u32],
    need: i64,
    cutoff: i64,
    most_tried: usize,
    stop: &AtomicBool,
) -> Answer {
    let mut search = Search::new(view, ids, need, cutoff, stop);
    search.most_tried = most_tried;
    charts.into_iter().for_each(|chart| scan_chart(&mut search, chart));
    search.finish(0)
}

fn scan_chart(search: &mut Search<'_>, chart: &Chart) {
    search.begin_chart();
    for strip in 0..chart.n_strips() {
        search.scan(chart, (strip, strip + 1), true);
    }
    search.try_best_of_chart();
}

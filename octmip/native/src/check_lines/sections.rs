//! The parts of a proof: a case for what sensors are read, in each a section for every chart of root lines.

use std::ops::Range;
use std::sync::Arc;

use super::{Checker, Strip};
use crate::check::Refusal;
use crate::problem::Problem;

/// A chart of root lines (none: trees of one split), the strips of all charts in play, and the lines of its proof.
pub(super) struct Section {
    pub(super) chart: Option<(usize, usize)>,
    pub(super) strips: Arc<Vec<Strip>>,
    pub(super) lines: Range<usize>,
}

impl Checker<'_> {
    /// Every tree reads a sensor or does not; `read` says what is decided. What cannot be paid for beside those that are
    /// read, and what is one sensor more than splits can read, is not read either.
    pub(super) fn sensors(
        &self,
        line: &mut usize,
        read: &mut Vec<Option<bool>>,
        tasks: &mut Vec<Section>,
    ) -> Result<(), Refusal> {
        let q = self.q;
        if let Some(number) = self.lines.get(*line).and_then(|text| text.strip_prefix("S ")) {
            let sensor = number.parse().unwrap_or(usize::MAX);
            *line += 1;
            ensure!(read.get(sensor) == Some(&None), *line, "sensor {number} cannot be decided here");
            for choice in [false, true] {
                read[sensor] = Some(choice);
                self.sensors(line, read, tasks)?;
            }
            read[sensor] = None;
            return Ok(());
        }
        let taken: Vec<usize> = (0..read.len()).filter(|&s| read[s] == Some(true)).collect();
        let paid: f64 = taken.iter().map(|&s| q.sensor_cost[s]).sum();
        let is_within = |s: usize| (paid + q.sensor_cost[s]) * (1.0 - 1e-12) <= q.sensor_limit;
        let may_read = |s: usize| read[s].unwrap_or_else(|| taken.len() < 2 * ((1 << q.depth) - 1) && is_within(s));
        let charts: Vec<_> = charts_of(q, |f| may_read(q.sensor_of_feature[f] as usize)).collect();
        let range = |&(f, g): &(usize, usize)| {
            if g == q.p { ((f, g), 0.0, 0.0) } else { ((f, g), -1.0, 1.0) }
        };
        let strips = Arc::new(charts.iter().map(range).collect::<Vec<_>>());
        for chart in charts.into_iter().map(Some).chain([None]).filter(|chart| chart.is_none() == (q.depth == 1)) {
            let title = chart.map_or("D".into(), |(f, g)| format!("C {f} {g}"));
            let got = self.lines.get(*line);
            ensure!(got == Some(&title.as_str()), *line + 1, "expected {title:?}, got {got:?}");
            let body = self.lines[*line + 1..].iter().take_while(|text| !text.starts_with(['C', 'D', 'S', 'e']));
            let lines = *line + 1..*line + 1 + body.count();
            *line = lines.end;
            tasks.push(Section { chart, strips: strips.clone(), lines });
        }
        Ok(())
    }
}

/// The charts of a problem, each pair of features in both orders, of features that may be read.
fn charts_of(q: &Problem, may_read: impl Fn(usize) -> bool) -> impl Iterator<Item = (usize, usize)> {
    let pairs = (0..q.p).flat_map(move |f| (0..=q.p).filter(move |&g| g != f).map(move |g| (f, g)));
    pairs.filter(move |&(f, g)| {
        if g == q.p {
            return q.allowed[f] && may_read(f);
        }
        let planes = q.planes.as_ref().filter(|planes| planes.split_size > 1);
        let is_allowed = planes.is_some_and(|planes| {
            planes.groups.as_ref().is_none_or(|groups| {
                let has = |group: &Vec<u32>, f: usize| group.contains(&(f as u32));
                groups.iter().any(|group| has(group, f) && has(group, g))
            })
        });
        is_allowed && may_read(f) && may_read(g)
    })
}

//! The parts of a proof: a case for what sensors are read, in each a section for every dual plane of root lines.

use std::sync::Arc;

use super::checker::{Checker, DualPlane, SlopeInterval};
use crate::log::cursor::Cursor;
use crate::log::decisions::Decisions;
use crate::problem::Problem;
use crate::refusal::{Checked, ensure, shown};

/// A dual plane of root lines (none: trees of one split), the slope intervals of all dual planes in play, and the lines
/// of its proof.
pub(super) struct Section<'a> {
    pub(super) dual_plane: Option<DualPlane>,
    pub(super) intervals: Arc<Vec<SlopeInterval>>,
    pub(super) cursor: Cursor<'a>,
}

impl Checker<'_> {
    /// The sections of all cases, in the order of the log.
    pub(super) fn sections<'a>(&self, cursor: &mut Cursor<'a>) -> Checked<Vec<Section<'a>>> {
        // A tree cannot read more sensors than its splits have features.
        let most = 2 * ((1 << self.q.depth) - 1);
        let (mut decisions, mut sections) = (Decisions::new(self.q.sensor_cost.len()), Vec::new());
        loop {
            decisions.read(cursor)?;
            self.case(&decisions.may_read(&self.q.sensor_cost, self.q.sensor_limit, most), cursor, &mut sections)?;
            if !decisions.go_on() {
                return Ok(sections);
            }
        }
    }

    /// The sections of one case: one for each dual plane, or one of single splits.
    fn case<'a>(&self, may_read: &[bool], cursor: &mut Cursor<'a>, found: &mut Vec<Section<'a>>) -> Checked<()> {
        let q = self.q;
        let dual_planes: Vec<_> = dual_planes_of(q, |f| may_read[q.sensor_of_feature[f] as usize]).collect();
        let range = |&(f, g): &DualPlane| {
            if g == q.p { ((f, g), 0.0, 0.0) } else { ((f, g), -1.0, 1.0) }
        };
        let intervals = Arc::new(dual_planes.iter().map(range).collect::<Vec<_>>());
        let is_single = q.depth == 1;
        let sections = dual_planes.into_iter().map(Some).chain([None]);
        for dual_plane in sections.filter(|dual_plane| dual_plane.is_none() == is_single) {
            let title = dual_plane.map_or("D".into(), |(f, g)| format!("C {f} {g}"));
            let got = cursor.read();
            ensure!(got == Some(&title), cursor.line(), "got {}, expected {title:?}", shown(got.unwrap_or("")));
            let body = cursor.section(|text| text.starts_with(['C', 'D', 'S', 'e']));
            found.push(Section { dual_plane, intervals: intervals.clone(), cursor: body });
        }
        Ok(())
    }
}

/// The dual planes of a problem, each pair of features in both orders, of features that may be read.
fn dual_planes_of(q: &Problem, may_read: impl Fn(usize) -> bool) -> impl Iterator<Item = DualPlane> {
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

//! Nodes as numbers: a later search takes them up, and makes every batch that this one would have made.
//!
//! Tables of slope intervals that several nodes share stand once. What is read is checked for what would break a
//! search; that its bounds hold is believed.

use std::collections::HashMap;
use std::sync::Arc;

use crate::nodes::node::{Child, Node, SearchContext};
use crate::nodes::numbers::{Reader, Writer};
use crate::regions::region::Region;
use crate::regions::slope_interval::SlopeInterval;

type Intervals = Arc<Vec<SlopeInterval>>;

/// Tables that were written, by address: their numbers in the order of their first node.
#[derive(Debug, Default)]
pub(crate) struct WrittenTables(HashMap<*const SlopeInterval, u64>);

impl WrittenTables {
    /// Write a node.
    pub(crate) fn write(&mut self, out: &mut Writer, node: &Node) {
        out.number(u64::from(node.dual_plane));
        let Region { t0, t1, l0, l1, u0, u1 } = node.region;
        [t0, t1, l0, l1, u0, u1].into_iter().for_each(|edge| out.real(edge));
        out.signed(node.key);
        out.number(node.n_learnt as u64);
        for child in &node.children {
            [child.floor, child.wide.0, child.wide.1, child.struck].into_iter().for_each(|bound| out.signed(bound));
            out.list(child.lines.iter(), Writer::line);
            child.within.iter().for_each(|&word| out.number(word));
            self.write_table(out, &child.intervals);
        }
    }

    /// The number of a table, and its intervals where it is new.
    fn write_table(&mut self, out: &mut Writer, intervals: &Intervals) {
        let next = self.0.len() as u64;
        let number = *self.0.entry(intervals.as_ptr()).or_insert(next);
        out.number(number);
        if number == next {
            out.list(intervals.iter(), |out, interval| {
                let place = u64::from(interval.dual_plane) << 32 | u64::from(interval.first) << 16;
                out.number(place | u64::from(interval.n_intervals));
                out.signed(interval.bound);
                out.signed(interval.gain);
            });
        }
    }
}

/// Tables that were read.
pub(crate) struct ReadTables<'a> {
    context: &'a SearchContext<'a>,
    tables: Vec<Intervals>,
}

impl<'a> ReadTables<'a> {
    /// None yet.
    pub(crate) fn new(context: &'a SearchContext<'a>) -> Self {
        Self { context, tables: Vec::new() }
    }

    /// Read a node of a dual plane that there is.
    pub(crate) fn read(&mut self, from: &mut Reader<'_>) -> Option<Node> {
        let dual_plane = u32::try_from(from.number()?).ok()?;
        let mut edge = || from.real();
        let region = Region { t0: edge()?, t1: edge()?, l0: edge()?, l1: edge()?, u0: edge()?, u1: edge()? };
        let (key, n_learnt) = (from.cost()?, from.number()? as usize);
        let node = Node { dual_plane, region, key, children: [self.child(from)?, self.child(from)?], n_learnt };
        ((dual_plane as usize) < self.context.dual_planes.len()).then_some(node)
    }

    fn child(&mut self, from: &mut Reader<'_>) -> Option<Child> {
        let [floor, low, most, struck] = [from.cost()?, from.cost()?, from.cost()?, from.cost()?];
        let lines = from.list(Reader::line)?;
        let n_words = self.context.all.len().div_ceil(64);
        let within = (0..n_words).map(|_| from.number()).collect::<Option<_>>()?;
        Some(Child { floor, wide: (low, most), lines, intervals: self.table(from)?, struck, within })
    }

    fn table(&mut self, from: &mut Reader<'_>) -> Option<Intervals> {
        let number = from.number()? as usize;
        if number == self.tables.len() {
            let intervals = from.list(|from| self.interval(from))?;
            self.tables.push(Arc::new(intervals));
        }
        self.tables.get(number).cloned()
    }

    fn interval(&self, from: &mut Reader<'_>) -> Option<SlopeInterval> {
        let place = from.number()?;
        let (dual_plane, first, n_intervals) = ((place >> 32) as u32, (place >> 16) as u16, place as u16);
        let (bound, gain) = (from.cost()?, from.signed()?);
        let most = self.context.dual_planes.get(dual_plane as usize)?.n_intervals();
        let is_there = n_intervals > 0 && usize::from(first) + usize::from(n_intervals) <= most;
        is_there.then_some(SlopeInterval { dual_plane, first, n_intervals, bound, gain })
    }
}

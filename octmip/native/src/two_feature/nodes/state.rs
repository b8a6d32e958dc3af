//! The state of a search over nodes as bytes, small enough to be kept: a later search takes it up where it was left, and
//! makes every batch that this one would have made.
//!
//! Numbers of 8 bytes each, the least significant byte first; tables of slope intervals that several nodes share stand
//! once. What a later search reads is checked for what would break it; that its bounds hold is believed.

use std::collections::HashMap;
use std::sync::Arc;

use crate::two_feature::geometry::line::Line;
use crate::two_feature::loss::INFEASIBLE;
use crate::two_feature::nodes::node::{Child, Node, SearchContext};
use crate::two_feature::regions::region::Region;
use crate::two_feature::regions::slope_interval::SlopeInterval;

type Intervals = Arc<Vec<SlopeInterval>>;

/// Numbers one after the other.
#[derive(Debug, Default)]
pub(crate) struct Writer {
    bytes: Vec<u8>,
    /// Tables that were written, by address, in the order of their first node.
    tables: HashMap<*const SlopeInterval, u64>,
}

impl Writer {
    /// A whole number.
    pub(crate) fn number(&mut self, number: u64) {
        self.bytes.extend_from_slice(&number.to_le_bytes());
    }

    /// A number with a sign.
    pub(crate) fn signed(&mut self, number: i64) {
        self.number(number as u64);
    }

    /// A real number, every bit of it.
    pub(crate) fn real(&mut self, number: f64) {
        self.number(number.to_bits());
    }

    /// A list, its length first.
    pub(crate) fn list<T>(&mut self, items: impl ExactSizeIterator<Item = T>, mut each: impl FnMut(&mut Self, T)) {
        self.number(items.len() as u64);
        items.for_each(|item| each(self, item));
    }

    /// A line.
    pub(crate) fn line(&mut self, line: &Line) {
        self.number((line.features.0 as u64) << 32 | line.features.1 as u64);
        self.real(line.t);
        self.real(line.r);
    }

    /// A node.
    pub(crate) fn node(&mut self, node: &Node) {
        self.number(u64::from(node.dual_plane));
        let Region { t0, t1, l0, l1, u0, u1 } = node.region;
        [t0, t1, l0, l1, u0, u1].into_iter().for_each(|edge| self.real(edge));
        self.signed(node.key);
        node.children.iter().for_each(|child| self.child(child));
    }

    fn child(&mut self, child: &Child) {
        [child.floor, child.wide.0, child.wide.1, child.struck].into_iter().for_each(|bound| self.signed(bound));
        self.list(child.lines.iter(), Self::line);
        self.table(&child.intervals);
    }

    /// The number of a table, and its intervals where it is new.
    fn table(&mut self, intervals: &Intervals) {
        let next = self.tables.len() as u64;
        let number = *self.tables.entry(intervals.as_ptr()).or_insert(next);
        self.number(number);
        if number == next {
            self.list(intervals.iter(), |out, interval| {
                let place = u64::from(interval.dual_plane) << 32 | u64::from(interval.first) << 16;
                out.number(place | u64::from(interval.n_intervals));
                out.signed(interval.bound);
            });
        }
    }

    /// All of them.
    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

/// The numbers of a writer, read again; None where they are not what was asked for.
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    context: &'a SearchContext<'a>,
    tables: Vec<Intervals>,
}

impl<'a> Reader<'a> {
    /// From the beginning.
    pub(crate) fn new(bytes: &'a [u8], context: &'a SearchContext<'a>) -> Self {
        Self { bytes, context, tables: Vec::new() }
    }

    /// A whole number.
    pub(crate) fn number(&mut self) -> Option<u64> {
        let (number, rest) = self.bytes.split_first_chunk::<8>()?;
        self.bytes = rest;
        Some(u64::from_le_bytes(*number))
    }

    /// A number with a sign.
    pub(crate) fn signed(&mut self) -> Option<i64> {
        self.number().map(|number| number as i64)
    }

    /// A cost or bound: sums of a few of them do not overflow.
    pub(crate) fn cost(&mut self) -> Option<i64> {
        self.signed().filter(|cost| cost.abs() <= INFEASIBLE)
    }

    /// A count, far from the largest number.
    pub(crate) fn count(&mut self) -> Option<u64> {
        self.number().filter(|&count| count < 1 << 62)
    }

    /// A finite number.
    pub(crate) fn real(&mut self) -> Option<f64> {
        self.number().map(f64::from_bits).filter(|number| number.is_finite())
    }

    /// A list.
    pub(crate) fn list<T>(&mut self, mut each: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let length = self.number()?;
        // Every item takes a number at least, so a length that cannot be takes no memory.
        (length <= self.bytes.len() as u64 / 8).then(|| (0..length).map(|_| each(self)).collect())?
    }

    /// A line over features that there are.
    pub(crate) fn line(&mut self) -> Option<Line> {
        let features = self.number()?;
        let features = ((features >> 32) as usize, features as u32 as usize);
        let p = self.context.instance.plane.p;
        let line = Line { features, t: self.real()?, r: self.real()? };
        (features.0 < p && features.1 <= p).then_some(line)
    }

    /// A node of a dual plane that there is.
    pub(crate) fn node(&mut self) -> Option<Node> {
        let dual_plane = u32::try_from(self.number()?).ok()?;
        let mut edge = || self.real();
        let region = Region { t0: edge()?, t1: edge()?, l0: edge()?, l1: edge()?, u0: edge()?, u1: edge()? };
        let node = Node { dual_plane, region, key: self.cost()?, children: [self.child()?, self.child()?] };
        ((dual_plane as usize) < self.context.dual_planes.len()).then_some(node)
    }

    fn child(&mut self) -> Option<Child> {
        let [floor, low, most, struck] = [self.cost()?, self.cost()?, self.cost()?, self.cost()?];
        let lines = self.list(Self::line)?;
        Some(Child { floor, wide: (low, most), lines, intervals: self.table()?, struck })
    }

    fn table(&mut self) -> Option<Intervals> {
        let number = self.number()? as usize;
        if number == self.tables.len() {
            let intervals = self.list(Self::interval)?;
            self.tables.push(Arc::new(intervals));
        }
        self.tables.get(number).cloned()
    }

    fn interval(&mut self) -> Option<SlopeInterval> {
        let place = self.number()?;
        let (dual_plane, first, n_intervals) = ((place >> 32) as u32, (place >> 16) as u16, place as u16);
        let bound = self.cost()?;
        let most = self.context.dual_planes.get(dual_plane as usize)?.n_intervals();
        let is_there = n_intervals > 0 && usize::from(first) + usize::from(n_intervals) <= most;
        is_there.then_some(SlopeInterval { dual_plane, first, n_intervals, bound })
    }

    /// Whether nothing is left.
    pub(crate) fn is_at_end(&self) -> bool {
        self.bytes.is_empty()
    }
}

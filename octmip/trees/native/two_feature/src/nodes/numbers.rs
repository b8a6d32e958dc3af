//! Numbers of 8 bytes each, the least significant byte first, as the state of a search is kept.

use crate::geometry::line::Line;
use crate::loss::INFEASIBLE;

/// Numbers one after the other.
#[derive(Debug, Default)]
pub(crate) struct Writer {
    bytes: Vec<u8>,
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

    /// All of them.
    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

/// The numbers of a writer, read again; None where they are not what was asked for.
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    /// Number of features.
    p: usize,
}

impl<'a> Reader<'a> {
    /// From the beginning; lines are over so many features.
    pub(crate) fn new(bytes: &'a [u8], p: usize) -> Self {
        Self { bytes, p }
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
        self.signed().filter(|cost| (-INFEASIBLE..=INFEASIBLE).contains(cost))
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
        let line = Line { features, t: self.real()?, r: self.real()? };
        (features.0 < self.p && features.1 <= self.p).then_some(line)
    }

    /// Whether nothing is left.
    pub(crate) fn is_at_end(&self) -> bool {
        self.bytes.is_empty()
    }
}

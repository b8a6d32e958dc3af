//! Numbers that begin at a cache line, so that no vector load straddles two.

use pulp::bytemuck::{Pod, Zeroable};

const LINE: usize = 64;

/// Room for any index of 16 bits.
pub(crate) const ROOM: usize = 1 << u16::BITS;

/// A buffer of numbers on a 64-byte boundary.
#[derive(Debug, Default, Clone)]
pub(crate) struct Aligned<P> {
    data: Vec<P>,
    start: usize,
    len: usize,
}

impl<P: Pod + Zeroable> Aligned<P> {
    /// Make it `len` zeros.
    pub(crate) fn zero(&mut self, len: usize) {
        let room = len.max(ROOM) + LINE / size_of::<P>();
        if self.data.len() < room {
            self.data = vec![P::zeroed(); room];
            self.start = self.data.as_ptr().align_offset(LINE).min(LINE / size_of::<P>());
        }
        self.len = len;
        self.get_mut().fill(P::zeroed());
    }

    /// The numbers and what lies past them, `ROOM` at least.
    #[inline(always)]
    pub(crate) fn with_room(&mut self) -> &mut [P] {
        &mut self.data[self.start..]
    }

    /// The numbers.
    #[inline(always)]
    pub(crate) fn get(&self) -> &[P] {
        &self.data[self.start..self.start + self.len]
    }

    /// The numbers, to write.
    #[inline(always)]
    pub(crate) fn get_mut(&mut self) -> &mut [P] {
        &mut self.data[self.start..self.start + self.len]
    }
}

//! Cells of samples in the buckets of features, in as few bits as hold them.

use crate::stumps::aligned::ROOM;

/// A cell of a histogram: the bucket, row and slot that a sample is counted in.
pub(crate) trait Cell: Copy {
    /// Its place in a histogram.
    fn of<P>(self, pairs: &mut [P]) -> &mut P;
}

impl Cell for u16 {
    #[inline(always)]
    fn of<P>(self, pairs: &mut [P]) -> &mut P {
        &mut pairs[..ROOM][self as usize] // no check but one of the length, as 16 bits never lie outside
    }
}

impl Cell for u32 {
    #[inline(always)]
    fn of<P>(self, pairs: &mut [P]) -> &mut P {
        &mut pairs[self as usize]
    }
}

/// Cells of samples: half the memory, and half of what is read while a cut moves, where 16 bits are enough.
#[derive(Debug)]
pub(crate) enum Cells {
    /// Of 16 bits.
    Narrow(Vec<u16>),
    /// Of 32 bits.
    Wide(Vec<u32>),
}

impl Default for Cells {
    fn default() -> Self {
        Self::Narrow(Vec::new())
    }
}

impl Cells {
    /// Make room for `len` samples and features, a group of `n_cells`; what it held is worth nothing.
    pub(crate) fn make_room(&mut self, len: usize, n_cells: usize) {
        match (&mut *self, n_cells <= ROOM) {
            (Self::Narrow(cells), true) => cells.resize(len, 0),
            (Self::Wide(cells), false) => cells.resize(len, 0),
            (_, is_narrow) => {
                *self = Self::default(); // the one before the other: they are large
                *self = if is_narrow { Self::Narrow(vec![0; len]) } else { Self::Wide(vec![0; len]) };
            }
        }
    }

    /// Put samples of a feature into cells: pairs of place and cell.
    #[inline(always)]
    pub(crate) fn set(&mut self, entries: impl Iterator<Item = (usize, usize)>) {
        match self {
            Self::Narrow(cells) => entries.for_each(|(at, cell)| cells[at] = cell as u16),
            Self::Wide(cells) => entries.for_each(|(at, cell)| cells[at] = cell as u32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(cells: &Cells) -> Vec<usize> {
        match cells {
            Cells::Narrow(cells) => cells.iter().map(|&cell| cell as usize).collect(),
            Cells::Wide(cells) => cells.iter().map(|&cell| cell as usize).collect(),
        }
    }

    #[test]
    fn the_last_cell_is_held_in_either_width() {
        let mut cells = Cells::default();
        for (n_cells, is_narrow) in [(1 << 16, true), ((1 << 16) + 1, false), (100, true)] {
            cells.make_room(2, n_cells);
            cells.set(std::iter::once((1, n_cells - 1)));
            assert_eq!((held(&cells)[1], matches!(cells, Cells::Narrow(_))), (n_cells - 1, is_narrow));
        }
    }
}

//! Bounds of sets of samples and good lines that nodes share: roots over other features send much the same samples to
//! the same side.
//!
//! Dropping samples lowers no optimum, adding them raises it by at most what they can cost. So for any two sets
//! STUMP(S) >= STUMP(S and T) >= STUMP(T) - most(T without S). A few words of bits are compared in place of a search.

use std::collections::VecDeque;

use crate::geometry::line::Line;
use crate::instance::Instance;
use crate::nodes::numbers::{Reader, Writer};

/// Most sets and lines that are kept, the youngest, also in proportion to the dual planes.
const MOST_SETS: usize = 3000;
const SETS_PER_DUAL_PLANE: usize = 4;
const MOST_LINES: usize = 128;
const DUAL_PLANES_PER_LINE: usize = 4;

/// Credit of the wide bound at first and at most, the worth of a success in failures, and the nodes that are worth one.
const CREDIT: i64 = 32;
const SUCCESS: i64 = 4;
const NODES_PER_CREDIT: u64 = 64;

/// A set of samples, one bit each.
pub(crate) type Bits = Box<[u64]>;

/// Bounds and lines that one node has found.
#[derive(Debug, Default)]
pub(crate) struct Lessons {
    /// Sets of samples, and a bound of a leaf or split of them.
    pub(crate) sets: Vec<(Bits, i64)>,
    /// Splits that were best for some set.
    pub(crate) lines: Vec<Line>,
    /// Credit that the wide bound gained or lost.
    pub(crate) wide: i64,
}

/// Bounds and lines that all nodes have found; they are added between batches only, so that nothing depends on the
/// number of threads.
#[derive(Debug)]
pub(crate) struct Known {
    n: usize,
    /// The most that one sample can cost.
    step: i64,
    pub sets: VecDeque<(Bits, i64)>,
    lines: VecDeque<Line>,
    most_sets: usize,
    most_lines: usize,
    /// Of the wide bound: it falls with every vain attempt, and where it is used up the bound is seldom tried.
    credit: i64,
    spares_wide: bool,
    pub n_nodes: u64,
}

impl Known {
    /// Nothing known yet. Under a budget with several affordable sets of sensors, a line that one allows another may
    /// not: then nothing is passed on. Bounds of sets are of leaves of any size.
    pub(crate) fn new(instance: &Instance, n_affordable: usize) -> Self {
        let worst =
            |i: &u32| instance.weights[*i as usize] * instance.loss.worst[instance.labels[*i as usize] as usize];
        let switches = instance.switches;
        let passes_lines = n_affordable == 1 && switches.known_lines;
        let passes_sets = n_affordable == 1 && instance.loss.leaf_size == 1 && switches.known_sets;
        Self {
            n: instance.plane.n,
            step: instance.all().iter().map(worst).max().unwrap_or(0),
            sets: VecDeque::new(),
            lines: VecDeque::new(),
            most_sets: if passes_sets { (instance.dual_planes.len() * SETS_PER_DUAL_PLANE).min(MOST_SETS) } else { 0 },
            most_lines: if passes_lines {
                (instance.dual_planes.len() / DUAL_PLANES_PER_LINE).min(MOST_LINES)
            } else {
                0
            },
            credit: CREDIT,
            spares_wide: switches.spared,
            n_nodes: 0,
        }
    }

    /// Nothing known yet, and room for so many sets; no lines are passed on.
    pub(crate) fn with_sets(instance: &Instance, most_sets: usize) -> Self {
        let known = Self::new(instance, 1);
        Self { most_sets: if known.most_sets > 0 { most_sets } else { 0 }, most_lines: 0, ..known }
    }

    /// The best known bound of a set.
    pub(crate) fn at_least_of(&self, ids: &[u32]) -> i64 {
        if self.most_sets > 0 { self.at_least(&self.bits([ids, &[]])) } else { 0 }
    }

    /// Write what is known.
    pub(crate) fn write(&self, out: &mut Writer) {
        out.list(self.sets.iter(), |out, (set, bound)| {
            set.iter().for_each(|&word| out.number(word));
            out.signed(*bound);
        });
        out.list(self.lines.iter(), Writer::line);
        out.signed(self.credit);
        out.number(self.n_nodes);
    }

    /// Read it again; whether it was there.
    pub(crate) fn read(&mut self, from: &mut Reader<'_>) -> Option<()> {
        let n_words = self.n.div_ceil(64);
        let set = |from: &mut Reader<'_>| {
            let set = (0..n_words).map(|_| from.number()).collect::<Option<Bits>>()?;
            Some((set, from.cost()?))
        };
        self.sets = from.list(set)?.into();
        self.lines = from.list(Reader::line)?.into();
        (self.credit, self.n_nodes) = (from.cost()?.min(CREDIT), from.count()?);
        Some(())
    }

    /// The set of these samples, given in two parts.
    pub(crate) fn bits(&self, parts: [&[u32]; 2]) -> Bits {
        let mut bits = vec![0; self.n.div_ceil(64)].into_boxed_slice();
        for &i in parts.into_iter().flatten() {
            bits[i as usize / 64] |= 1 << (i % 64);
        }
        bits
    }

    fn at_least(&self, set: &[u64]) -> i64 {
        let mut best = 0;
        for (other, bound) in &self.sets {
            if *bound > best {
                let n_more: u32 = other.iter().zip(set).map(|(other, set)| (other & !set).count_ones()).sum();
                best = best.max(bound - self.step * i64::from(n_more));
            }
        }
        best
    }

    /// Add the bounds and lines that a node has found, where they are new.
    pub(crate) fn learn(&mut self, lessons: Lessons) {
        self.n_nodes += 1;
        let earned = lessons.wide + i64::from(self.n_nodes.is_multiple_of(NODES_PER_CREDIT));
        self.credit = (self.credit + earned).min(CREDIT);
        for (set, bound) in lessons.sets {
            if self.most_sets > 0 && self.at_least(&set) < bound {
                self.sets.truncate(self.most_sets - 1);
                self.sets.push_front((set, bound));
            }
        }
        for line in lessons.lines {
            if self.most_lines > 0 && !self.lines.contains(&line) {
                self.lines.truncate(self.most_lines - 1);
                self.lines.push_front(line);
            }
        }
    }
}

/// The notes of one node: bounds and lines of other nodes, and its own.
#[derive(Debug)]
pub(crate) struct Notes<'a> {
    known: &'a Known,
    /// For the nodes of later batches.
    pub(crate) lessons: Lessons,
}

impl<'a> Notes<'a> {
    /// No notes of its own yet.
    pub(crate) fn new(known: &'a Known) -> Self {
        Self { known, lessons: Lessons::default() }
    }

    /// Whether bounds of sets are kept at all.
    pub(crate) fn keeps_sets(&self) -> bool {
        self.known.most_sets > 0
    }

    /// Splits that were best somewhere.
    pub(crate) fn lines(&self) -> impl Iterator<Item = &'a Line> + use<'a> {
        self.known.lines.iter()
    }

    /// The best known bound of a leaf or split of a set, given in two parts.
    pub(crate) fn at_least(&self, parts: [&[u32]; 2]) -> i64 {
        if self.keeps_sets() { self.known.at_least(&self.known.bits(parts)) } else { 0 }
    }

    /// Whether the wide bound closed enough nodes of late.
    pub(crate) fn is_wide_worth_while(&self) -> bool {
        self.known.credit > 0 || !self.known.spares_wide
    }

    /// Note whether the wide bound closed this node.
    pub(crate) fn note_wide(&mut self, closed: bool) {
        self.lessons.wide += if closed { SUCCESS } else { -1 };
    }

    /// Note a bound of a set, and its best split.
    ///
    /// Nothing is noted of the empty set: that no tree has an empty side says nothing of a set that lost its samples.
    pub(crate) fn add(&mut self, parts: [&[u32]; 2], bound: i64, line: Option<Line>) {
        let is_empty = parts.iter().all(|part| part.is_empty());
        if self.keeps_sets() && bound > 0 && !is_empty {
            self.lessons.sets.push((self.known.bits(parts), bound));
        }
        self.lessons.lines.extend(line);
    }
}

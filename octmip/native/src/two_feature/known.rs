//! What boxes have learnt of sets of samples, for all other boxes: roots over other features send much the same samples
//! to the same side.
//!
//! Dropping samples lowers no optimum, adding them raises it by at most what they can cost. So for any two sets
//! STUMP(S) >= STUMP(S and T) >= STUMP(T) - most(T without S). A few words of bits are compared in place of a search.

use std::collections::VecDeque;

use super::ground::Ground;
use super::view::Line;

/// Sets that are kept, the youngest; lines as a share of the charts.
const MOST_SETS: usize = 3000;
const SETS_A_CHART: usize = 4;
const MOST_LINES: usize = 128;
const CHARTS_A_LINE: usize = 4;

/// Credit of the wide bound at first and at most, what a success is worth in failures, and boxes that are worth one.
const CREDIT: i64 = 32;
const SUCCESS: i64 = 4;
const BOXES_A_CREDIT: u64 = 64;

/// A set of samples, one bit each.
pub type Bits = Box<[u64]>;

/// What one box has learnt.
#[derive(Debug, Default)]
pub struct Lessons {
    /// Sets of samples, and what a leaf or split of them costs at least.
    pub sets: Vec<(Bits, i64)>,
    /// Splits that were best for some set.
    pub lines: Vec<Line>,
    /// What the wide bound gained or lost in credit.
    pub wide: i64,
}

/// What all boxes have learnt; it grows between batches only, so that it does not depend on the number of threads.
#[derive(Debug)]
pub struct Known {
    n: usize,
    /// The most that one sample can cost.
    step: i64,
    sets: VecDeque<(Bits, i64)>,
    lines: VecDeque<Line>,
    most_sets: usize,
    most_lines: usize,
    /// Of the wide bound: it falls with every vain attempt, and where it is used up the bound is seldom tried.
    credit: i64,
    spares_wide: bool,
    n_boxes: u64,
}

impl Known {
    /// Nothing known. Under a budget with several affordable sets of sensors, what one allows another may not: then
    /// nothing is passed on. Bounds of sets are of leaves of any size.
    pub fn new(ground: &Ground, n_affordable: usize) -> Self {
        let worst = |i: &u32| ground.weights[*i as usize] * ground.loss.worst[ground.labels[*i as usize] as usize];
        let switches = ground.switches;
        let passes_lines = n_affordable == 1 && switches.known_lines;
        let passes_sets = n_affordable == 1 && ground.loss.leaf_size == 1 && switches.known_sets;
        Self {
            n: ground.plane.n,
            step: ground.all().iter().map(worst).max().unwrap_or(0),
            sets: VecDeque::new(),
            lines: VecDeque::new(),
            most_sets: if passes_sets { (ground.charts.len() * SETS_A_CHART).min(MOST_SETS) } else { 0 },
            most_lines: if passes_lines { (ground.charts.len() / CHARTS_A_LINE).min(MOST_LINES) } else { 0 },
            credit: CREDIT,
            spares_wide: switches.spared,
            n_boxes: 0,
        }
    }

    fn bits(&self, parts: [&[u32]; 2]) -> Bits {
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

    /// Take what a box has learnt, where it is new.
    pub fn learn(&mut self, lessons: Lessons) {
        self.n_boxes += 1;
        let earned = lessons.wide + i64::from(self.n_boxes.is_multiple_of(BOXES_A_CREDIT));
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

/// The notes of one box: what others have learnt, and what it has learnt itself.
#[derive(Debug)]
pub struct Notes<'a> {
    known: &'a Known,
    /// For the boxes of later batches.
    pub lessons: Lessons,
}

impl<'a> Notes<'a> {
    /// No notes of its own yet.
    pub fn new(known: &'a Known) -> Self {
        Self { known, lessons: Lessons::default() }
    }

    /// Whether bounds of sets are kept at all.
    pub fn keeps_sets(&self) -> bool {
        self.known.most_sets > 0
    }

    /// Splits that were best somewhere.
    pub fn lines(&self) -> impl Iterator<Item = &'a Line> + use<'a> {
        self.known.lines.iter()
    }

    /// What a leaf or split of a set, given in two parts, costs at least, as far as that is known.
    pub fn at_least(&self, parts: [&[u32]; 2]) -> i64 {
        if self.keeps_sets() { self.known.at_least(&self.known.bits(parts)) } else { 0 }
    }

    /// Whether the wide bound closed enough boxes of late.
    pub fn is_wide_worth_while(&self) -> bool {
        self.known.credit > 0 || !self.known.spares_wide
    }

    /// Note whether the wide bound closed this box.
    pub fn note_wide(&mut self, closed: bool) {
        self.lessons.wide += if closed { SUCCESS } else { -1 };
    }

    /// Note what a set costs at least, and its best split.
    ///
    /// Nothing is learnt of no samples: no tree has an empty side, which is not what a set costs that lost its samples.
    pub fn add(&mut self, parts: [&[u32]; 2], bound: i64, line: Option<Line>) {
        let is_empty = parts.iter().all(|part| part.is_empty());
        if self.keeps_sets() && bound > 0 && !is_empty {
            self.lessons.sets.push((self.known.bits(parts), bound));
        }
        self.lessons.lines.extend(line);
    }
}

//! Nodes of the search for trees of depth 2: a region of root lines with the bounds of both children.
//!
//! Let L, R, O be the samples that the region sends left, sends right, leaves open. Every root line of the region parts
//! them as L + O1, R + O2, and with STUMP the best cost of a child:
//!
//! * dropping samples lowers no optimum: cost >= STUMP(L) + STUMP(R), and open samples of a class that no leaf names
//!   are wrong on top of it: minimised over the labels that the children may use;
//! * adding samples raises an optimum by at most what they can cost: cost >= STUMP(L + O) + STUMP(R + O) - most(O).
//!
//! Bounds of a child's intervals hold for all sets that contain the child's samples, so nodes inside the node inherit
//! them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::geometry::line::Line;
use crate::instance::Instance;
use crate::line_tree::LineTree;
use crate::loss::INFEASIBLE;
use crate::nodes::known::Lessons;
use crate::regions::dual_plane::DualPlane;
use crate::regions::region::Region;
use crate::regions::slope_interval::SlopeInterval;
use crate::switches::Switches;
use crate::weighted_samples::sum;
use octmip_check::problem::Problem;

/// The instance and the tables that all nodes of a search share.
#[derive(Debug)]
pub(crate) struct SearchContext<'a> {
    /// The problem.
    pub(crate) problem: &'a Problem,
    /// Coordinates, labels, costs.
    pub(crate) instance: &'a Instance,
    /// Most slope intervals of a dual plane.
    pub(crate) n_intervals: usize,
    /// Tables of the dual planes.
    pub(crate) dual_planes: Vec<DualPlane>,
    /// All samples.
    pub(crate) all: Vec<u32>,
    /// Set when the search has to stop; what is computed after that is worthless.
    pub(crate) stop: &'a AtomicBool,
}

impl<'a> SearchContext<'a> {
    /// The tables of all dual planes with at most so many intervals; None when the search has to stop before all are
    /// made, as a bound over some of them is no bound over all trees.
    pub(crate) fn new(
        problem: &'a Problem,
        instance: &'a Instance,
        n_intervals: usize,
        stop: &'a AtomicBool,
    ) -> Option<Self> {
        let tables = instance.dual_planes.iter().map(|&features| {
            let is_going = !stop.load(Ordering::Relaxed);
            is_going.then(|| DualPlane::new(&instance.plane, features, n_intervals))
        });
        Some(Self {
            problem,
            instance,
            n_intervals,
            dual_planes: tables.collect::<Option<_>>()?,
            all: instance.all(),
            stop,
        })
    }
}

/// Bounds and lines of one child of the root.
#[derive(Debug, Clone)]
pub(crate) struct Child {
    /// Lower bound of its cost, for its samples and more.
    pub(crate) floor: i64,
    /// Lower bound of its cost with all the open samples, and the most that these samples can cost.
    pub(crate) wide: (i64, i64),
    /// Splits that were best in the nodes around this one.
    pub(crate) lines: Vec<Line>,
    /// Slope intervals that may hold its split.
    pub(crate) intervals: Arc<Vec<SlopeInterval>>,
    /// In all other intervals a split costs this much or more.
    pub(crate) struck: i64,
    /// The samples that the gains of the intervals speak of, one bit each: they hold for all sets within.
    pub(crate) within: Arc<[u64]>,
}

impl Child {
    /// A child of which nothing is known but the intervals that may hold its split.
    pub(crate) fn new(intervals: Arc<Vec<SlopeInterval>>, n_samples: usize) -> Self {
        let within = vec![u64::MAX; n_samples.div_ceil(64)].into();
        Self { floor: 0, wide: (0, INFEASIBLE), lines: Vec::new(), intervals, struck: INFEASIBLE, within }
    }

    /// Keep a line, the youngest first.
    pub(crate) fn remember(&mut self, line: Option<Line>) {
        const KEPT: usize = 3;
        if let Some(line) = line.filter(|line| !self.lines.contains(line)) {
            self.lines.insert(0, line);
            self.lines.truncate(KEPT);
        }
    }

    /// The intervals below a bound, in which a split may cost less.
    pub(crate) fn intervals_below(&mut self, dead: i64) -> Vec<SlopeInterval> {
        let below: Vec<SlopeInterval> = self.intervals.iter().filter(|s| s.bound < dead).copied().collect();
        if below.len() < self.intervals.len() {
            self.struck = self.struck.min(dead);
        }
        below
    }

    /// Leave out the intervals that cannot hold the child's split in a tree of interest, here and in every node inside.
    ///
    /// An interval's bound holds for the child's settled samples, hence for whatever the child holds beside them. Where
    /// it is `dead` or more, the bound of the other child makes up the rest: a tree of this node whose split lies in
    /// the interval is of no interest, and so is one of a node inside. What remains to be bounded are trees without
    /// such splits.
    pub(crate) fn keep_intervals_below(&mut self, intervals: Vec<SlopeInterval>, dead: i64, switches: Switches) {
        let dead = if switches.dead_intervals { dead } else { INFEASIBLE };
        let alive = intervals.iter().filter(|interval| interval.bound < dead).count();
        // A copy costs memory; it pays when it says something new.
        if alive < intervals.len() {
            self.struck = self.struck.min(dead);
        }
        if alive < self.intervals.len() || *self.intervals != intervals {
            self.intervals = Arc::new(intervals.into_iter().filter(|s| s.bound < dead).collect());
        }
    }
}

/// A region of root lines, and a bound of the trees with such a root.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    /// Index of the root's dual plane.
    pub(crate) dual_plane: u32,
    /// The root lines.
    pub(crate) region: Region,
    /// No tree with such a root costs less.
    pub(crate) key: i64,
    /// Bounds and lines of the children, left and right.
    pub(crate) children: [Child; 2],
    /// Open samples when gains were last learnt.
    pub(crate) n_learnt: usize,
}

/// The aim of a bound.
#[derive(Clone, Copy)]
pub(crate) struct Goal {
    /// A bound of this much is enough for now.
    pub(crate) target: i64,
    /// Trees of this much and more are of no interest.
    pub(crate) upper: i64,
}

/// The result of processing a node.
#[derive(Debug, Default)]
pub(crate) struct Processed {
    /// The node itself, its bound at or beyond the target; or its two halves.
    pub(crate) nodes: Vec<Node>,
    /// A tree better than the incumbent.
    pub(crate) found: Option<(i64, LineTree)>,
    /// Least bound of what rounding leaves numerically undecided.
    pub(crate) undecided: Option<i64>,
    /// For the nodes of later batches.
    pub(crate) lessons: Lessons,
}

/// The samples left of all lines of a region, right of all of them, and between.
pub(crate) struct Partition {
    pub(crate) sides: [Vec<u32>; 2],
    pub(crate) open: Vec<u32>,
    pub(crate) tallies: [Vec<i64>; 2],
    pub(crate) open_tally: Vec<i64>,
    pub(crate) open_most: i64,
    /// Each side with the open samples.
    pub(crate) wide: [Vec<u32>; 2],
    pub(crate) wide_tallies: [Vec<i64>; 2],
}

impl Partition {
    /// Both sides with the open points that a dichotomy sends there.
    pub(crate) fn with(&self, points: &[Vec<u32>], dichotomy: &[bool]) -> [Vec<u32>; 2] {
        [true, false].map(|wanted| {
            let mut side = self.sides[usize::from(!wanted)].clone();
            let chosen = points.iter().zip(dichotomy).filter(|(_, goes_left)| **goes_left == wanted);
            chosen.for_each(|(point, _)| side.extend(point));
            side
        })
    }
}

impl SearchContext<'_> {
    /// The partition of all samples by a region.
    pub(crate) fn partition(&self, (f, g): (usize, usize), region: &Region) -> Partition {
        let (x, y) = (self.instance.plane.column(f), self.instance.plane.column(g));
        let (mut left, mut right) = (Vec::new(), Vec::new());
        let open = region.sort(x, y, &self.all, |i, goes_left| {
            if goes_left { &mut left } else { &mut right }.push(i);
        });
        self.counted([left, right], open)
    }

    /// The samples of a node that are settled on either side, and those that are open, with their weights.
    pub(crate) fn counted(&self, sides: [Vec<u32>; 2], open: Vec<u32>) -> Partition {
        let samples = self.instance.samples();
        let open_tally = samples.tally(&open);
        let tallies = [0, 1].map(|s| samples.tally(&sides[s]));
        Partition {
            wide: [0, 1].map(|s| [&sides[s][..], &open].concat()),
            wide_tallies: [0, 1].map(|s| sum(&tallies[s], &open_tally)),
            tallies,
            sides,
            open_most: samples.loss.most(&open_tally),
            open,
            open_tally,
        }
    }

    /// Fewest samples in a leaf.
    pub(crate) fn need(&self) -> i64 {
        self.instance.loss.leaf_size as i64
    }

    /// Whether one side has too few samples for a leaf, even with the open ones.
    pub(crate) fn is_infeasible(&self, partition: &Partition) -> bool {
        let open = partition.open.len();
        let least = self.instance.loss.leaf_size;
        partition.sides.iter().any(|side| side.len() + open < least)
    }

    /// Price of the root split.
    pub(crate) fn price(&self, root: &Node) -> i64 {
        let features = self.dual_planes[root.dual_plane as usize].features;
        self.instance.samples().price(features)
    }
}

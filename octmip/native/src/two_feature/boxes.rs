//! Trees of depth 2: a box is a cell of root lines with what is known of both children; bound it, close it or split it.
//!
//! Let L, R, O be the samples that the cell sends left, sends right, leaves open. Every root line of the cell parts them as
//! L + O1, R + O2, and with STUMP the best cost of a child:
//!
//! * dropping samples lowers no optimum: cost >= STUMP(L) + STUMP(R), and open samples of a class that no leaf names are
//!   wrong on top of it: minimised over the labels that the children may use;
//! * adding samples raises an optimum by at most what they can cost: cost >= STUMP(L + O) + STUMP(R + O) - most(O).
//!
//! Bounds of a child's strips hold for all sets that contain the child's samples, so boxes inside the box inherit them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::problem::Problem;

use super::cell::Cell;
use super::chart::Chart;
use super::ends::{End, end_of};
use super::extract::Sketch;
use super::ground::Ground;
use super::known::{Known, Lessons, Notes};
use super::loss::INFEASIBLE;
use super::realise::{Asked, Realised, THICK, realise};
use super::refine::split;
use super::strips::Strip;
use super::stump::{Answer, Question};
use super::switches::Switches;
use super::view::Line;

/// What all boxes of a search share.
#[derive(Debug)]
pub struct Field<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Coordinates, labels, costs.
    pub ground: &'a Ground,
    /// Tables of the charts.
    pub charts: Vec<Chart>,
    /// All samples.
    pub all: Vec<u32>,
    /// Set when the search has to stop; what is computed after that is worthless.
    pub stop: &'a AtomicBool,
}

/// What is known of one child of the root.
#[derive(Debug, Clone)]
pub struct Child {
    /// Lower bound of its cost, for its samples and more.
    pub(super) floor: i64,
    /// Lower bound of its cost with all the open samples, and the most that these samples can cost.
    pub(super) wide: (i64, i64),
    /// Splits that were best in the boxes around this one.
    pub(super) lines: Vec<Line>,
    /// Strips that may hold its split.
    pub(super) strips: Arc<Vec<Strip>>,
    /// In all other strips a split costs this much or more.
    pub(super) struck: i64,
}

impl Child {
    /// Nothing known but where the split may lie.
    pub fn new(strips: Arc<Vec<Strip>>) -> Self {
        Self { floor: 0, wide: (0, INFEASIBLE), lines: Vec::new(), strips, struck: INFEASIBLE }
    }

    pub(super) fn remember(&mut self, line: Option<Line>) {
        const KEPT: usize = 3;
        if let Some(line) = line.filter(|line| !self.lines.contains(line)) {
            self.lines.insert(0, line);
            self.lines.truncate(KEPT);
        }
    }

    /// Leave out the strips that cannot hold the child's split in a tree of interest, here and in every box inside.
    ///
    /// A strip's bound holds for the child's settled samples, hence for whatever the child holds beside them. Where it is
    /// `dead` or more, the bound of the other child makes up the rest: a tree of this box whose split lies in the strip
    /// is of no interest, and so is one of a box inside. What remains to be bounded are trees without such splits.
    pub(super) fn keep_strips_below(&mut self, strips: Vec<Strip>, dead: i64, switches: Switches) {
        let dead = if switches.dead_strips { dead } else { INFEASIBLE };
        let alive = strips.iter().filter(|strip| strip.bound < dead).count();
        // A copy costs memory; it pays when it says something new.
        if alive < strips.len() {
            self.struck = self.struck.min(dead);
        }
        if alive < self.strips.len() || *self.strips != strips {
            self.strips = Arc::new(strips.into_iter().filter(|s| s.bound < dead).collect());
        }
    }
}

/// A cell of root lines.
#[derive(Debug, Clone)]
pub struct RootBox {
    /// Index of the root's chart.
    pub chart: u32,
    /// The root lines.
    pub cell: Cell,
    /// No tree with such a root costs less.
    pub key: i64,
    /// What is known of the children, left and right.
    pub children: [Child; 2],
}

/// What a bound is computed for.
#[derive(Clone, Copy)]
pub(super) struct Goal {
    /// A bound of this much is enough for now.
    pub(super) target: i64,
    /// Trees of this much and more are of no interest.
    pub(super) upper: i64,
}

/// What became of a box.
#[derive(Debug, Default)]
pub struct Processed {
    /// The box itself, its bound at or beyond the target; or its two halves.
    pub boxes: Vec<RootBox>,
    /// A tree better than the incumbent.
    pub found: Option<(i64, Sketch)>,
    /// Least bound of what rounding leaves undecided.
    pub thin: Option<i64>,
    /// For the boxes of later batches.
    pub lessons: Lessons,
}

/// The samples of a box.
pub(super) struct Sorted {
    pub(super) sides: [Vec<u32>; 2],
    pub(super) open: Vec<u32>,
    pub(super) tallies: [Vec<i64>; 2],
    pub(super) open_tally: Vec<i64>,
    pub(super) open_most: i64,
    /// Each side with the open samples.
    pub(super) wide: [Vec<u32>; 2],
    pub(super) wide_tallies: [Vec<i64>; 2],
}

impl Field<'_> {
    /// Bound a box until `target`, split it if that fails; trees of `upper` and more are of no interest.
    pub fn process(&self, mut root: RootBox, target: i64, upper: i64, known: &Known) -> Processed {
        let features = self.charts[root.chart as usize].features;
        let sorted = self.sort(features, &root.cell);
        let (mut done, mut notes) = (Processed::default(), Notes::new(known));
        if self.is_infeasible(&sorted) {
            return done;
        }
        self.try_center(&root, &sorted, upper, &mut done);
        let upper = done.found.as_ref().map_or(upper, |(cost, _)| *cost);
        let goal = Goal { target: target.min(upper), upper };
        self.bound(&mut root, &sorted, goal, &mut notes);
        if root.key >= goal.target {
            done.lessons = notes.lessons;
            if root.key < upper {
                done.boxes.push(root);
            }
            return done;
        }
        let plane = &self.ground.plane;
        let end = end_of(plane, features, &root.cell, &sorted.open);
        if let End::Parts { points, ways } = &end {
            self.close(&mut root, &sorted, (points, ways), upper, &mut done, &mut notes);
            done.lessons = notes.lessons;
            return done;
        }
        done.lessons = notes.lessons;
        if end == End::Stuck {
            done.thin = Some(root.key);
            return done;
        }
        let chart = &self.charts[root.chart as usize];
        let at = chart.middle_boundary(root.cell.t0, root.cell.t1);
        for cell in split(plane, features, &root.cell, &sorted.open, at) {
            done.boxes.push(RootBox { cell, ..root.clone() });
        }
        done
    }

    pub(super) fn sort(&self, (f, g): (usize, usize), cell: &Cell) -> Sorted {
        let (x, y) = (self.ground.plane.column(f), self.ground.plane.column(g));
        let (mut left, mut right) = (Vec::new(), Vec::new());
        let open = cell.sort(x, y, &self.all, |i, goes_left| {
            if goes_left { &mut left } else { &mut right }.push(i);
        });
        self.counted([left, right], open)
    }

    /// The samples of a box that are settled on either side, and those that are open, with their weights.
    pub(super) fn counted(&self, sides: [Vec<u32>; 2], open: Vec<u32>) -> Sorted {
        let view = self.ground.view();
        let open_tally = view.tally(&open);
        let tallies = [0, 1].map(|s| view.tally(&sides[s]));
        Sorted {
            wide: [0, 1].map(|s| [&sides[s][..], &open].concat()),
            wide_tallies: [0, 1].map(|s| sum(&tallies[s], &open_tally)),
            tallies,
            sides,
            open_most: view.loss.most(&open_tally),
            open,
            open_tally,
        }
    }

    pub(super) fn need(&self) -> i64 {
        self.ground.loss.leaf_size as i64
    }

    pub(super) fn is_infeasible(&self, sorted: &Sorted) -> bool {
        let open = sorted.open.len();
        let least = self.ground.loss.leaf_size;
        sorted.sides.iter().any(|side| side.len() + open < least)
    }

    pub(super) fn price(&self, root: &RootBox) -> i64 {
        let features = self.charts[root.chart as usize].features;
        self.ground.view().price(features)
    }

    /// See what the root line in the middle of the cell costs with the children's remembered splits.
    fn try_center(&self, root: &RootBox, sorted: &Sorted, upper: i64, done: &mut Processed) {
        let features = self.charts[root.chart as usize].features;
        let (t, r) = root.cell.center();
        let line = Line { features, t, r };
        let mut sides = sorted.sides.clone();
        for &i in &sorted.open {
            sides[usize::from(!line.sends_left(&self.ground.plane, i))].push(i);
        }
        let is_one_sided = sides.iter().any(Vec::is_empty);
        if is_one_sided || !line.is_clear_of(&self.ground.plane, &sorted.open) {
            return;
        }
        let view = self.ground.view();
        let best = [0, 1]
            .map(|s| self.attained(root.children[s].lines.iter(), &sides[s], &view.tally(&sides[s]), self.need()));
        let cost = best[0].0 + best[1].0 + self.price(root);
        if cost < upper {
            let children = best.map(|(_, line)| Sketch::stump(line));
            done.found = Some((cost, Sketch::Split(line, Box::new(children))));
        }
    }

    /// Solve every way in which a root line of the cell can part its open points.
    fn close(
        &self,
        root: &mut RootBox,
        sorted: &Sorted,
        (points, ways): (&[Vec<u32>], &[Vec<bool>]),
        mut upper: i64,
        done: &mut Processed,
        notes: &mut Notes<'_>,
    ) {
        let features = self.charts[root.chart as usize].features;
        let plane = &self.ground.plane;
        for way in ways {
            if self.stop.load(Ordering::Relaxed) {
                return;
            }
            let chosen = |wanted: bool| points.iter().zip(way).filter(move |(_, w)| **w == wanted);
            let first = |wanted| chosen(wanted).map(|(p, _)| p[0]).collect::<Vec<u32>>();
            let (distance, ..) = root.cell.clearest(plane, features, &first(true), &first(false));
            // No line of the cell leaves room for it; where one outside does, its own cell looks at it.
            if distance < -THICK && self.ground.switches.room {
                continue;
            }
            let sides = [true, false].map(|wanted| {
                let mut side = sorted.sides[usize::from(!wanted)].clone();
                chosen(wanted).for_each(|(point, _)| side.extend(point));
                side
            });
            let Some((lower, answers)) = self.solve_sides(root, &sides, upper, notes) else {
                continue;
            };
            let attained = answers[0].attained + answers[1].attained + self.price(root);
            match realise(plane, features, &root.cell, &self.all, (points, way), &mut Asked::new()) {
                Realised::Never => continue,
                Realised::Line(line) if attained < upper => {
                    let children = answers.map(|answer| Sketch::stump(answer.line));
                    done.found = Some((attained, Sketch::Split(line, Box::new(children))));
                    upper = attained;
                }
                _ => {}
            }
            if lower < upper {
                done.thin = Some(done.thin.map_or(lower, |thin| thin.min(lower)));
            }
        }
    }

    /// Solve both children of a fixed root; None if the tree is not below `upper`.
    fn solve_sides(
        &self,
        root: &mut RootBox,
        sides: &[Vec<u32>; 2],
        upper: i64,
        notes: &mut Notes<'_>,
    ) -> Option<(i64, [Answer; 2])> {
        let (floors, answers) = self.side_bounds(root, sides, upper, notes);
        let lower = floors[0] + floors[1] + self.price(root);
        match answers {
            [Some(left), Some(right)] if lower < upper => Some((lower, [left, right])),
            _ => None,
        }
    }

    /// Bounds of both children of a fixed root until the tree reaches `upper`, and the answers that gave them.
    pub(super) fn side_bounds(
        &self,
        root: &mut RootBox,
        sides: &[Vec<u32>; 2],
        upper: i64,
        notes: &mut Notes<'_>,
    ) -> ([i64; 2], [Option<Answer>; 2]) {
        let price = self.price(root);
        let mut floors = [0, 1].map(|s| {
            let tally = self.ground.view().tally(&sides[s]);
            root.children[s].floor.max(self.two_labels(&tally)).max(notes.at_least([&sides[s], &[]]))
        });
        let mut answers = [None, None];
        // The larger side first: it reaches its cutoff more often.
        let first = usize::from(sides[1].len() > sides[0].len());
        for s in [first, 1 - first] {
            if floors[0] + floors[1] + price >= upper {
                break;
            }
            let cutoff = upper - price - floors[1 - s];
            let question = Question {
                ids: &sides[s],
                need: self.need(),
                cutoff,
                floor: floors[s],
                most_tried: usize::MAX,
                hopeless: 0,
                dead: cutoff,
                less: 0,
            };
            let mut strips = root.children[s].strips.to_vec();
            let answer = self.ask(&root.children[s], question, &mut strips);
            root.children[s].remember(answer.line);
            notes.add([&sides[s], &[]], answer.lower.min(root.children[s].struck), answer.line);
            floors[s] = answer.lower;
            answers[s] = Some(answer);
        }
        (floors, answers)
    }
}

fn sum(a: &[i64], b: &[i64]) -> Vec<i64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

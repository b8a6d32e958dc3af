//! The proof log: the search once more, its budget at the claim, writing down how every box of roots was closed.
//!
//! The format is docs/theory/two-feature.md's; `octmip_check::lines` reads it and knows nothing of what stands here. What is
//! written are true statements about all lines: no strip is struck off on this side (`dead_strips` off), the checker
//! strikes off by itself. It counts all stumps again; only boxes, bounds and ways of parting are handed over.
//!
//! A statement is about a set of samples, so both sides must mean the same one: samples are settled here by the checker's
//! own cells and coordinates, and the ways to part the open ones are those that it will go through.

use std::fmt::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use octmip_check::lines::{self as check_lines, MOST, Points};

use crate::log::Body;
use crate::problem::Problem;

use super::boxes::{Child, Field, Goal, RootBox, Sorted};
use super::chart::Chart;
use super::ends::{End, end_of};
use super::ground::Ground;
use super::known::{Known, Notes};
use super::pair::strips_of;
use super::refine::split;
use super::strips::Strip;

/// Strips of a chart.
const STRIPS: usize = 64;
/// Sets of sensors that are proven one by one.
const MOST_SETS: usize = 20_000;

/// A proof that every tree of a problem costs `claim` or more: None if stopped, or if rounding leaves it open.
struct Writer<'a> {
    problem: &'a Problem,
    claim: i64,
    n_threads: usize,
    stop: &'a AtomicBool,
    n_sets: usize,
    points: Points,
}

/// The body of a log that proves `claim`, None if it was stopped, there are too many sets of sensors, or the claim cannot
/// be shown with room for rounding.
pub fn write(problem: &Problem, claim: i64, n_threads: usize, stop: &AtomicBool) -> Option<String> {
    let mut writer = Writer { problem, claim, n_threads, stop, n_sets: 0, points: Points::new(problem) };
    let mut body = Body::default();
    writer.sensors(&mut vec![None; problem.sensor_cost.len()], &mut body)?;
    Some(body.into_lines())
}

impl Writer<'_> {
    /// Decide sensors until those that may be read can be paid for together, or as many of them as a tree can read.
    fn sensors(&mut self, read: &mut Vec<Option<bool>>, body: &mut Body) -> Option<()> {
        let q = self.problem;
        let most_read = 2 * ((1 << q.depth) - 1);
        let taken: Vec<usize> = (0..read.len()).filter(|&s| read[s] == Some(true)).collect();
        let paid: f64 = taken.iter().map(|&s| q.sensor_cost[s]).sum();
        let is_within = |s: usize| (paid + q.sensor_cost[s]) * (1.0 - 1e-12) <= q.sensor_limit;
        let room = most_read.max(taken.len()) - taken.len();
        // A sensor of no allowed feature is nothing to decide: its case would have no chart and leave no line in the log.
        let is_used =
            |s: usize| (0..q.p).any(|f| q.sensor_of_feature[f] as usize == s && super::ground::is_allowed(q, f, q.p));
        let is_open = |s: usize| read[s].is_none() && room > 0 && is_within(s) && is_used(s);
        let mut dearest: Vec<f64> = (0..read.len()).filter(|&s| is_open(s)).map(|s| q.sensor_cost[s]).collect();
        dearest.sort_unstable_by(|a, b| b.total_cmp(a));
        let all_paid = paid + dearest.iter().take(room).sum::<f64>();
        if let Some(sensor) = (0..read.len()).find(|&s| all_paid > q.sensor_limit && is_open(s)) {
            body.decide(sensor);
            for choice in [false, true] {
                read[sensor] = Some(choice);
                self.sensors(read, body)?;
            }
            read[sensor] = None;
            return Some(());
        }
        self.n_sets += 1;
        let may_read = |f: usize| {
            let s = q.sensor_of_feature[f] as usize;
            read[s] == Some(true) || is_open(s)
        };
        let mut ground = Ground::new(q);
        ground.switches.dead_strips = false;
        // The checker knows one box at a time: what it can count easily is what is best for the one box.
        let switches = &mut ground.switches;
        (switches.spared, switches.known_sets, switches.known_lines) = (false, false, false);
        ground.charts.clear();
        for f in 0..q.p {
            let seconds = (0..=q.p).filter(|&g| g != f && (g == q.p || may_read(g)));
            let charts = seconds.map(|g| (f, g));
            let allowed = charts.filter(|&(f, g)| may_read(f) && super::ground::is_allowed(q, f, g));
            ground.charts.extend(allowed);
        }
        (self.n_sets <= MOST_SETS).then(|| self.charts(&ground, body))?
    }

    /// A section for every chart, or none but a title for trees of one split: the checker counts these by itself.
    fn charts(&self, ground: &Ground, body: &mut Body) -> Option<()> {
        if self.problem.depth == 1 {
            body.append("D\n");
            return Some(());
        }
        let charts = ground.charts.iter();
        let field = Field {
            problem: self.problem,
            ground,
            charts: charts
                .take_while(|_| !self.stop.load(Ordering::Relaxed))
                .map(|&features| Chart::new(&ground.plane, features, STRIPS))
                .collect(),
            all: ground.all(),
            stop: self.stop,
        };
        let strips = strips_of(&field, &vec![true; self.problem.p]);
        let sections: Vec<Mutex<Option<String>>> = field.charts.iter().map(|_| Mutex::default()).collect();
        let next = AtomicUsize::new(0);
        let work = || {
            let mut chart = next.fetch_add(1, Ordering::Relaxed);
            while chart < sections.len() && !self.stop.load(Ordering::Relaxed) {
                let child = Child::new(strips.clone());
                let root = RootBox {
                    chart: chart as u32,
                    cell: field.charts[chart].whole(),
                    key: 0,
                    children: [child.clone(), child],
                };
                let (f, g) = field.charts[chart].features;
                let known = Known::new(ground, 1);
                let (claim, points) = (self.claim, &self.points);
                let mut page = Page { claim, points, known, body: format!("C {f} {g}\n") };
                let whole = check_lines::Cell::whole(g == self.problem.p);
                let told = Told { floors: [0; 2], alive: [n_strips(strips.iter()); 2] };
                if field.prove(root, whole, told, &mut page).is_none() {
                    next.store(sections.len(), Ordering::Relaxed);
                } else if let Ok(mut slot) = sections[chart].lock() {
                    *slot = Some(page.body);
                }
                chart = next.fetch_add(1, Ordering::Relaxed);
            }
        };
        std::thread::scope(|scope| {
            (0..self.n_threads).for_each(|_| drop(scope.spawn(work)));
        });
        for section in sections {
            body.append(&section.into_inner().ok().flatten()?);
        }
        Some(())
    }
}

/// What the checker has been told of both children: their floors, and how many strips it had to keep.
#[derive(Clone, Copy)]
struct Told {
    floors: [i64; 2],
    alive: [usize; 2],
}

/// The proof of one chart as it is written.
struct Page<'a> {
    claim: i64,
    points: &'a Points,
    known: Known,
    body: String,
}

fn n_strips<'a>(strips: impl Iterator<Item = &'a Strip>) -> usize {
    strips.map(|strip| strip.n_strips as usize).sum()
}

impl Field<'_> {
    /// Write the proof that every tree with a root in a box costs `claim` or more.
    ///
    /// `place` is the box's cell as the checker cuts it.
    fn prove(&self, mut root: RootBox, place: check_lines::Cell, mut told: Told, page: &mut Page<'_>) -> Option<()> {
        let claim = page.claim;
        let features = self.charts[root.chart as usize].features;
        let [left, open, right] = page.points.sorted(features, &place);
        let sorted = self.counted([left, right], open);
        if self.is_infeasible(&sorted) {
            page.body.push_str("F\n");
            return Some(());
        }
        let goal = Goal { target: claim, upper: claim };
        root.key = 0;
        let mut notes = Notes::new(&page.known);
        self.bound(&mut root, &sorted, goal, &mut notes);
        let lessons = notes.lessons;
        page.known.learn(lessons);
        let owed = claim - self.price(&root);
        if self.write_bound(&root, &sorted, owed, &mut page.body) {
            return Some(());
        }
        let (plane, cell) = (&self.ground.plane, root.cell);
        let end = end_of(plane, features, &cell, &sorted.open);
        if end != End::Split
            && let Some(line) = self.ways_closed(&mut root, &place, &sorted, owed, page)
        {
            page.body.push_str(&line);
            return Some(());
        }
        if self.stop.load(Ordering::Relaxed) || !(cell.is_wide() || cell.is_high()) {
            return None;
        }
        self.tell(&root, &sorted, owed, &mut told, &mut page.body);
        let at = self.charts[root.chart as usize].middle_boundary(cell.t0, cell.t1);
        let halves = split(plane, features, &cell, &sorted.open, at);
        let places = if halves[0].t1 < cell.t1 {
            let _ = writeln!(page.body, "T {}", halves[0].t1);
            place.cut(halves[0].t1)
        } else {
            let _ = writeln!(page.body, "R {} {}", halves[0].u0, halves[0].u1);
            place.split([halves[0].u0, halves[0].u1])
        };
        for (cell, place) in halves.into_iter().zip(places) {
            let half = RootBox { cell, ..root.clone() };
            self.prove(half, place, told, page)?;
        }
        Some(())
    }

    /// Write the bound that closes a box, with children's costs no larger than it takes.
    fn write_bound(&self, root: &RootBox, sorted: &Sorted, owed: i64, body: &mut String) -> bool {
        let [left, right] = &root.children;
        if self.by_labels(sorted, [left.floor, right.floor]) >= owed {
            let a = self.least_to_reach(sorted, 0, right.floor, owed);
            let b = self.least_to_reach(sorted, 1, a, owed);
            let _ = writeln!(body, "N {a} {b}");
            return true;
        }
        // Samples that left the set since the bound was computed lowered it by no more than they can cost.
        let wide = [0, 1].map(|s| {
            let (bound, most) = root.children[s].wide;
            bound - (most - self.ground.loss.most(&sorted.wide_tallies[s]))
        });
        let excess = wide[0] + wide[1] - sorted.open_most - owed;
        if excess >= 0 {
            let a = wide[0] - excess.min(wide[0].max(0));
            let b = owed + sorted.open_most - a;
            let _ = writeln!(body, "W {} {}", a.max(0), b.max(0));
        }
        excess >= 0
    }

    /// Tell the checker what it may strike off in all boxes inside, where that is much.
    fn tell(&self, root: &RootBox, sorted: &Sorted, owed: i64, told: &mut Told, body: &mut String) {
        for s in [0, 1] {
            let dead = self.least_to_reach(sorted, s, told.floors[1 - s], owed);
            let strips = root.children[s].strips.iter();
            let alive = n_strips(strips.filter(|strip| strip.bound < dead));
            let floor = root.children[s].floor;
            let grown = self.by_labels(sorted, root.children.each_ref().map(|c| c.floor));
            let is_news = floor > told.floors[s] && floor > self.two_labels(&sorted.tallies[s]);
            if alive * 2 <= told.alive[s] || (is_news && grown * 2 > owed) {
                let tag = if s == 0 { 'l' } else { 'r' };
                let _ = writeln!(body, "{tag} {floor} {dead}");
                told.floors[s] = told.floors[s].max(floor);
                told.alive[s] = alive;
            }
        }
    }

    /// The line that closes a box by all ways of parting its open points, if they all cost enough.
    ///
    /// The ways are those that the checker will go through: all lines of the cell's range of t. One that costs less is left
    /// out where no line goes it.
    fn ways_closed(
        &self,
        root: &mut RootBox,
        place: &check_lines::Cell,
        sorted: &Sorted,
        owed: i64,
        page: &Page<'_>,
    ) -> Option<String> {
        let mut notes = Notes::new(&page.known);
        let plane = page.points.plane(self.charts[root.chart as usize].features);
        let points = plane.end_points(&sorted.open, MOST)?;
        let places = plane.places(&points, &sorted.open);
        let mut line = "E".to_string();
        for way in plane.ways(&points, place.t[0], place.t[1]) {
            let sides = [true, false].map(|wanted| {
                let mut side = sorted.sides[usize::from(!wanted)].clone();
                let chosen = sorted.open.iter().zip(&places).filter(|(_, place)| way[**place] == wanted);
                side.extend(chosen.map(|(i, _)| i));
                side
            });
            if sides.iter().any(|side| (side.len() as i64) < self.need()) {
                continue;
            }
            let costs = self.side_bounds(root, &sides, owed + self.price(root), &mut notes).0;
            if costs[0] + costs[1] < owed {
                if plane.can_part(&sides[0], &sides[1]) {
                    return None;
                }
                continue;
            }
            line.push(' ');
            line.extend(way.iter().map(|&left| if left { '1' } else { '0' }));
            let _ = write!(line, ":{}", costs[0].min(owed).max(0));
        }
        line.push('\n');
        Some(line)
    }
}

//! The proof log: the search once more, its budget at the claim, writing down the bound that closed every node.
//!
//! The format is docs/theory/two-feature.md's; `octmip_check::two_feature` reads it and knows nothing of the search.
//! It holds true statements about all lines: no interval is struck off on this side (`dead_intervals` off),
//! the checker strikes off by itself. It counts all stumps again; only nodes, bounds and dichotomies are handed over.
//!
//! A statement is about a set of samples, so both sides must mean the same one: samples are settled here by the
//! checker's own regions and coordinates, and the dichotomies of the open ones are those that it will go through.

use std::fmt::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use octmip_check::two_feature::{self as checked, MOST, Points};

use crate::depth_two::intervals_of;
use crate::instance::Instance;
use crate::nodes::known::{Known, Notes};
use crate::nodes::node::{Child, Goal, Node, Partition, SearchContext};
use crate::regions::dichotomies::{End, end_of};
use crate::regions::region::split;
use crate::regions::slope_interval::SlopeInterval;
use octmip_check::problem::Problem;
use octmip_frame::log::Body;

/// Slope intervals of a dual plane.
const INTERVALS: usize = 64;
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

/// The body of a log that proves `claim`, None if it was stopped, there are too many sets of sensors, or the claim
/// cannot be shown with room for rounding.
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
        // A sensor of no allowed feature is nothing to decide: its case would have no dual plane and leave no line in
        // the log.
        let is_used =
            |s: usize| (0..q.p).any(|f| q.sensor_of_feature[f] as usize == s && super::instance::is_allowed(q, f, q.p));
        let is_open = |s: usize| read[s].is_none() && room > 0 && is_within(s) && is_used(s);
        let mut highest: Vec<f64> = (0..read.len()).filter(|&s| is_open(s)).map(|s| q.sensor_cost[s]).collect();
        highest.sort_unstable_by(|a, b| b.total_cmp(a));
        let all_paid = paid + highest.iter().take(room).sum::<f64>();
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
        let mut instance = Instance::new(q);
        instance.switches.dead_intervals = false;
        // The checker knows one node at a time: what it can count easily is what is best for the one node.
        let switches = &mut instance.switches;
        (switches.spared, switches.known_sets, switches.known_lines, switches.gains) = (false, false, false, false);
        instance.dual_planes.clear();
        for f in 0..q.p {
            let seconds = (0..=q.p).filter(|&g| g != f && (g == q.p || may_read(g)));
            let dual_planes = seconds.map(|g| (f, g));
            let allowed = dual_planes.filter(|&(f, g)| may_read(f) && super::instance::is_allowed(q, f, g));
            instance.dual_planes.extend(allowed);
        }
        (self.n_sets <= MOST_SETS).then(|| self.dual_planes(&instance, body))?
    }

    /// A section for every dual plane, or none but a title for trees of one split: the checker counts these by itself.
    fn dual_planes(&self, instance: &Instance, body: &mut Body) -> Option<()> {
        if self.problem.depth == 1 {
            body.append("D\n");
            return Some(());
        }
        let context = SearchContext::new(self.problem, instance, INTERVALS, self.stop)?;
        let intervals = intervals_of(&context, &vec![true; self.problem.p]);
        let sections: Vec<Mutex<Option<String>>> = context.dual_planes.iter().map(|_| Mutex::default()).collect();
        let next = AtomicUsize::new(0);
        let work = || {
            let mut dual_plane = next.fetch_add(1, Ordering::Relaxed);
            while dual_plane < sections.len() && !self.stop.load(Ordering::Relaxed) {
                let child = Child::new(intervals.clone(), self.problem.n);
                let root = Node {
                    dual_plane: dual_plane as u32,
                    region: context.dual_planes[dual_plane].whole(),
                    key: 0,
                    children: [child.clone(), child],
                    n_learnt: 0,
                };
                let (f, g) = context.dual_planes[dual_plane].features;
                let known = Known::new(instance, 1);
                let (claim, points) = (self.claim, &self.points);
                let mut page = Page { claim, points, known, body: format!("C {f} {g}\n") };
                let whole = checked::Region::whole(g == self.problem.p);
                let stated = Stated { floors: [0; 2], alive: [n_intervals(intervals.iter()); 2] };
                if context.prove(root, whole, stated, &mut page).is_none() {
                    next.store(sections.len(), Ordering::Relaxed);
                } else if let Ok(mut slot) = sections[dual_plane].lock() {
                    *slot = Some(page.body);
                }
                dual_plane = next.fetch_add(1, Ordering::Relaxed);
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

/// The statements made of both children so far: their floors, and the number of intervals that the checker had to keep.
#[derive(Clone, Copy)]
struct Stated {
    floors: [i64; 2],
    alive: [usize; 2],
}

/// The proof of one dual plane as it is written.
struct Page<'a> {
    claim: i64,
    points: &'a Points,
    known: Known,
    body: String,
}

fn n_intervals<'a>(intervals: impl Iterator<Item = &'a SlopeInterval>) -> usize {
    intervals.map(|interval| interval.n_intervals as usize).sum()
}

impl SearchContext<'_> {
    /// Write the proof that every tree with a root in a node costs `claim` or more.
    ///
    /// `place` is the node's region as the checker cuts it.
    fn prove(&self, mut root: Node, place: checked::Region, mut stated: Stated, page: &mut Page<'_>) -> Option<()> {
        let claim = page.claim;
        let features = self.dual_planes[root.dual_plane as usize].features;
        let [left, open, right] = page.points.sorted(features, &place);
        let partition = self.counted([left, right], open);
        if self.is_infeasible(&partition) {
            page.body.push_str("F\n");
            return Some(());
        }
        let goal = Goal { target: claim, upper: claim };
        root.key = 0;
        let mut notes = Notes::new(&page.known);
        self.bound(&mut root, &partition, goal, &mut notes);
        let lessons = notes.lessons;
        page.known.learn(lessons);
        let owed = claim - self.price(&root);
        if self.write_bound(&root, &partition, owed, &mut page.body) {
            return Some(());
        }
        let (plane, region) = (&self.instance.plane, root.region);
        let end = end_of(plane, features, &region, &partition.open);
        if end != End::Split
            && let Some(line) = self.closing_dichotomies(&mut root, &place, &partition, owed, page)
        {
            page.body.push_str(&line);
            return Some(());
        }
        if self.stop.load(Ordering::Relaxed) || !(region.is_wide() || region.is_high()) {
            return None;
        }
        self.write_statements(&root, &partition, owed, &mut stated, &mut page.body);
        let at = self.dual_planes[root.dual_plane as usize].middle_boundary(region.t0, region.t1);
        let halves = split(plane, features, &region, &partition.open, at);
        let places = if halves[0].t1 < region.t1 {
            let _ = writeln!(page.body, "T {}", halves[0].t1);
            place.cut(halves[0].t1)
        } else {
            let _ = writeln!(page.body, "R {} {}", halves[0].u0, halves[0].u1);
            place.split([halves[0].u0, halves[0].u1])
        };
        for (region, place) in halves.into_iter().zip(places) {
            let half = Node { region, ..root.clone() };
            self.prove(half, place, stated, page)?;
        }
        Some(())
    }

    /// Write the bound that closes a node, with children's costs no larger than it takes.
    fn write_bound(&self, root: &Node, partition: &Partition, owed: i64, body: &mut String) -> bool {
        let [left, right] = &root.children;
        if self.by_label_count(partition, [left.floor, right.floor]) >= owed {
            let a = self.least_to_reach(partition, 0, right.floor, owed);
            let b = self.least_to_reach(partition, 1, a, owed);
            let _ = writeln!(body, "N {a} {b}");
            return true;
        }
        // Samples that left the set since the bound was computed lowered it by no more than they can cost.
        let wide = [0, 1].map(|s| {
            let (bound, most) = root.children[s].wide;
            bound - (most - self.instance.loss.most(&partition.wide_tallies[s]))
        });
        let excess = wide[0] + wide[1] - partition.open_most - owed;
        if excess >= 0 {
            let a = wide[0] - excess.min(wide[0].max(0));
            let b = owed + partition.open_most - a;
            let _ = writeln!(body, "W {} {}", a.max(0), b.max(0));
        }
        excess >= 0
    }

    /// Write a statement by which the checker strikes off intervals in all nodes inside, where these are many.
    fn write_statements(&self, root: &Node, partition: &Partition, owed: i64, stated: &mut Stated, body: &mut String) {
        for s in [0, 1] {
            let dead = self.least_to_reach(partition, s, stated.floors[1 - s], owed);
            let intervals = root.children[s].intervals.iter();
            let alive = n_intervals(intervals.filter(|interval| interval.bound < dead));
            let floor = root.children[s].floor;
            let grown = self.by_label_count(partition, root.children.each_ref().map(|c| c.floor));
            let is_news = floor > stated.floors[s] && floor > self.two_labels(&partition.tallies[s]);
            if alive * 2 <= stated.alive[s] || (is_news && grown * 2 > owed) {
                let tag = if s == 0 { 'l' } else { 'r' };
                let _ = writeln!(body, "{tag} {floor} {dead}");
                stated.floors[s] = stated.floors[s].max(floor);
                stated.alive[s] = alive;
            }
        }
    }

    /// The line that closes a node by all dichotomies of its open points, if they all cost enough.
    ///
    /// The dichotomies are those that the checker will go through: all lines of the region's range of t. One that costs
    /// less is left out where no line makes it.
    fn closing_dichotomies(
        &self,
        root: &mut Node,
        place: &checked::Region,
        partition: &Partition,
        owed: i64,
        page: &Page<'_>,
    ) -> Option<String> {
        let mut notes = Notes::new(&page.known);
        let plane = page.points.plane(self.dual_planes[root.dual_plane as usize].features);
        let points = plane.end_points(&partition.open, MOST)?;
        let places = plane.places(&points, &partition.open);
        let mut line = "E".to_string();
        for dichotomy in plane.dichotomies(&points, place.t[0], place.t[1]) {
            let sides = [true, false].map(|wanted| {
                let mut side = partition.sides[usize::from(!wanted)].clone();
                let chosen = partition.open.iter().zip(&places).filter(|(_, place)| dichotomy[**place] == wanted);
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
            line.extend(dichotomy.iter().map(|&left| if left { '1' } else { '0' }));
            let _ = write!(line, ":{}", costs[0].min(owed).max(0));
        }
        line.push('\n');
        Some(line)
    }
}

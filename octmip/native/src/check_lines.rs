//! The checker of proof logs of two-feature trees: does a log prove that no tree costs less than it claims?
//!
//! It knows no solver. Format and proofs: docs/theory/oblique.md. A line `x + t y = r` over two features is a point (t, r);
//! a sample is the straight line r = x + t y and goes left where that runs below the point. Coordinates are wrong by 2^-53
//! at most and within -1 and 1, t within -1 and 1 (the features exchanged give the steeper lines), so a value x + t y is
//! wrong by less than 2^-50: what is 2^-46 clear of an edge at both ends of a range of t is clear of it. Where that does
//! not settle a sample, signs of sums of products of the values as given do, exactly.

macro_rules! ensure {
    ($is_so:expr, $line:expr, $($reason:tt)*) => {
        if !$is_so { return Err(Refusal($line, format!($($reason)*))); }
    };
}

mod counts;
mod parting;
mod points;
mod sections;
mod signs;
mod stumps;

use std::collections::HashMap;
use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use crate::check::Refusal;
use crate::problem::Problem;
pub(crate) use points::Points;
use sections::Section;
pub(crate) use signs::exact_sign;

/// Room for rounding.
const EPS: f64 = 1.0 / (1u64 << 46) as f64;
/// Bands narrower than this are not split.
const TINY: f64 = 1.0 / (1u64 << 39) as f64;
/// So many different points are tried in every way before a cell is split, and at the end of splitting (any number there
/// if they are all on one line).
const FEW: usize = 6;
pub(crate) const MOST: usize = 48;
const BINS: usize = 64;
/// Boxes in boxes; a search needs some 300 at most: t is halved 35 times, heights lose an eighth at least.
const MOST_CUTS: usize = 1000;
const STACK_BYTES: usize = 1 << 26;
const NO_TREE: i64 = i64::MAX / 4;

/// Class weights of some samples, and last their number.
type Tally = Vec<i64>;
/// Features and a range of t: where a child's line may lie.
type Strip = ((usize, usize), f64, f64);

/// Lines between two straight edges over a range of t, each edge given by its ends.
#[derive(Clone, Copy)]
pub(crate) struct Cell {
    pub(crate) t: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
}

/// A child of all roots of a box: what it costs at least, and the strips where its line must be, lest the tree cost the
/// claim anyway.
#[derive(Clone)]
struct Child {
    floor: i64,
    strips: Arc<Vec<Strip>>,
}

struct Checker<'a> {
    q: &'a Problem,
    points: Points,
    /// For two answers and a class, what the cheaper answer costs.
    cheaper: Vec<i64>,
    claim: i64,
    lines: Vec<&'a str>,
}

/// Check that a log proves, after `skip` lines, that every tree costs `claim` or more.
pub fn check(q: &Problem, log: &str, skip: usize, claim: i64, threads: usize) -> Result<(), Refusal> {
    let checker = Checker { q, points: Points::new(q), cheaper: cheaper(q), claim, lines: log.lines().collect() };
    let (mut line, mut tasks) = (skip, Vec::new());
    ensure!((0..=NO_TREE).contains(&claim), skip, "expected a claim from 0 to {NO_TREE}, got {claim}");
    ensure!(checker.leaf(&checker.tally(&checker.all())) >= claim, skip, "one leaf costs less than {claim}");
    checker.sensors(&mut line, &mut vec![None; q.sensor_cost.len()], &mut tasks)?;
    let end = checker.lines.get(line).copied();
    ensure!(end == Some("end") && line + 1 == checker.lines.len(), line + 1, "expected end, got {end:?}");
    let (next, refusals) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, tasks.len().max(1)) {
            let work = || {
                while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let (Err(refusal), Ok(mut found)) = (checker.section(task), refusals.lock()) {
                        found.push((refusal.0, refusal));
                        next.store(tasks.len(), Ordering::Relaxed);
                    }
                }
            };
            let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work);
            if let (Err(error), Ok(mut found)) = (thread, refusals.lock()) {
                found.push((skip, Refusal(skip, format!("no thread to check on ({error})"))));
            }
        }
    });
    let found = refusals.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    found.into_iter().min_by_key(|refusal| refusal.0).map_or(Ok(()), |refusal| Err(refusal.1))
}

fn cheaper(q: &Problem) -> Vec<i64> {
    let k = q.n_classes;
    let pairs = (0..k).flat_map(|a| (0..k).map(move |b| (a, b)));
    pairs.flat_map(|(a, b)| (0..k).map(move |c| q.cost(c, a).min(q.cost(c, b)))).collect()
}

/// So many numbers, one blank between them.
fn parse<T: FromStr + Copy, const N: usize>(text: &str, line: usize) -> Result<[T; N], Refusal> {
    let numbers: Option<Vec<T>> = text.split(' ').map(|word| word.parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| Refusal(line, format!("expected {N} numbers, got {text:?}")))
}

impl Checker<'_> {
    fn all(&self) -> Vec<u32> {
        (0..self.q.n as u32).collect()
    }

    fn section(&self, section: &Section) -> Result<(), Refusal> {
        let (mut line, all, need) = (section.lines.start, self.all(), self.q.leaf_size as i64);
        if let Some(chart) = section.chart {
            let whole = Cell::whole(chart.1 == self.q.p);
            let child = Child { floor: 0, strips: section.strips.clone() };
            self.root(chart, whole, [child.clone(), child], &mut line, (section.lines.end, MOST_CUTS))?;
        } else {
            let is_so = self.child_costs(&all, need, &section.strips, self.claim);
            ensure!(is_so, line, "a single split is not proven to cost {}", self.claim);
        }
        ensure!(line == section.lines.end, line + 1, "expected the next chart or end");
        Ok(())
    }

    /// Read the proof for the roots of a cell and check it.
    fn root(
        &self,
        chart: (usize, usize),
        cell: Cell,
        mut children: [Child; 2],
        at: &mut usize,
        (end, n_cuts): (usize, usize),
    ) -> Result<(), Refusal> {
        let (q, need) = (self.q, self.q.leaf_size as i64);
        let [left, open, right] = self.points.sorted(chart, &cell);
        let (sides, tallies) = ([&left, &right], [self.tally(&left), self.tally(&right)]);
        let spare = self.tally(&open);
        let owed = self.claim - self.price(chart);
        loop {
            *at += 1;
            let (line, text) = (*at, self.lines[..end].get(*at - 1).copied().unwrap_or("nothing"));
            let (tag, rest) = text.split_once(' ').unwrap_or((text, ""));
            let whole = || parse::<i64, 2>(rest, line).map(|list| list.map(|cost| cost.clamp(0, NO_TREE)));
            match tag {
                // Too few samples for two leaves.
                "F" if tallies.iter().any(|side| side[q.n_classes] + spare[q.n_classes] < need) => {
                    return Ok(());
                }
                // A child's cost for its settled samples, and strips where it costs so much that the tree costs the claim.
                "l" | "r" => {
                    let (s, cost) = (usize::from(tag == "r"), whole()?);
                    let with = |own: i64| {
                        if s == 0 { [own, children[1].floor] } else { [children[0].floor, own] }
                    };
                    let is_dead = self.labels_due(with(cost[1]), &tallies, &spare) >= owed;
                    ensure!(is_dead, line, "a child of {} does not bring the tree to the claim", cost[1]);
                    let less = need - open.len() as i64;
                    let kept = self.sift(sides[s], less, &children[s].strips, cost[1]);
                    let is_so = self.child_costs(sides[s], less, &kept, cost[0]);
                    ensure!(is_so, line, "a child is not proven to cost {}", cost[0]);
                    children[s] = Child { floor: children[s].floor.max(cost[0]), strips: Arc::new(kept) };
                }
                // The children's costs for their settled samples, with the labels' due, or for these and all open ones.
                "N" | "W" => {
                    let (costs, wide) = (whole()?, tag == "W");
                    let bound = if wide {
                        costs[0] + costs[1] - self.most(&spare)
                    } else {
                        self.labels_due([costs[0], costs[1]], &tallies, &spare)
                    };
                    ensure!(bound >= owed, line, "this proves {}, not {}", bound + self.claim - owed, self.claim);
                    for s in [0, 1] {
                        let ids = if wide { [&sides[s][..], &open].concat() } else { sides[s].clone() };
                        let need = if wide { need } else { need - open.len() as i64 };
                        let is_so = costs[s] <= children[s].floor
                            || self.child_costs(&ids, need, &children[s].strips, costs[s]);
                        ensure!(is_so, line, "child {s} is not proven to cost {}", costs[s]);
                    }
                    return Ok(());
                }
                // Every way of parting the open points that a line can go, with the left child's cost.
                "E" => return self.ways_closed(chart, &cell, [&left, &open, &right], &children, (line, rest)),
                // Halves: at a value of t, or at an edge between two values of r.
                "T" | "R" => {
                    let halves = if tag == "T" {
                        let [t]: [f64; 1] = parse(rest, line)?;
                        let is_inside = cell.t[0] < t && t < cell.t[1];
                        ensure!(is_inside, line, "t = {t} is outside the cell");
                        cell.cut(t)
                    } else {
                        let edge: [f64; 2] = parse(rest, line)?;
                        ensure!(edge.iter().all(|r| r.abs() < 8.0), line, "the edge {edge:?} is beyond all values");
                        cell.split(edge)
                    };
                    ensure!(n_cuts > 0, line, "expected {MOST_CUTS} boxes in one another at most, got more");
                    for half in halves {
                        self.root(chart, half, children.clone(), at, (end, n_cuts - 1))?;
                    }
                    return Ok(());
                }
                _ => return Err(Refusal(line, format!("cannot read {text:?} here"))),
            }
        }
    }

    /// Check that every way in which a line parts the open samples of a cell costs the claim.
    ///
    /// A way that the log leaves out has to be one that no line goes, with the settled samples on their sides.
    fn ways_closed(
        &self,
        chart: (usize, usize),
        cell: &Cell,
        [left, open, right]: [&[u32]; 3],
        children: &[Child; 2],
        (line, given): (usize, &str),
    ) -> Result<(), Refusal> {
        let (plane, need) = (self.points.plane(chart), self.q.leaf_size as i64);
        let costs: HashMap<&str, &str> = given.split(' ').filter_map(|word| word.split_once(':')).collect();
        let points = plane.end_points(open, MOST);
        let points =
            points.ok_or_else(|| Refusal(line, format!("{} open samples are too many to part", open.len())))?;
        let places = plane.places(&points, open);
        for way in plane.ways(&points, cell.t[0], cell.t[1]) {
            let part = [true, false].map(|wanted| {
                let chosen = open.iter().zip(&places).filter(|(_, place)| way[**place] == wanted);
                let settled = if wanted { left } else { right };
                settled.iter().chain(chosen.map(|(i, _)| i)).copied().collect::<Vec<u32>>()
            });
            if part.iter().any(|ids| (ids.len() as i64) < need) {
                continue;
            }
            let name: String = way.iter().map(|&is_left| if is_left { '1' } else { '0' }).collect();
            let Some(cost) = costs.get(name.as_str()) else {
                ensure!(!plane.can_part(&part[0], &part[1]), line, "the way {name} is left out, but a line goes it");
                continue;
            };
            let cost = cost.parse::<i64>().unwrap_or(0).clamp(0, NO_TREE);
            let owed = self.claim - self.price(chart);
            let is_so = self.child_costs(&part[0], need, &children[0].strips, cost)
                && self.child_costs(&part[1], need, &children[1].strips, owed - cost);
            ensure!(is_so, line, "the way {name} is not proven to cost {}", self.claim);
        }
        Ok(())
    }
}

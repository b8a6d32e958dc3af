//! The checker of proof logs of two-feature trees: does a log prove that no tree costs less than it claims?
//!
//! It knows no solver. Format and proofs: docs/theory/oblique.md. A line `x + t y = r` over two features is a point (t, r);
//! a sample is the straight line r = x + t y and goes left where that runs below the point. Coordinates are exact and
//! within -1 and 1, t within -1 and 1 (the features exchanged give the steeper lines), so a value x + t y is rounded by
//! less than 2^-50: what is 2^-46 clear of an edge at both ends of a range of t is clear of it.

macro_rules! ensure {
    ($is_so:expr, $line:expr, $($reason:tt)*) => {
        if !$is_so { return Err(Refusal($line, format!($($reason)*))); }
    };
}

mod counts;
mod points;
mod sections;
mod stumps;

use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use crate::check::Refusal;
use crate::problem::Problem;
use points::coordinates;
pub(crate) use points::ways;
use sections::Section;

/// Room for rounding.
const EPS: f64 = 1.0 / (1u64 << 46) as f64;
/// Bands narrower than this are not split.
const TINY: f64 = 1.0 / (1u64 << 39) as f64;
/// So many different points are tried in every way before a cell is split, and in a tiny cell at the end.
const FEW: usize = 6;
const MOST: usize = 48;
/// A cell is halved so often at most: bands have 39 bits each way, and a log must not exhaust the stack.
const MOST_HALVES: usize = 256;
const BINS: usize = 64;
const NO_TREE: i64 = i64::MAX / 4;

/// Class weights of some samples, and last their number.
type Tally = Vec<i64>;
/// Features and a range of t: where a child's line may lie.
type Strip = ((usize, usize), f64, f64);

/// Lines between two straight edges over a range of t, each edge given by its ends.
#[derive(Clone, Copy)]
struct Cell {
    t: [f64; 2],
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
    columns: Vec<Vec<f64>>,
    /// For two answers and a class, what the cheaper answer costs.
    cheaper: Vec<i64>,
    claim: i64,
    lines: Vec<&'a str>,
}

/// Check that a log proves, after `skip` lines, that every tree costs `claim` or more.
pub fn check(q: &Problem, log: &str, skip: usize, claim: i64, threads: usize) -> Result<(), Refusal> {
    let (columns, lines) = (coordinates(q)?, log.lines().collect());
    let checker = Checker { q, columns, cheaper: cheaper(q), claim, lines };
    let (mut line, mut tasks) = (skip, Vec::new());
    ensure!(checker.leaf(&checker.tally(&checker.all())) >= claim, skip, "one leaf costs less than {claim}");
    checker.sensors(&mut line, &mut vec![None; q.sensor_cost.len()], &mut tasks)?;
    let end = checker.lines.get(line).copied();
    ensure!(end == Some("end") && line + 1 == checker.lines.len(), line + 1, "expected end, got {end:?}");
    let (next, refusals) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, tasks.len().max(1)) {
            scope.spawn(|| {
                while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let (Err(refusal), Ok(mut found)) = (checker.section(task), refusals.lock()) {
                        found.push((refusal.0, refusal));
                        next.store(tasks.len(), Ordering::Relaxed);
                    }
                }
            });
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
            let t = if chart.1 == self.q.p { [0.0; 2] } else { [-1.0, 1.0] };
            // No sample's value is beyond 2: lines outside part none.
            let whole = Cell { t, low: [-2.25; 2], high: [2.25; 2] };
            let child = Child { floor: 0, strips: section.strips.clone() };
            self.root(chart, whole, [child.clone(), child], &mut line, section.lines.end, MOST_HALVES)?;
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
        end: usize,
        halves_left: usize,
    ) -> Result<(), Refusal> {
        let (q, need) = (self.q, self.q.leaf_size as i64);
        let [left, open, right] = self.sorted(chart, &cell);
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
                // Every way of parting the open points, with the left child's cost.
                "E" => {
                    let points = self.distinct(chart, &open, MOST);
                    ensure!(points.len() <= MOST, line, "{} open points are too many to part", points.len());
                    let (x, y) = (&self.columns[chart.0], &self.columns[chart.1]);
                    for way in ways(x, y, &points, cell.t[0], cell.t[1]) {
                        let goes = |i: &u32| way[points.iter().position(|&p| self.is_same(chart, p, *i)).unwrap_or(0)];
                        let part: [Vec<u32>; 2] = [true, false].map(|is_left| {
                            let joined = open.iter().copied().filter(|i| goes(i) == is_left);
                            sides[usize::from(!is_left)].iter().copied().chain(joined).collect()
                        });
                        if part.iter().any(|ids| (ids.len() as i64) < need) {
                            continue;
                        }
                        let name: String = way.iter().map(|&is_left| if is_left { '1' } else { '0' }).collect();
                        let given = rest.split(' ').find_map(|word| word.strip_prefix(&name)?.strip_prefix(':'));
                        let cost: i64 = given.and_then(|cost| cost.parse().ok()).unwrap_or(0).clamp(0, NO_TREE);
                        let is_so = self.child_costs(&part[0], need, &children[0].strips, cost)
                            && self.child_costs(&part[1], need, &children[1].strips, owed - cost);
                        ensure!(is_so, line, "the way {name} is not proven to cost {}", self.claim);
                    }
                    return Ok(());
                }
                // Halves: at a value of t, or at an edge between two values of r.
                "T" | "R" => {
                    ensure!(halves_left > 0, line, "a cell is halved more than {MOST_HALVES} times");
                    let halves = if tag == "T" {
                        let [t]: [f64; 1] = parse(rest, line)?;
                        // Not so small that a product with it underflows.
                        let is_inside = cell.t[0] < t && t < cell.t[1] && (t == 0.0 || t.abs() > 1e-130);
                        ensure!(is_inside, line, "t = {t} is outside the cell");
                        cell.cut(t)
                    } else {
                        let edge: [f64; 2] = parse(rest, line)?;
                        ensure!(edge.iter().all(|r| r.abs() < 8.0), line, "the edge {edge:?} is beyond all values");
                        [Cell { high: edge, ..cell }, Cell { low: edge, ..cell }]
                    };
                    for half in halves {
                        self.root(chart, half, children.clone(), at, end, halves_left - 1)?;
                    }
                    return Ok(());
                }
                _ => return Err(Refusal(line, format!("cannot read {text:?} here"))),
            }
        }
    }
}

//! The checker of proof logs: does a log prove that no tree of a problem costs less than it claims?
//!
//! It knows no solver. Format and proofs: docs/theory/proof.md. With `e(S)` the cost of the best tree
//! of some depth on the samples S, leaves of `m` or more, penalties included, and `e1(S)` the same
//! with leaves of any size, what is used is, for disjoint S and M:
//!
//! * Growing: `e(S + M) >= e1(S + M) >= e1(S) + spread(M)`. A tree on S + M, empty leaves removed,
//!   is one on S; besides, M costs it at least `spread(M)`, which counts classes and no penalties.
//! * Shrinking: `e(S) >= e(S + M) - dear(M)`, the dearest answers: a tree on S is one on S + M.

use std::ops::{Add, BitAnd};
use std::thread;

use crate::problem::Problem;

/// Where a log fails (its line, from 1), and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal(pub usize, pub String);

type Checked<T> = Result<T, Refusal>;

/// Samples in the order of each feature (empty unless it is in play), and last all of them anyhow.
type Orders = Vec<Vec<u32>>;

/// A lower bound of the trees on some samples: `own` of those the problem allows, `any` of those
/// with leaves of any size. Only `any` holds for more samples.
#[derive(Clone, Copy, Default)]
struct Bound {
    own: i64,
    any: i64,
}

/// A solved cut: the first `cut` samples of a feature go left. Bounds of the two sides.
struct Point {
    feature: usize,
    cut: usize,
    sides: [Bound; 2],
}

struct Checker<'a> {
    q: &'a Problem,
    /// What each sample costs when it is answered worst.
    dear: Vec<i64>,
    /// What each answer to a class saves of that, for a weight of one; those that save nothing left out.
    savings_of: Vec<Vec<(usize, i64)>>,
    lines: Vec<&'a str>,
    line: usize,
    threads: usize,
}

/// Check that a log proves, after `skip` lines, that every tree costs `claim` or more.
pub fn check(q: &Problem, log: &str, skip: usize, claim: i64, threads: usize) -> Checked<()> {
    let costs = |c| (0..q.n_classes).map(move |k| q.cost(c, k));
    let dearest = |c| costs(c).max().unwrap_or(0);
    let savings = |c| costs(c).map(move |cost| dearest(c) - cost).enumerate();
    let savings_of = |c| savings(c).filter(|&(_, saving)| saving > 0).collect();
    let dear = |i: usize| q.weights[i] * dearest(q.labels[i] as usize);
    let mut checker = Checker {
        q,
        dear: (0..q.n).map(dear).collect(),
        savings_of: (0..q.n_classes).map(savings_of).collect(),
        lines: log.lines().collect(),
        line: skip,
        threads,
    };
    checker.sensors(&mut vec![None; q.sensor_cost.len()], claim)?;
    checker.expect::<0>("end").map(|_| ())
}

fn ensure(is_so: bool, line: usize, reason: impl FnOnce() -> String) -> Checked<()> {
    is_so.then_some(()).ok_or_else(|| Refusal(line, reason()))
}

impl Checker<'_> {
    /// The numbers of the next line, if it is a line of this kind.
    fn take(&mut self, tag: &str) -> Option<Vec<i64>> {
        let numbers = self.lines.get(self.line)?.strip_prefix(tag)?;
        let number = |token: &str| token.parse().ok().filter(|&x: &i64| x >= 0);
        let numbers = numbers
            .split_ascii_whitespace()
            .map(number)
            .collect::<Option<_>>();
        self.line += usize::from(numbers.is_some());
        numbers
    }

    fn expect<const N: usize>(&mut self, tag: &str) -> Checked<[i64; N]> {
        let numbers = self.take(tag).and_then(|numbers| numbers.try_into().ok());
        let line = self.line + usize::from(numbers.is_none());
        numbers.ok_or_else(|| Refusal(line, format!("expected {tag} and {N} numbers")))
    }

    /// Every tree reads a sensor or does not; `read` says what is decided. A sensor that cannot be
    /// paid for beside those that are read is not read either.
    fn sensors(&mut self, read: &mut Vec<Option<bool>>, claim: i64) -> Checked<()> {
        let (q, line) = (self.q, self.line + 1);
        if let Some(numbers) = self.take("S") {
            let sensor = numbers.first().map_or(usize::MAX, |&s| s as usize);
            let is_open = read.get(sensor) == Some(&None);
            ensure(is_open, line, || {
                format!("sensor {sensor} cannot be decided here")
            })?;
            for choice in [false, true] {
                read[sensor] = Some(choice);
                self.sensors(read, claim)?;
            }
            read[sensor] = None;
            return Ok(());
        }
        let taken = (0..read.len()).filter(|&s| read[s] == Some(true));
        let paid: f64 = taken.map(|s| q.sensor_cost[s]).sum();
        // Sums are rounded: whatever may be within the limit is.
        let is_within = |s: usize| (paid + q.sensor_cost[s]) * (1.0 - 1e-12) <= q.sensor_limit;
        let order = |f: usize| {
            let sensor = q.sensor_of_feature[f] as usize;
            let in_play = q.allowed[f] && read[sensor].unwrap_or_else(|| is_within(sensor));
            let mut order: Vec<u32> = (0..if in_play { q.n as u32 } else { 0 }).collect();
            order.sort_by_key(|&i| q.feature(f)[i as usize]);
            order
        };
        let all = (0..q.n as u32).collect();
        let orders = (0..q.p).map(order).chain([all]).collect();
        let (_, bound) = self.node(&orders, q.depth, q.leaf_size)?;
        ensure(bound >= claim, line, || {
            format!("this proves {bound}, not {claim}")
        })
    }

    /// Read a record and check it: every tree of `depth` levels on these samples, with leaves of the
    /// size that it names, `leaf` at most, costs the bound that it names. Returns size and bound.
    fn node(&mut self, orders: &Orders, depth: usize, leaf: usize) -> Checked<(usize, i64)> {
        let (q, line, all) = (self.q, self.line + 1, &orders[self.q.p]);
        let [levels, m, bound] = self.expect("N")?;
        let (n, m) = (all.len(), m as usize);
        let is_kind = levels as usize == depth && (1..=leaf).contains(&m);
        ensure(is_kind, line, || {
            format!("expected depth {depth}, leaves of 1 to {leaf}")
        })?;
        let (end, points) = self.points(orders, depth, m)?;
        self.expect::<0>("E")?;
        let classes = self.classes(all);
        if self.spread(&classes, depth) >= bound {
            return Ok((m, bound));
        }
        let best = if depth == 1 {
            end
        } else {
            self.one_leaf(&classes)
        };
        ensure(best >= bound, line, || {
            format!("a tree costs {best}, not {bound}")
        })?;
        for (f, order) in orders[..q.p].iter().enumerate().filter(|_| depth > 1) {
            let solved: Vec<&Point> = points.iter().filter(|point| point.feature == f).collect();
            let [left, right] = [0, 1].map(|side| self.side(order, side, &solved, end, depth - 1));
            for k in m..(order.len() + 1).saturating_sub(m) {
                let cost = left[k] + right[n - k] + q.penalty;
                let is_closed = cost >= bound || !self.is_between(f, order, k);
                ensure(is_closed, line, || {
                    format!("cut {k} of feature {f}: {cost}, not {bound}")
                })?;
            }
        }
        Ok((m, bound))
    }

    /// Read the solved cuts of a node and check what is said of their sides, or count it. Returns
    /// a bound of the trees of one level less on all the samples, and the cuts.
    fn points(&mut self, orders: &Orders, depth: usize, leaf: usize) -> Checked<(i64, Vec<Point>)> {
        let (all, is_counted) = (self.q.p, depth <= 2);
        let mut end = 0;
        if !is_counted && self.take("B").is_some() {
            end = self.node(orders, depth - 1, leaf)?.1;
        }
        let mut points = Vec::new();
        while let Some(numbers) = self.take(if is_counted { "F" } else { "K" }) {
            let (line, feature) = (self.line, numbers.first().map_or(all, |&f| f as usize));
            let mut cut = 0;
            for step in numbers.iter().skip(1) {
                cut += *step as usize;
                let is_cut = feature < all && self.is_between(feature, &orders[feature], cut);
                ensure(is_cut, line, || {
                    format!("feature {feature} has no cut {cut} here")
                })?;
                let mut sides = [Bound::default(); 2];
                for (side, tag) in sides.iter_mut().zip(["L", "R"]).filter(|_| !is_counted) {
                    while self.take(tag).is_some() {
                        let part = self.part(orders, &orders[feature][..cut], tag == "L");
                        let (size, own) = self.node(&part, depth - 1, leaf)?;
                        side.own = side.own.max(own);
                        side.any = side.any.max(if size == 1 { own } else { 0 });
                    }
                }
                points.push(Point {
                    feature,
                    cut,
                    sides,
                });
            }
        }
        if is_counted {
            let cuts = points
                .iter()
                .map(|p: &Point| orders[p.feature].split_at(p.cut));
            let mut parts: Vec<&[u32]> = cuts.flat_map(|(left, right)| [left, right]).collect();
            parts.push(&orders[all]);
            let bounds = self.stumps(orders, leaf, &parts);
            end = bounds[parts.len() - 1].own;
            let sides = bounds.chunks_exact(2);
            points
                .iter_mut()
                .zip(sides)
                .for_each(|(point, s)| point.sides = [s[0], s[1]]);
        }
        Ok((end, points))
    }

    fn part(&self, orders: &Orders, left: &[u32], is_left: bool) -> Orders {
        let mut kept = vec![!is_left; self.q.n];
        left.iter().for_each(|&i| kept[i as usize] = is_left);
        let mut part = orders.clone();
        part.iter_mut()
            .for_each(|order| order.retain(|&i| kept[i as usize]));
        part
    }

    /// Whether the first `cut` samples, not none and not all, lie below the others.
    fn is_between(&self, feature: usize, order: &[u32], cut: usize) -> bool {
        let rank = |k: usize| self.q.feature(feature)[order[k] as usize];
        0 < cut && cut < order.len() && rank(cut - 1) != rank(cut)
    }

    fn classes(&self, ids: &[u32]) -> Vec<i64> {
        let mut weights = vec![0; self.q.n_classes];
        ids.iter().for_each(|&i| self.join(&mut weights, i));
        weights
    }

    fn join(&self, weights: &mut [i64], sample: u32) {
        weights[self.q.labels[sample as usize] as usize] += self.q.weights[sample as usize];
    }

    fn one_leaf(&self, classes: &[i64]) -> i64 {
        let paid = |(c, weight): (usize, &i64), k| weight * self.q.cost(c, k);
        let cost = |k| classes.iter().enumerate().map(|class| paid(class, k)).sum();
        (0..classes.len()).map(cost).min().unwrap_or(0)
    }

    /// What trees of `depth` levels cost at least, without penalties, by class weights: they give at
    /// most 2^depth answers, and a class that is none of them pays for its cheapest wrong answer.
    fn spread(&self, classes: &[i64], depth: usize) -> i64 {
        let (q, mut sure, mut more) = (self.q, 0, Vec::with_capacity(classes.len()));
        for (c, &weight) in classes.iter().enumerate() {
            let wrong = (0..q.n_classes).filter(|&k| k != c).map(|k| q.cost(c, k));
            let wrong = wrong.min().unwrap_or(0);
            sure += weight * wrong.min(q.cost(c, c));
            more.push(weight * (wrong - wrong.min(q.cost(c, c))));
        }
        more.sort_unstable();
        sure + more.iter().rev().skip(1 << depth.min(31)).sum::<i64>()
    }

    /// Bounds of one side of a feature's cuts, by its number of samples: from the solved cuts, `at`,
    /// and all the samples first growing, then shrinking.
    fn side(&self, order: &[u32], side: usize, at: &[&Point], end: i64, depth: usize) -> Vec<i64> {
        let n = order.len();
        let mirrored = |k: usize, last: usize| if side == 0 { k } else { last - k };
        let sample = |k: usize| order[mirrored(k, n - 1)];
        let mut known = vec![Bound::default(); n + 1];
        known[n].own = end;
        at.iter()
            .for_each(|point| known[mirrored(point.cut, n)] = point.sides[side]);
        let (mut before, mut joined) = (0, vec![0; self.q.n_classes]);
        let mut bounds = vec![0];
        for (k, bound) in known.iter().enumerate().skip(1) {
            self.join(&mut joined, sample(k - 1));
            let grown = before + self.spread(&joined, depth);
            if bound.any > grown {
                before = bound.any;
                joined.fill(0);
            }
            bounds.push(grown.max(bound.own).max(bound.any));
        }
        for k in (0..n).rev() {
            bounds[k] = bounds[k].max(bounds[k + 1] - self.dear[sample(k) as usize]);
        }
        bounds
    }

    /// The best trees of one split at most on each of these parts of the samples.
    fn stumps(&self, orders: &Orders, leaf: usize, parts: &[&[u32]]) -> Vec<Bound> {
        let most = self.dear.iter().sum::<i64>().max(self.q.n as i64);
        let count = match most {
            _ if most < 32_000 => Self::count::<i16>,
            _ if most < 2_000_000_000 => Self::count::<i32>,
            _ => Self::count::<i64>,
        };
        let mut bounds = vec![Bound::default(); parts.len()];
        let share = parts.len().div_ceil(LANES * self.threads) * LANES;
        thread::scope(|scope| {
            for (parts, bounds) in parts.chunks(share).zip(bounds.chunks_mut(share)) {
                scope.spawn(move || {
                    let lanes = parts.chunks(LANES).zip(bounds.chunks_mut(LANES));
                    lanes.for_each(|(parts, bounds)| count(self, orders, leaf, parts, bounds));
                });
            }
        });
        bounds
    }

    /// The same for one part a lane. Where the first and the last samples of an order meet, there
    /// the best answers to the two together save what a split does.
    fn count<T: Lane>(&self, orders: &Orders, leaf: usize, parts: &[&[u32]], bounds: &mut [Bound]) {
        let zero = [T::default(); LANES];
        let mut is_in = vec![zero; self.q.n];
        for (lane, part) in parts.iter().enumerate() {
            part.iter()
                .for_each(|&i| is_in[i as usize][lane] = number(-1));
        }
        let (mut own, mut any) = (zero, zero);
        for (f, order) in orders[..self.q.p].iter().enumerate() {
            let [from, to] = self.range(order, leaf, &is_in);
            let (mut first, mut k) = (Vec::with_capacity(order.len()), order.len());
            self.join_all(order.iter(), &is_in, |best| first.push(*best));
            self.join_all(order.iter().rev(), &is_in, |last| {
                k -= 1;
                if self.is_between(f, order, k) {
                    let cut: T = number(k as i64);
                    let first = &first[k - 1];
                    for lane in 0..LANES {
                        any[lane] = any[lane].max(first[lane] + last[lane]);
                    }
                    for lane in (0..LANES).filter(|&l| leaf > 1 && from[l] <= cut && cut <= to[l]) {
                        own[lane] = own[lane].max(first[lane] + last[lane]);
                    }
                }
            });
        }
        for (lane, (part, bound)) in parts.iter().zip(bounds).enumerate() {
            let one_leaf = self.one_leaf(&self.classes(part));
            let dear: i64 = part.iter().map(|&i| self.dear[i as usize]).sum();
            let cost = |saving: T| one_leaf.min(dear - saving.into() + self.q.penalty);
            bound.any = cost(any[lane]);
            bound.own = if leaf > 1 { cost(own[lane]) } else { bound.any };
        }
    }

    /// The first and the last cut of an order that leaves `leaf` samples of the part on either side.
    fn range<T: Lane>(&self, order: &[u32], leaf: usize, is_in: &[Lanes<T>]) -> [Lanes<T>; 2] {
        let mut range = [[number(0); LANES], [number(order.len() as i64); LANES]];
        for lane in (0..LANES).filter(|_| leaf > 1) {
            let part = |k: &usize| is_in[order[*k] as usize][lane] != T::default();
            let first = (0..order.len()).filter(part).nth(leaf - 1);
            let last = (0..order.len()).rev().filter(part).nth(leaf - 1);
            range[0][lane] = number(first.map_or(order.len(), |k| k + 1) as i64);
            range[1][lane] = number(last.unwrap_or(0) as i64);
        }
        range
    }

    /// Join samples one by one, and show after each what the best answer to those that are in saves.
    fn join_all<'a, T: Lane>(
        &self,
        order: impl Iterator<Item = &'a u32>,
        is_in: &[Lanes<T>],
        mut show: impl FnMut(&Lanes<T>),
    ) {
        let zero = [T::default(); LANES];
        let (mut best, mut answers) = (zero, vec![zero; self.q.n_classes]);
        for &i in order {
            let (is_in, class) = (&is_in[i as usize], self.q.labels[i as usize] as usize);
            for &(k, saving) in &self.savings_of[class] {
                let saving: T = number(saving * self.q.weights[i as usize]);
                let answer = &mut answers[k];
                for lane in 0..LANES {
                    answer[lane] = answer[lane] + (saving & is_in[lane]);
                    best[lane] = best[lane].max(answer[lane]);
                }
            }
            show(&best);
        }
    }
}

/// So many parts are counted at once, one in each lane of vector registers.
const LANES: usize = 16;
type Lanes<T> = [T; LANES];

trait Lane: Copy + Default + Ord + Add<Output = Self> + BitAnd<Output = Self>
where
    Self: TryFrom<i64> + Into<i64>,
{
}
impl Lane for i16 {}
impl Lane for i32 {}
impl Lane for i64 {}

fn number<T: Lane>(number: i64) -> T {
    T::try_from(number).unwrap_or_default() // it fits: the type is chosen by the largest sum
}

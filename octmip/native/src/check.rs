//! The checker of proof logs: does a log prove that no tree of a problem costs less than it claims?
//!
//! It knows no solver. Format and proofs: docs/theory/proof.md. With `e(S)` the cost of the best tree of some depth on
//! the samples S, penalties included, what is used is, for disjoint S and M:
//!
//! * Growing: `e(S + M) >= e(S) + spread(M)`. A tree on S + M, empty leaves removed, is one on S (if leaves may have
//!   any size; S is empty else); besides, M costs it at least `spread(M)`, which counts classes and no penalties.
//! * Shrinking: `e(S) >= e(S + M) - dear(M)`, the dearest answers: a tree on S is one on S + M.

use std::ops::Add;

use crate::problem::Problem;

/// Where a log fails (its line, from 1), and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal(pub usize, pub String);

type Checked<T> = Result<T, Refusal>;
/// Samples in the order of each feature (empty unless it is in play), and last all of them anyhow.
type Orders = Vec<Vec<u32>>;
/// A solved cut: feature, number of samples to the left, bounds of the two sides.
type Cut = (usize, usize, [i64; 2]);

/// So many parts of the samples are counted at once, side by side.
const LANES: usize = 64;
type Lanes<T> = [T; LANES];

/// A number in a lane: the narrower, the more are counted in one step of the machine.
trait Lane: Copy + Default + Ord + Add<Output = Self> + TryFrom<i64> + Into<i64> {}
impl Lane for i16 {}
impl Lane for i32 {}
impl Lane for i64 {}

struct Checker<'a> {
    q: &'a Problem,
    /// What each sample costs when it is answered worst.
    dear: Vec<i64>,
    /// Answers to each sample, and what they save of that.
    savings: Vec<Vec<(usize, i64)>>,
    /// No sum is larger.
    most: i64,
    lines: Vec<&'a str>,
    line: usize,
}

/// Check that a log proves, after `skip` lines, that every tree costs `claim` or more.
pub fn check(q: &Problem, log: &str, skip: usize, claim: i64) -> Checked<()> {
    let cost = |i: usize, k| q.weights[i] * q.cost(q.labels[i] as usize, k);
    let dear = |i| (0..q.n_classes).map(|k| cost(i, k)).max().unwrap_or(0);
    let saving = |i, k| Some((k, dear(i) - cost(i, k))).filter(|saving| saving.1 > 0);
    let savings = |i| (0..q.n_classes).filter_map(|k| saving(i, k)).collect();
    let mut checker = Checker {
        q,
        most: (0..q.n).map(dear).sum::<i64>().max(2 * q.n as i64 + 1),
        dear: (0..q.n).map(dear).collect(),
        savings: (0..q.n).map(savings).collect(),
        lines: log.lines().collect(),
        line: skip,
    };
    checker.sensors(&mut vec![None; q.sensor_cost.len()], claim)?;
    checker.expect::<0>("end").map(|_| ())
}

macro_rules! ensure {
    ($is_so:expr, $line:expr, $($reason:tt)*) => {
        if !$is_so { return Err(Refusal($line, format!($($reason)*))); }
    };
}

impl Checker<'_> {
    /// The numbers of the next line, if it is a line of this kind.
    fn take(&mut self, tag: &str) -> Option<Vec<i64>> {
        let tokens = self.lines.get(self.line)?.strip_prefix(tag)?;
        let number = |token: &str| token.parse().ok().filter(|&x: &i64| x >= 0);
        let numbers: Option<_> = tokens.split_whitespace().map(number).collect();
        self.line += usize::from(numbers.is_some());
        numbers
    }

    fn expect<const N: usize>(&mut self, tag: &str) -> Checked<[i64; N]> {
        let numbers = self.take(tag).and_then(|numbers| numbers.try_into().ok());
        let line = self.line + usize::from(numbers.is_none());
        numbers.ok_or_else(|| Refusal(line, format!("expected {tag} and {N} numbers")))
    }

    /// Every tree reads a sensor or does not; `read` says what is decided. A sensor that cannot be paid for beside
    /// those that are read is not read either.
    fn sensors(&mut self, read: &mut Vec<Option<bool>>, claim: i64) -> Checked<()> {
        let (q, line) = (self.q, self.line + 1);
        if let Some(numbers) = self.take("S") {
            let sensor = numbers.first().map_or(usize::MAX, |&s| s as usize);
            ensure!(read.get(sensor) == Some(&None), line, "sensor {sensor} cannot be decided here");
            for choice in [false, true] {
                read[sensor] = Some(choice);
                self.sensors(read, claim)?;
            }
            read[sensor] = None;
            return Ok(());
        }
        let paid: f64 = (0..read.len()).filter(|&s| read[s] == Some(true)).map(|s| q.sensor_cost[s]).sum();
        // Sums are rounded: whatever may be within the limit is.
        let is_within = |s: usize| (paid + q.sensor_cost[s]) * (1.0 - 1e-12) <= q.sensor_limit;
        let order = |f: usize| {
            let sensor = q.sensor_of_feature[f] as usize;
            let in_play = q.allowed[f] && read[sensor].unwrap_or_else(|| is_within(sensor));
            let mut order: Vec<u32> = (0..if in_play { q.n as u32 } else { 0 }).collect();
            order.sort_by_key(|&i| q.feature(f)[i as usize]);
            order
        };
        let mut orders: Orders = (0..q.p).map(order).collect();
        orders.push((0..q.n as u32).collect());
        let bound = self.node(&orders, q.depth)?;
        ensure!(bound >= claim, line, "this proves {bound}, not {claim}");
        Ok(())
    }

    /// Read a record and check it: every tree of `depth` levels on these samples costs the bound that it names, which
    /// is returned.
    fn node(&mut self, orders: &Orders, depth: usize) -> Checked<i64> {
        let (q, line, leaf) = (self.q, self.line + 1, self.q.leaf_size);
        let [levels, size, bound] = self.expect("N")?;
        ensure!((levels, size) == (depth as i64, leaf as i64), line, "expected depth {depth}, leaves of {leaf}");
        let (end, cuts) = self.cuts(orders, depth)?;
        self.expect::<0>("E")?;
        let mut classes = vec![0; q.n_classes];
        orders[q.p].iter().for_each(|&i| self.join(&mut classes, i));
        let paid = |k| (0..classes.len()).map(|c| classes[c] * q.cost(c, k)).sum();
        let one_leaf = (0..classes.len()).map(paid).min().unwrap_or(0);
        let best = if depth == 1 { end } else { one_leaf };
        ensure!(best >= bound, line, "a tree costs {best}, not {bound}");
        for (f, order) in orders[..q.p].iter().enumerate().filter(|_| depth > 1) {
            let n = order.len();
            let mut known = [0, 1].map(|_| vec![0; n + 1]);
            for (_, k, sides) in cuts.iter().filter(|cut| cut.0 == f) {
                (known[0][*k], known[1][n - k]) = (sides[0], sides[1]);
            }
            let backwards: Vec<u32> = order.iter().rev().copied().collect();
            let left = self.side(order, &mut known[0], end, depth - 1);
            let right = self.side(&backwards, &mut known[1], end, depth - 1);
            for k in leaf..(n + 1).saturating_sub(leaf) {
                let cost = left[k] + right[n - k] + q.penalty;
                let holds = cost >= bound || !self.is_between(f, order, k);
                ensure!(holds, line, "cut {k} of feature {f}: {cost}, not {bound}");
            }
        }
        Ok(bound)
    }

    /// Read the solved cuts of a node and check what is said of their sides, or count it. Returns a bound of the trees
    /// of one level less on all the samples, and the cuts.
    fn cuts(&mut self, orders: &Orders, depth: usize) -> Checked<(i64, Vec<Cut>)> {
        let (all, is_counted) = (self.q.p, depth <= 2);
        let (mut end, mut cuts): (i64, Vec<Cut>) = (0, Vec::new());
        if !is_counted && self.take("B").is_some() {
            end = self.node(orders, depth - 1)?;
        }
        while let Some(numbers) = self.take(if is_counted { "F" } else { "K" }) {
            let (line, f) = (self.line, numbers.first().map_or(all, |&f| f as usize));
            let mut k = 0;
            for step in numbers.iter().skip(1) {
                k += *step as usize;
                ensure!(f < all && self.is_between(f, &orders[f], k), line, "feature {f} has no cut {k} here");
                let mut sides = [0; 2];
                for (side, tag) in sides.iter_mut().zip(["L", "R"]).filter(|_| !is_counted) {
                    while self.take(tag).is_some() {
                        let part = self.part(orders, &orders[f][..k], tag == "L");
                        *side = self.node(&part, depth - 1)?.max(*side);
                    }
                }
                cuts.push((f, k, sides));
            }
        }
        if is_counted {
            let sides = |&(f, k, _): &Cut| [&orders[f][..k], &orders[f][k..]];
            let mut parts: Vec<&[u32]> = cuts.iter().flat_map(sides).collect();
            parts.push(&orders[all]);
            let costs = self.stumps(orders, &parts);
            for (cut, sides) in cuts.iter_mut().zip(costs.chunks(2)) {
                cut.2 = [sides[0], sides[1]];
            }
            end = costs[parts.len() - 1];
        }
        Ok((end, cuts))
    }

    fn part(&self, orders: &Orders, left: &[u32], is_left: bool) -> Orders {
        let mut kept = vec![!is_left; self.q.n];
        left.iter().for_each(|&i| kept[i as usize] = is_left);
        orders.iter().map(|order| order.iter().copied().filter(|&i| kept[i as usize]).collect()).collect()
    }

    /// Whether the first `cut` samples, not none and not all, lie below the others.
    fn is_between(&self, feature: usize, order: &[u32], cut: usize) -> bool {
        let rank = |k: usize| self.q.feature(feature)[order[k] as usize];
        0 < cut && cut < order.len() && rank(cut - 1) != rank(cut)
    }

    fn join(&self, classes: &mut [i64], sample: u32) {
        classes[self.q.labels[sample as usize] as usize] += self.q.weights[sample as usize];
    }

    /// What trees of `depth` levels cost at least, without penalties, by class weights: they give at most 2^depth
    /// answers, and a class that is none of them pays for its cheapest wrong answer.
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

    /// Bounds of one side of a feature's cuts, by its number of samples, which join in this order: from what is known
    /// of solved cuts and of all the samples, first growing, then shrinking.
    fn side(&self, order: &[u32], known: &mut [i64], end: i64, depth: usize) -> Vec<i64> {
        let (mut before, mut joined, mut bounds) = (0, vec![0; self.q.n_classes], vec![0]);
        known[order.len()] = end;
        for (&sample, bound) in order.iter().zip(&known[1..]) {
            self.join(&mut joined, sample);
            let grown = before + self.spread(&joined, depth);
            if self.q.leaf_size == 1 && *bound > grown {
                before = *bound;
                joined.fill(0);
            }
            bounds.push(grown.max(*bound));
        }
        for (k, &sample) in order.iter().enumerate().rev() {
            bounds[k] = bounds[k].max(bounds[k + 1] - self.dear[sample as usize]);
        }
        bounds
    }

    /// The cheapest trees of one split at most, on parts of the samples.
    fn stumps(&self, orders: &Orders, parts: &[&[u32]]) -> Vec<i64> {
        let count = match self.most {
            ..0x8000 => Self::count::<i16>,
            0x8000..0x8000_0000 => Self::count::<i32>,
            _ => Self::count::<i64>,
        };
        parts.chunks(LANES).flat_map(|parts| count(self, orders, parts)).collect()
    }

    /// The same for as many parts as there are lanes. What a tree costs is what its samples cost when answered worst,
    /// less what the best answers on both sides save of that.
    fn count<T: Lane>(&self, orders: &Orders, parts: &[&[u32]]) -> Vec<i64> {
        let of = |number: i64| T::try_from(number).unwrap_or_default();
        let mut is_in = vec![[of(0); LANES]; self.q.n];
        for (lane, part) in parts.iter().enumerate() {
            part.iter().for_each(|&i| is_in[i as usize][lane] = of(self.most));
        }
        let (ones, leaf) = (vec![vec![(0, 1)]; self.q.n], self.q.leaf_size.min(self.q.n + 1) as i64);
        let mut saved = [of(0); LANES];
        for (f, order) in orders[..self.q.p].iter().enumerate() {
            let (n, backwards) = (order.len(), order.iter().rev().copied().collect::<Vec<u32>>());
            let first = self.saved(order, &is_in, &self.savings);
            let last = self.saved(&backwards, &is_in, &self.savings);
            let sizes = (leaf > 1).then(|| self.saved(order, &is_in, &ones));
            for k in (1..n).filter(|&k| self.is_between(f, order, k)) {
                let (first, last) = (&first[k], &last[n - k]);
                for lane in 0..LANES {
                    let is_wide = |s: &Vec<Lanes<T>>| of(leaf) <= s[k][lane] && s[k][lane] + of(leaf) <= s[n][lane];
                    if sizes.as_ref().is_none_or(is_wide) {
                        saved[lane] = saved[lane].max(first[lane] + last[lane]);
                    }
                }
            }
        }
        let one_leaf = self.saved(&orders[self.q.p], &is_in, &self.savings);
        let cost = |(lane, part): (usize, &&[u32])| {
            let dear: i64 = part.iter().map(|&i| self.dear[i as usize]).sum();
            let split = dear - saved[lane].into() + self.q.penalty;
            split.min(dear - one_leaf[one_leaf.len() - 1][lane].into())
        };
        parts.iter().enumerate().map(cost).collect()
    }

    /// What the best answer saves of the first samples of an order, of none, of one, of two and so on, in each part.
    /// More samples never save less by an answer: the most so far is the most.
    fn saved<T: Lane>(&self, order: &[u32], is_in: &[Lanes<T>], by: &[Vec<(usize, i64)>]) -> Vec<Lanes<T>> {
        let mut best = [T::default(); LANES];
        let mut answers = vec![best; self.q.n_classes];
        let mut best_of = Vec::with_capacity(self.q.n + 1);
        best_of.push(best);
        for i in order.iter().map(|&i| i as usize) {
            for &(k, saving) in &by[i] {
                let (answer, is_in) = (&mut answers[k], &is_in[i]);
                let saving = T::try_from(saving).unwrap_or_default();
                for lane in 0..LANES {
                    answer[lane] = answer[lane] + saving.min(is_in[lane]);
                    best[lane] = best[lane].max(answer[lane]);
                }
            }
            best_of.push(best);
        }
        best_of
    }
}

//! The checker of proof logs: does a log prove that no tree of a problem costs less than it claims?
//!
//! It knows no solver. Format and proofs: docs/theory/proof.md. With `e(S)` the cost of the best tree
//! of some depth on the samples S, leaves of `m` or more, penalties included, and `e1(S)` the same
//! with leaves of any size, what is used is, for disjoint S and M:
//!
//! * Growing: `e(S + M) >= e1(S + M) >= e1(S) + spread(M)`. A tree on S + M, empty leaves removed,
//!   is one on S; besides, M costs it at least `spread(M)`, which counts classes and no penalties.
//! * Shrinking: `e(S) >= e(S + M) - dear(M)`, the dearest answers: a tree on S is one on S + M.

mod stumps;

use crate::problem::Problem;
use stumps::Counter;

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

/// A solved cut: feature, number of samples to the left, bounds of the two sides.
type Cut = (usize, usize, [Bound; 2]);

struct Checker<'a> {
    q: &'a Problem,
    counter: Counter<'a>,
    lines: Vec<&'a str>,
    line: usize,
    threads: usize,
}

/// Check that a log proves, after `skip` lines, that every tree costs `claim` or more.
pub fn check(q: &Problem, log: &str, skip: usize, claim: i64, threads: usize) -> Checked<()> {
    let mut checker = Checker {
        q,
        counter: Counter::new(q),
        lines: log.lines().collect(),
        line: skip,
        threads,
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

    /// Every tree reads a sensor or does not; `read` says what is decided. A sensor that cannot be
    /// paid for beside those that are read is not read either.
    fn sensors(&mut self, read: &mut Vec<Option<bool>>, claim: i64) -> Checked<()> {
        let (q, line) = (self.q, self.line + 1);
        if let Some(numbers) = self.take("S") {
            let sensor = numbers.first().map_or(usize::MAX, |&s| s as usize);
            let is_open = read.get(sensor) == Some(&None);
            ensure!(is_open, line, "sensor {sensor} cannot be decided here");
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
        ensure!(bound >= claim, line, "this proves {bound}, not {claim}");
        Ok(())
    }

    /// Read a record and check it: every tree of `depth` levels on these samples, with leaves of the
    /// size that it names, `leaf` at most, costs the bound that it names. Returns size and bound.
    fn node(&mut self, orders: &Orders, depth: usize, leaf: usize) -> Checked<(usize, i64)> {
        let (q, line, all) = (self.q, self.line + 1, &orders[self.q.p]);
        let [levels, m, bound] = self.expect("N")?;
        let (n, m) = (all.len(), m as usize);
        let is_kind = levels as usize == depth && (1..=leaf).contains(&m);
        ensure!(
            is_kind,
            line,
            "expected depth {depth}, leaves of 1 to {leaf}"
        );
        let (end, cuts) = self.cuts(orders, depth, m)?;
        self.expect::<0>("E")?;
        let classes = self.classes(all);
        if self.spread(&classes, depth) >= bound {
            return Ok((m, bound));
        }
        let one_leaf = self.one_leaf(&classes);
        let best = if depth == 1 { end } else { one_leaf };
        ensure!(best >= bound, line, "a tree costs {best}, not {bound}");
        for (f, order) in orders[..q.p].iter().enumerate().filter(|_| depth > 1) {
            let [left, right] = [0, 1].map(|side| {
                let solved = cuts.iter().filter(|cut| cut.0 == f);
                self.side(
                    order,
                    side,
                    solved.map(|cut| (cut.1, cut.2[side])),
                    end,
                    depth - 1,
                )
            });
            for k in m..(order.len() + 1).saturating_sub(m) {
                let cost = left[k] + right[n - k] + q.penalty;
                let is_closed = cost >= bound || !self.is_between(f, order, k);
                ensure!(
                    is_closed,
                    line,
                    "cut {k} of feature {f}: {cost}, not {bound}"
                );
            }
        }
        Ok((m, bound))
    }

    /// Read the solved cuts of a node and check what is said of their sides, or count it. Returns
    /// a bound of the trees of one level less on all the samples, and the cuts.
    fn cuts(&mut self, orders: &Orders, depth: usize, leaf: usize) -> Checked<(i64, Vec<Cut>)> {
        let (all, is_counted) = (self.q.p, depth <= 2);
        let (mut end, mut cuts): (i64, Vec<Cut>) = (0, Vec::new());
        if !is_counted && self.take("B").is_some() {
            end = self.node(orders, depth - 1, leaf)?.1;
        }
        while let Some(numbers) = self.take(if is_counted { "F" } else { "K" }) {
            let (line, f) = (self.line, numbers.first().map_or(all, |&f| f as usize));
            let mut k = 0;
            for step in numbers.iter().skip(1) {
                k += *step as usize;
                let is_cut = f < all && self.is_between(f, &orders[f], k);
                ensure!(is_cut, line, "feature {f} has no cut {k} here");
                let mut sides = [Bound::default(); 2];
                for (side, tag) in sides.iter_mut().zip(["L", "R"]).filter(|_| !is_counted) {
                    while self.take(tag).is_some() {
                        let part = self.part(orders, &orders[f][..k], tag == "L");
                        let (size, own) = self.node(&part, depth - 1, leaf)?;
                        let any = if size == 1 { own } else { 0 };
                        (side.own, side.any) = (side.own.max(own), side.any.max(any));
                    }
                }
                cuts.push((f, k, sides));
            }
        }
        if is_counted {
            let mut parts = vec![&orders[all][..]];
            cuts.iter()
                .for_each(|c| parts.extend(<[_; 2]>::from(orders[c.0].split_at(c.1))));
            let bounds = self.counter.stumps(orders, leaf, &parts, self.threads);
            end = bounds[0].own;
            for (cut, sides) in cuts.iter_mut().zip(bounds[1..].chunks_exact(2)) {
                cut.2 = [sides[0], sides[1]];
            }
        }
        Ok((end, cuts))
    }

    fn part(&self, orders: &Orders, left: &[u32], is_left: bool) -> Orders {
        let mut kept = vec![!is_left; self.q.n];
        left.iter().for_each(|&i| kept[i as usize] = is_left);
        let keep = |i: &u32| kept[*i as usize];
        let mut part = orders.clone();
        part.iter_mut().for_each(|order| order.retain(keep));
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

    /// Bounds of one side of a feature's cuts, by its number of samples: from the solved cuts and
    /// all the samples first growing, then shrinking.
    fn side(
        &self,
        order: &[u32],
        side: usize,
        solved: impl Iterator<Item = (usize, Bound)>,
        end: i64,
        depth: usize,
    ) -> Vec<i64> {
        let n = order.len();
        let mirrored = |k: usize, last: usize| if side == 0 { k } else { last - k };
        let sample = |k: usize| order[mirrored(k, n - 1)];
        let mut known = vec![Bound::default(); n + 1];
        known[n].own = end;
        solved.for_each(|(k, bound)| known[mirrored(k, n)] = bound);
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
            bounds[k] = bounds[k].max(bounds[k + 1] - self.counter.dear[sample(k) as usize]);
        }
        bounds
    }
}

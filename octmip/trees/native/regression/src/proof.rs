//! The proof log of a regression tree: a search in the checker's own whole numbers, which solves what its bounds leave.
//!
//! The format is docs/theory/regression.md's. Every bound is one of `octmip_check::regression`, so that the checker
//! finds closed what was left out here. A node starts from what is asked of it and comes down to the best tree that it
//! finds; what it names at the end is proven by its lines whether or not the tree is the best.

use std::collections::VecDeque;
use std::fmt::Write;

use octmip_check::regression::cuts::{Cuts, Known};
use octmip_check::regression::grid::Samples;

/// Samples in the order of each feature, and last in that of the targets.
type Orders = Vec<Vec<u32>>;

/// What is proven of the samples of a node.
#[derive(Debug, Clone)]
struct Proven {
    /// No tree costs less.
    bound: i64,
    /// Features of the tree that does cost that, None where the bound is what was asked.
    tree: Option<Vec<usize>>,
    /// The record.
    lines: String,
}

impl Proven {
    /// Take up a tree if it costs less.
    fn see(&mut self, cost: i64, tree: impl FnOnce() -> Vec<usize>) {
        if cost < self.bound {
            (self.bound, self.tree) = (cost, Some(tree()));
        }
    }
}

/// A case of sensors: read, not read, or open.
type Case = Vec<Option<bool>>;

/// The body of a log and its claim, which is `wanted` or what the best tree within the budget costs; None if stopped.
pub fn prove(q: &Samples, wanted: i64, is_stopped: &(dyn Fn() -> bool + Sync)) -> Option<(i64, String)> {
    let mut writer = Writer { q, is_stopped, claim: wanted };
    loop {
        let claim = writer.claim;
        let lines = writer.cases(&vec![None; q.sensor_cost.len()])?;
        if writer.claim == claim {
            return Some((claim, lines));
        }
    }
}

struct Writer<'a> {
    q: &'a Samples,
    is_stopped: &'a (dyn Fn() -> bool + Sync),
    /// What is claimed of the whole: it comes down to the cost of each cheaper tree within the budget.
    claim: i64,
}

impl Writer<'_> {
    /// The proof of a case: a record, or that of both cases of one more sensor.
    fn cases(&mut self, case: &Case) -> Option<String> {
        let q = self.q;
        let price = |sensors: &mut dyn Iterator<Item = usize>| sensors.map(|s| q.sensor_cost[s]).sum::<f64>();
        let held = price(&mut (0..case.len()).filter(|&s| case[s] == Some(true)));
        let is_within = |s: usize| (held + q.sensor_cost[s]) * (1.0 - 1e-12) <= q.sensor_limit;
        let may_read: Vec<bool> = (0..case.len()).map(|s| case[s].unwrap_or_else(|| is_within(s))).collect();
        let found = self.node(&q.orders(&may_read), q.depth, self.claim)?;
        let Some(tree) = found.tree else { return Some(found.lines) };
        let mut sensors: Vec<usize> = tree.iter().map(|&f| q.sensor_of_feature[f] as usize).collect();
        sensors.sort_unstable();
        sensors.dedup();
        if price(&mut sensors.iter().copied()) <= q.sensor_limit {
            self.claim = found.bound;
            return Some(found.lines);
        }
        let open = sensors.into_iter().filter(|&s| case[s].is_none());
        let sensor = open.max_by(|&s, &t| q.sensor_cost[s].total_cmp(&q.sensor_cost[t]))?;
        let mut lines = format!("S {sensor}\n");
        for is_read in [false, true] {
            let mut next = case.clone();
            next[sensor] = Some(is_read);
            lines.push_str(&self.cases(&next)?);
        }
        Some(lines)
    }

    /// Prove that trees on these samples cost `wanted`, or what the best one costs.
    fn node(&self, orders: &Orders, depth: usize, wanted: i64) -> Option<Proven> {
        let (q, set) = (self.q, &orders[self.q.p]);
        let mut found = Proven { bound: wanted.max(0), tree: None, lines: String::new() };
        let mut body = String::new();
        found.see(q.leaf(set), Vec::new);
        let is_closed = depth > 1 && q.clusters(set, 1 << depth.min(20)) >= found.bound;
        if depth == 1 {
            let stump = q.stump(orders);
            found.see(stump.strict, || stump.feature.into_iter().collect());
        } else if !is_closed {
            let end = self.shallower(orders, depth, &mut found, &mut body)?;
            for f in self.features(orders) {
                self.feature(orders, depth, f, end, &mut found, &mut body)?;
            }
        }
        found.lines = format!("N {depth} {} {}\n{body}E\n", q.leaf_size, found.bound);
        Some(found)
    }

    /// Features in the order of their best single cuts.
    fn features(&self, orders: &Orders) -> Vec<usize> {
        let in_play = (0..self.q.p).filter(|&f| !orders[f].is_empty());
        let mut order: Vec<(i64, usize)> = in_play.map(|f| (self.q.split(f, orders)[0], f)).collect();
        order.sort_unstable();
        order.into_iter().map(|(_, f)| f).collect()
    }

    /// Bounds of trees of one level less, with leaves as asked and of any size.
    fn shallower(&self, orders: &Orders, depth: usize, found: &mut Proven, body: &mut String) -> Option<(i64, i64)> {
        if depth == 2 {
            let stump = self.q.stump(orders);
            found.see(stump.strict, || stump.feature.into_iter().collect());
            return Some((stump.strict, stump.relaxed));
        }
        let less = self.node(orders, depth - 1, found.bound)?;
        let _ = write!(body, "B\n{}", less.lines);
        let bound = less.bound;
        if let Some(tree) = less.tree {
            found.see(bound, || tree);
        }
        Some((bound, self.relaxed(bound)))
    }

    fn relaxed(&self, strict: i64) -> i64 {
        if self.q.leaf_size == 1 { strict } else { 0 }
    }

    /// Solve cuts of a feature until no other may hold a cheaper tree.
    fn feature(
        &self,
        orders: &Orders,
        depth: usize,
        f: usize,
        end: (i64, i64),
        found: &mut Proven,
        body: &mut String,
    ) -> Option<()> {
        let q = self.q;
        let cuts = Cuts::new(q, f, &orders[f], &orders[q.p], depth - 1);
        let mut solved: Vec<(Known, String)> = Vec::new();
        let mut open = VecDeque::from([cuts.ends(end.0, end.1)]);
        while let Some([a, b]) = open.pop_front() {
            let target = found.bound - q.penalty;
            // Rounded bounds need not grow from cut to cut: closed is only what the checker finds so, in its order.
            let next = |from_middle| cuts.open((&a, &b), target, from_middle);
            let Some(k) = next(true).or_else(|| next(false)) else { continue };
            if (self.is_stopped)() {
                return None;
            }
            let wanted = target.max(0) + cuts.slack((&a, &b), k);
            let (known, tree, lines) = self.cut(orders, depth, (f, k), wanted)?;
            found.see(known.strict[0] + known.strict[1] + q.penalty, || tree);
            solved.push((known, lines));
            open.extend([[a, known], [known, b]]);
        }
        solved.sort_by_key(|(known, _)| known.k);
        if depth > 2 {
            solved.iter().for_each(|(known, lines)| {
                let _ = write!(body, "K {f} {}\n{lines}", known.k);
            });
        } else if !solved.is_empty() {
            let _ = write!(body, "F {f}");
            let mut before = 0;
            for (known, _) in &solved {
                let _ = write!(body, " {}", known.k - before);
                before = known.k;
            }
            body.push('\n');
        }
        Some(())
    }

    /// Both sides of a cut, which are asked to cost `wanted` together; the features read, the records.
    fn cut(
        &self,
        orders: &Orders,
        depth: usize,
        (f, k): (usize, usize),
        wanted: i64,
    ) -> Option<(Known, Vec<usize>, String)> {
        let q = self.q;
        let parts = [true, false].map(|is_left| q.part(orders, &orders[f][..k], is_left));
        let mut known = Known { k, strict: [0; 2], relaxed: [0; 2] };
        let (mut tree, mut records) = (vec![f], [String::new(), String::new()]);
        let first = usize::from(parts[1][q.p].len() > k);
        for side in [first, 1 - first] {
            if depth == 2 {
                let stump = q.stump(&parts[side]);
                (known.strict[side], known.relaxed[side]) = (stump.strict, stump.relaxed);
                tree.extend(stump.feature);
                continue;
            }
            let proven = self.node(&parts[side], depth - 1, wanted - known.strict[1 - side])?;
            known.strict[side] = proven.bound;
            known.relaxed[side] = self.relaxed(proven.bound);
            tree.extend(proven.tree.into_iter().flatten());
            records[side] = proven.lines;
        }
        Some((known, tree, format!("L\n{}R\n{}", records[0], records[1])))
    }
}

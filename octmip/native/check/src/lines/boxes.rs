//! Boxes of root lines: each is closed by a bound or by all ways of parting its open samples, or it is cut in two.

use std::collections::HashMap;
use std::sync::Arc;

use super::sections::Section;
use super::{Cell, Chart, Checker, MOST, NO_TREE, Strip, Tally};
use crate::cursor::Cursor;
use crate::refusal::{Checked, Refusal, ensure, shown};

/// Boxes in boxes; a search needs some 300 at most: t is halved 35 times, heights lose an eighth at least.
const MOST_CUTS: usize = 1000;

/// A child of all roots of a box: what it costs at least, and the strips where its line must be, lest the tree cost the
/// claim anyway.
#[derive(Clone)]
struct Child {
    floor: i64,
    strips: Arc<Vec<Strip>>,
}

/// All root lines of a cell, and what is proven of their trees.
struct RootBox {
    chart: Chart,
    cell: Cell,
    /// Samples left of all the lines, and right of all of them.
    sides: [Vec<u32>; 2],
    /// Samples between.
    open: Vec<u32>,
    tallies: [Tally; 2],
    spare: Tally,
    children: [Child; 2],
    /// So many times it may still be cut.
    n_cuts: usize,
}

/// A line of a proof: its number and what stands behind the tag.
struct Entry<'a> {
    line: usize,
    rest: &'a str,
}

impl Entry<'_> {
    /// So many numbers, one blank between them.
    fn numbers<T: std::str::FromStr, const N: usize>(&self) -> Checked<[T; N]> {
        let numbers: Option<Vec<T>> = self.rest.split(' ').map(|word| word.parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        let reason = || format!("expected {N} numbers, got {}", shown(self.rest));
        numbers.ok_or_else(|| Refusal { line: self.line, reason: reason() })
    }

    /// Two costs.
    fn costs(&self) -> Checked<[i64; 2]> {
        self.numbers().map(|costs: [i64; 2]| costs.map(|cost| cost.clamp(0, NO_TREE)))
    }
}

impl Checker<'_> {
    /// Check the proof of all root lines of a chart, or of all single splits.
    pub(super) fn section(&self, section: &Section<'_>) -> Checked<()> {
        let mut cursor = section.cursor;
        if let Some(chart) = section.chart {
            let child = Child { floor: 0, strips: section.strips.clone() };
            let whole = Cell::whole(chart.1 == self.q.p);
            self.roots(self.root_box(chart, whole, [child.clone(), child], MOST_CUTS), &mut cursor)?;
        } else {
            let is_so = self.child_costs(&self.all(), self.need(), &section.strips, self.claim);
            ensure!(is_so, cursor.line(), "a single split is not proven to cost {}", self.claim);
        }
        let next = cursor.peek();
        ensure!(next.is_none(), cursor.line() + 1, "got {}, expected the next chart or end", shown(next.unwrap_or("")));
        Ok(())
    }

    fn root_box(&self, chart: Chart, cell: Cell, children: [Child; 2], n_cuts: usize) -> RootBox {
        let [left, open, right] = self.points.sorted(chart, &cell);
        let (tallies, spare) = ([self.tally(&left), self.tally(&right)], self.tally(&open));
        RootBox { chart, cell, sides: [left, right], open, tallies, spare, children, n_cuts }
    }

    /// Fewest samples in a leaf.
    fn need(&self) -> i64 {
        self.q.leaf_size as i64
    }

    /// What both children must cost together for a tree with a root over these features to cost the claim.
    fn owed(&self, chart: Chart) -> i64 {
        self.claim - self.price(chart)
    }

    /// Read the proof for the roots of a box and check it.
    fn roots(&self, mut roots: RootBox, cursor: &mut Cursor<'_>) -> Checked<()> {
        loop {
            let text = cursor.read().unwrap_or("nothing");
            let (tag, rest) = text.split_once(' ').unwrap_or((text, ""));
            let entry = Entry { line: cursor.line(), rest };
            match tag {
                "l" => self.learn_child(&mut roots, 0, &entry)?,
                "r" => self.learn_child(&mut roots, 1, &entry)?,
                "F" => return self.check_too_few(&roots, &entry),
                "N" => return self.check_narrow(&roots, &entry),
                "W" => return self.check_wide(&roots, &entry),
                "E" => return self.check_ways(&roots, &entry),
                "T" => return self.cut_at_slope(&roots, &entry, cursor),
                "R" => return self.cut_at_edge(&roots, &entry, cursor),
                _ => return Err(Refusal { line: entry.line, reason: format!("cannot read {} here", shown(text)) }),
            }
        }
    }

    /// `l` and `r`: what a child costs for its settled samples, and strips where it costs so much that the tree costs
    /// the claim.
    fn learn_child(&self, roots: &mut RootBox, side: usize, entry: &Entry<'_>) -> Checked<()> {
        let [floor, dead] = entry.costs()?;
        let mut costs = [0, 1].map(|s| roots.children[s].floor);
        costs[side] = dead;
        let is_dead = self.labels_due(costs, &roots.tallies, &roots.spare) >= self.owed(roots.chart);
        ensure!(is_dead, entry.line, "a child of {dead} does not bring the tree to the claim");
        let (ids, need) = (&roots.sides[side], self.need() - roots.open.len() as i64);
        let child = &roots.children[side];
        let kept = self.sift(ids, need, &child.strips, dead);
        let is_so = self.child_costs(ids, need, &kept, floor);
        ensure!(is_so, entry.line, "a child is not proven to cost {floor}");
        roots.children[side] = Child { floor: child.floor.max(floor), strips: Arc::new(kept) };
        Ok(())
    }

    /// `F`: too few samples for two leaves.
    fn check_too_few(&self, roots: &RootBox, entry: &Entry<'_>) -> Checked<()> {
        let n = |tally: &Tally| tally[self.q.n_classes];
        let is_so = roots.tallies.iter().any(|side| n(side) + n(&roots.spare) < self.need());
        ensure!(is_so, entry.line, "both children may hold {} samples", self.need());
        Ok(())
    }

    /// `N`: what the children cost for their settled samples, with what the labels owe.
    fn check_narrow(&self, roots: &RootBox, entry: &Entry<'_>) -> Checked<()> {
        let costs = entry.costs()?;
        self.check_bound(roots, self.labels_due(costs, &roots.tallies, &roots.spare), entry)?;
        let need = self.need() - roots.open.len() as i64;
        (0..2).try_for_each(|s| self.check_child(roots, s, (&roots.sides[s], need), costs[s], entry))
    }

    /// `W`: what the children cost for their settled and all open samples, less the most that the open ones can cost.
    fn check_wide(&self, roots: &RootBox, entry: &Entry<'_>) -> Checked<()> {
        let costs = entry.costs()?;
        self.check_bound(roots, costs[0] + costs[1] - self.most(&roots.spare), entry)?;
        let wide = |s: usize| [&roots.sides[s][..], &roots.open].concat();
        (0..2).try_for_each(|s| self.check_child(roots, s, (&wide(s), self.need()), costs[s], entry))
    }

    fn check_bound(&self, roots: &RootBox, bound: i64, entry: &Entry<'_>) -> Checked<()> {
        let price = self.price(roots.chart);
        ensure!(bound >= self.owed(roots.chart), entry.line, "this proves {}, not {}", bound + price, self.claim);
        Ok(())
    }

    /// Check what a child costs for some samples, with so many at least in each of two leaves.
    fn check_child(
        &self,
        roots: &RootBox,
        side: usize,
        (ids, need): (&[u32], i64),
        cost: i64,
        entry: &Entry<'_>,
    ) -> Checked<()> {
        let child = &roots.children[side];
        let is_so = cost <= child.floor || self.child_costs(ids, need, &child.strips, cost);
        ensure!(is_so, entry.line, "child {side} is not proven to cost {cost}");
        Ok(())
    }

    /// `T`: the two halves to both sides of a value of t.
    fn cut_at_slope(&self, roots: &RootBox, entry: &Entry<'_>, cursor: &mut Cursor<'_>) -> Checked<()> {
        let [t]: [f64; 1] = entry.numbers()?;
        let is_inside = roots.cell.t[0] < t && t < roots.cell.t[1];
        ensure!(is_inside, entry.line, "t = {t} is outside the cell");
        self.both_parts(roots, roots.cell.cut(t), entry, cursor)
    }

    /// `R`: the lines below and above an edge between two values of r.
    fn cut_at_edge(&self, roots: &RootBox, entry: &Entry<'_>, cursor: &mut Cursor<'_>) -> Checked<()> {
        let edge: [f64; 2] = entry.numbers()?;
        ensure!(edge.iter().all(|r| r.abs() < 8.0), entry.line, "the edge {edge:?} is beyond all values");
        self.both_parts(roots, roots.cell.split(edge), entry, cursor)
    }

    fn both_parts(&self, roots: &RootBox, cells: [Cell; 2], entry: &Entry<'_>, cursor: &mut Cursor<'_>) -> Checked<()> {
        ensure!(roots.n_cuts > 0, entry.line, "expected {MOST_CUTS} boxes in one another at most, got more");
        for cell in cells {
            let half = self.root_box(roots.chart, cell, roots.children.clone(), roots.n_cuts - 1);
            self.roots(half, cursor)?;
        }
        Ok(())
    }

    /// `E`: every way in which a line parts the open samples costs the claim.
    ///
    /// A way that the log leaves out has to be one that no line goes, with the settled samples on their sides.
    fn check_ways(&self, roots: &RootBox, entry: &Entry<'_>) -> Checked<()> {
        let plane = self.points.plane(roots.chart);
        let given: HashMap<&str, &str> = entry.rest.split(' ').filter_map(|word| word.split_once(':')).collect();
        let points = plane.end_points(&roots.open, MOST);
        ensure!(points.is_some(), entry.line, "{} open samples are too many to part", roots.open.len());
        let points = points.unwrap_or_default();
        let places = plane.places(&points, &roots.open);
        for way in plane.ways(&points, roots.cell.t[0], roots.cell.t[1]) {
            let parts = [0, 1].map(|s| roots.part(s, &way, &places));
            let name: String = way.iter().map(|&is_left| if is_left { '1' } else { '0' }).collect();
            let is_too_small = parts.iter().any(|ids| (ids.len() as i64) < self.need());
            match given.get(name.as_str()) {
                _ if is_too_small => {}
                Some(cost) => self.check_way(roots, &parts, (&name, cost), entry)?,
                None => {
                    let is_gone = plane.can_part(&parts[0], &parts[1]);
                    ensure!(!is_gone, entry.line, "the way {name} is left out, but a line goes it");
                }
            }
        }
        Ok(())
    }

    /// Check that the left child costs what a way says, and the right one what is owed besides.
    fn check_way(
        &self,
        roots: &RootBox,
        parts: &[Vec<u32>; 2],
        (name, cost): (&str, &str),
        entry: &Entry<'_>,
    ) -> Checked<()> {
        let left = cost.parse::<i64>().unwrap_or(0).clamp(0, NO_TREE);
        let costs = [left, self.owed(roots.chart) - left];
        let is_so = |s: usize| self.child_costs(&parts[s], self.need(), &roots.children[s].strips, costs[s]);
        ensure!((0..2).all(is_so), entry.line, "the way {name} is not proven to cost {}", self.claim);
        Ok(())
    }
}

impl RootBox {
    /// The samples of a side, with those of the open ones that a way of parting their points sends there.
    fn part(&self, side: usize, way: &[bool], places: &[usize]) -> Vec<u32> {
        let chosen = self.open.iter().zip(places).filter(|(_, place)| way[**place] == (side == 0));
        self.sides[side].iter().chain(chosen.map(|(i, _)| i)).copied().collect()
    }
}

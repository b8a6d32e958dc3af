//! Nodes: regions of root lines. Each is closed by a bound or by all dichotomies of its open samples, or cut in two.

use std::collections::HashMap;
use std::sync::Arc;

use super::checker::{Checker, DualPlane, MOST, NO_TREE, SlopeInterval, Tally};
use super::region::Region;
use super::sections::Section;
use crate::log::cursor::Cursor;
use crate::refusal::{Checked, Refusal, ensure, shown};

/// Most nodes within one another; a search needs some 300: t is halved 35 times, heights lose an eighth at least.
const MOST_CUTS: usize = 1000;

/// A child of all roots of a node: a lower bound of its cost, and the slope intervals outside which its line makes the
/// tree cost the claim.
#[derive(Clone)]
struct Child {
    floor: i64,
    intervals: Arc<Vec<SlopeInterval>>,
}

/// All root lines of a region, and what is proven of their trees.
struct Node {
    dual_plane: DualPlane,
    region: Region,
    /// Samples left of all the lines, and right of all of them.
    sides: [Vec<u32>; 2],
    /// Samples between.
    open: Vec<u32>,
    tallies: [Tally; 2],
    spare: Tally,
    children: [Child; 2],
    /// Number of times that it may still be cut.
    n_cuts: usize,
}

/// A line of a proof: its number and what stands behind the tag.
struct Entry<'a> {
    line: usize,
    rest: &'a str,
}

impl Entry<'_> {
    /// The numbers of the line, of which there must be N with one blank between them.
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
    /// Check the proof of all root lines of a dual plane, or of all single splits.
    pub(super) fn section(&self, section: &Section<'_>) -> Checked<()> {
        let mut cursor = section.cursor;
        if let Some(dual_plane) = section.dual_plane {
            let child = Child { floor: 0, intervals: section.intervals.clone() };
            let whole = Region::whole(dual_plane.1 == self.q.p);
            self.node(self.node_of(dual_plane, whole, [child.clone(), child], MOST_CUTS), &mut cursor)?;
        } else {
            let is_so = self.child_costs(&self.all(), self.need(), &section.intervals, self.claim);
            ensure!(is_so, cursor.line(), "a single split is not proven to cost {}", self.claim);
        }
        let next = cursor.peek();
        ensure!(
            next.is_none(),
            cursor.line() + 1,
            "got {}, expected the next dual plane or end",
            shown(next.unwrap_or(""))
        );
        Ok(())
    }

    fn node_of(&self, dual_plane: DualPlane, region: Region, children: [Child; 2], n_cuts: usize) -> Node {
        let [left, open, right] = self.points.sorted(dual_plane, &region);
        let (tallies, spare) = ([self.tally(&left), self.tally(&right)], self.tally(&open));
        Node { dual_plane, region, sides: [left, right], open, tallies, spare, children, n_cuts }
    }

    /// Cost that both children must reach together for a tree with a root over these features to cost the claim.
    fn owed(&self, dual_plane: DualPlane) -> i64 {
        self.claim - self.price(dual_plane)
    }

    /// Read the proof of a node and check it.
    fn node(&self, mut node: Node, cursor: &mut Cursor<'_>) -> Checked<()> {
        loop {
            let text = cursor.read().unwrap_or("nothing");
            let (tag, rest) = text.split_once(' ').unwrap_or((text, ""));
            let entry = Entry { line: cursor.line(), rest };
            match tag {
                "l" => self.learn_child(&mut node, 0, &entry)?,
                "r" => self.learn_child(&mut node, 1, &entry)?,
                "F" => return self.check_too_few(&node, &entry),
                "N" => return self.check_narrow(&node, &entry),
                "W" => return self.check_wide(&node, &entry),
                "E" => return self.check_dichotomies(&node, &entry),
                "T" => return self.cut_at_slope(&node, &entry, cursor),
                "R" => return self.cut_at_edge(&node, &entry, cursor),
                _ => return Err(Refusal { line: entry.line, reason: format!("cannot read {} here", shown(text)) }),
            }
        }
    }

    /// `l` and `r`: a bound of a child for its settled samples, and a cost of the child that brings the tree to the
    /// claim: intervals where it costs that much are left out.
    fn learn_child(&self, node: &mut Node, side: usize, entry: &Entry<'_>) -> Checked<()> {
        let [floor, dead] = entry.costs()?;
        let mut costs = [0, 1].map(|s| node.children[s].floor);
        costs[side] = dead;
        let is_dead = self.label_count_bound(costs, &node.tallies, &node.spare) >= self.owed(node.dual_plane);
        ensure!(is_dead, entry.line, "a child of {dead} does not bring the tree to the claim");
        let (ids, need) = (&node.sides[side], self.need() - node.open.len() as i64);
        let child = &node.children[side];
        let kept = self.sift(ids, need, &child.intervals, dead);
        let is_so = self.child_costs(ids, need, &kept, floor);
        ensure!(is_so, entry.line, "a child is not proven to cost {floor}");
        node.children[side] = Child { floor: child.floor.max(floor), intervals: Arc::new(kept) };
        Ok(())
    }

    /// `F`: too few samples for two leaves.
    fn check_too_few(&self, node: &Node, entry: &Entry<'_>) -> Checked<()> {
        let n = |tally: &Tally| tally[self.q.n_classes];
        let is_so = node.tallies.iter().any(|side| n(side) + n(&node.spare) < self.need());
        ensure!(is_so, entry.line, "both children may hold {} samples", self.need());
        Ok(())
    }

    /// `N`: bounds of the children for their settled samples, joined by the label-count bound.
    fn check_narrow(&self, node: &Node, entry: &Entry<'_>) -> Checked<()> {
        let costs = entry.costs()?;
        self.check_bound(node, self.label_count_bound(costs, &node.tallies, &node.spare), entry)?;
        let need = self.need() - node.open.len() as i64;
        (0..2).try_for_each(|s| self.check_child(node, s, (&node.sides[s], need), costs[s], entry))
    }

    /// `W`: bounds of the children for their settled and all open samples, less the most that the open ones can cost.
    fn check_wide(&self, node: &Node, entry: &Entry<'_>) -> Checked<()> {
        let costs = entry.costs()?;
        self.check_bound(node, costs[0] + costs[1] - self.most(&node.spare), entry)?;
        let wide = |s: usize| [&node.sides[s][..], &node.open].concat();
        (0..2).try_for_each(|s| self.check_child(node, s, (&wide(s), self.need()), costs[s], entry))
    }

    fn check_bound(&self, node: &Node, bound: i64, entry: &Entry<'_>) -> Checked<()> {
        let price = self.price(node.dual_plane);
        ensure!(bound >= self.owed(node.dual_plane), entry.line, "this proves {}, not {}", bound + price, self.claim);
        Ok(())
    }

    /// Check a bound of a child for some samples, with at least `need` in each of two leaves.
    fn check_child(
        &self,
        node: &Node,
        side: usize,
        (ids, need): (&[u32], i64),
        cost: i64,
        entry: &Entry<'_>,
    ) -> Checked<()> {
        let child = &node.children[side];
        let is_so = cost <= child.floor || self.child_costs(ids, need, &child.intervals, cost);
        ensure!(is_so, entry.line, "child {side} is not proven to cost {cost}");
        Ok(())
    }

    /// `T`: the two halves to both sides of a value of t.
    fn cut_at_slope(&self, node: &Node, entry: &Entry<'_>, cursor: &mut Cursor<'_>) -> Checked<()> {
        let [t]: [f64; 1] = entry.numbers()?;
        let is_inside = node.region.t[0] < t && t < node.region.t[1];
        ensure!(is_inside, entry.line, "t = {t} is outside the region");
        self.both_parts(node, node.region.cut(t), entry, cursor)
    }

    /// `R`: the lines below and above an edge between two values of r.
    fn cut_at_edge(&self, node: &Node, entry: &Entry<'_>, cursor: &mut Cursor<'_>) -> Checked<()> {
        let edge: [f64; 2] = entry.numbers()?;
        ensure!(edge.iter().all(|r| r.abs() < 8.0), entry.line, "the edge {edge:?} is beyond all values");
        self.both_parts(node, node.region.split(edge), entry, cursor)
    }

    fn both_parts(&self, node: &Node, regions: [Region; 2], entry: &Entry<'_>, cursor: &mut Cursor<'_>) -> Checked<()> {
        ensure!(node.n_cuts > 0, entry.line, "expected {MOST_CUTS} nodes in one another at most, got more");
        for region in regions {
            let half = self.node_of(node.dual_plane, region, node.children.clone(), node.n_cuts - 1);
            self.node(half, cursor)?;
        }
        Ok(())
    }

    /// `E`: every dichotomy of the open samples by a line costs the claim.
    ///
    /// A dichotomy that the log leaves out has to be one that no line makes, with the settled samples on their sides.
    fn check_dichotomies(&self, node: &Node, entry: &Entry<'_>) -> Checked<()> {
        let plane = self.points.plane(node.dual_plane);
        let given: HashMap<&str, &str> = entry.rest.split(' ').filter_map(|word| word.split_once(':')).collect();
        let points = plane.end_points(&node.open, MOST);
        ensure!(points.is_some(), entry.line, "{} open samples are too many to part", node.open.len());
        let points = points.unwrap_or_default();
        let places = plane.places(&points, &node.open);
        for dichotomy in plane.dichotomies(&points, node.region.t[0], node.region.t[1]) {
            let parts = [0, 1].map(|s| node.part(s, &dichotomy, &places));
            let name: String = dichotomy.iter().map(|&is_left| if is_left { '1' } else { '0' }).collect();
            let is_too_small = parts.iter().any(|ids| (ids.len() as i64) < self.need());
            match given.get(name.as_str()) {
                _ if is_too_small => {}
                Some(cost) => self.check_dichotomy(node, &parts, (&name, cost), entry)?,
                None => {
                    let is_made = plane.can_part(&parts[0], &parts[1]);
                    ensure!(!is_made, entry.line, "the dichotomy {name} is left out, but a line makes it");
                }
            }
        }
        Ok(())
    }

    /// Check that the left child costs what a dichotomy says, and the right one what is owed besides.
    fn check_dichotomy(
        &self,
        node: &Node,
        parts: &[Vec<u32>; 2],
        (name, cost): (&str, &str),
        entry: &Entry<'_>,
    ) -> Checked<()> {
        let left = cost.parse::<i64>().unwrap_or(0).clamp(0, NO_TREE);
        let costs = [left, self.owed(node.dual_plane) - left];
        let is_so = |s: usize| self.child_costs(&parts[s], self.need(), &node.children[s].intervals, costs[s]);
        ensure!((0..2).all(is_so), entry.line, "the dichotomy {name} is not proven to cost {}", self.claim);
        Ok(())
    }
}

impl Node {
    /// The samples of a side, with those of the open ones that a dichotomy of their points sends there.
    fn part(&self, side: usize, dichotomy: &[bool], places: &[usize]) -> Vec<u32> {
        let chosen = self.open.iter().zip(places).filter(|(_, place)| dichotomy[**place] == (side == 0));
        self.sides[side].iter().chain(chosen.map(|(i, _)| i)).copied().collect()
    }
}

//! Both sides of a cut of a monotone feature: the tree of one side is laid out leaf by leaf, the other side is solved
//! beside its leaves.
//!
//! The nodes of the first side are decided in preorder. After each leaf the other side is solved beside the leaves that
//! are decided: what it costs at least, with the bounds of the nodes still open, ends a branch early.
//!
//! Places of thresholds: those of the first side are moved as in `monotone`, together with those of the other side, so
//! a place may be the rank of any sample of the two. A split is laid out with the interval of its places, and the boxes
//! of its sides are those that it leaves for sure: boxes compare no more leaves than the smaller ones inside them, so
//! what the other side costs beside those is a bound for every place. Only where that does not end a branch, and
//! neither the first places nor the last ones will do, the widest interval is halved.

use crate::shaped::boxes::{Fixed, labels, side};
use crate::shaped::few::least_size;
use crate::shaped::monotone::{Cut, Found, Monotone, Node, ends_of};
use octmip_frame::tree::Tree;

/// A node of the first side that is not yet decided: what it costs at least.
#[derive(Debug, Clone)]
struct Open {
    node: Node,
    depth: usize,
    bound: i64,
}

/// A decision of the first side, in preorder: a label, or a feature with the first and the last place of its cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Decided {
    Leaf(u32),
    Split(usize, [u32; 2]),
}

/// The first side as far as it is laid out, and the best pair so far.
struct Layout<'n> {
    first: &'n Node,
    other: &'n Node,
    depth: usize,
    /// Ranks at which thresholds of each usable feature may lie.
    places: Vec<Vec<u32>>,
    /// Decided leaves, those of the rest of the tree first: so many.
    fixed: Vec<Fixed>,
    n_outer: usize,
    decided: Vec<Decided>,
    /// Both sides together must cost less.
    upper: i64,
    best: Option<((i64, Tree), (i64, Tree))>,
}

/// What the first side costs so far, its splits that are left, and what the other side costs at least.
#[derive(Debug, Clone, Copy)]
struct Sum {
    cost: i64,
    splits: usize,
    other: i64,
}

impl Layout<'_> {
    /// The places of a feature between two, those included.
    fn places_between(&self, f: usize, [first, last]: [u32; 2]) -> &[u32] {
        let all = &self.places[f];
        &all[all.partition_point(|&place| place < first)..all.partition_point(|&place| place <= last)]
    }
}

impl Monotone<'_> {
    /// The best trees of both sides of a cut that are in order, if they cost less than `upper` together.
    pub(super) fn coupled(
        &mut self,
        node: &Node,
        sides: &[Node; 2],
        (depth, splits): (usize, usize),
        fixed: &[Fixed],
        bounds: [i64; 2],
        upper: i64,
    ) -> Option<((i64, Tree), (i64, Tree))> {
        let first = usize::from(sides[1].view.len < sides[0].view.len); // fewer samples have fewer trees
        let mut layout = Layout {
            first: &sides[first],
            other: &sides[1 - first],
            depth,
            places: self.places_of(node, fixed),
            fixed: fixed.to_vec(),
            n_outer: fixed.len(),
            decided: Vec::new(),
            upper,
            best: None,
        };
        let open = Open { node: sides[first].clone(), depth, bound: bounds[first] };
        let sum = Sum { cost: 0, splits, other: bounds[1 - first] };
        self.lay_out(&mut layout, &mut vec![open], sum);
        let (own, other) = layout.best?;
        Some(if first == 0 { (own, other) } else { (other, own) })
    }

    fn places_of(&self, node: &Node, fixed: &[Fixed]) -> Vec<Vec<u32>> {
        let of_feature = |f: usize| {
            let ranks = self.samples.ranks_of(f);
            let mut places: Vec<u32> = node.view.list(f).iter().map(|&i| ranks[i as usize]).collect();
            places.extend(ends_of(fixed, f));
            places.sort_unstable();
            places.dedup();
            places
        };
        (0..self.samples.p).map(of_feature).collect()
    }

    /// Decide the next open node in every way that may lead to less than the best pair.
    fn lay_out(&mut self, layout: &mut Layout<'_>, open: &mut Vec<Open>, sum: Sum) {
        let rest: i64 = open.iter().map(|open| open.bound).sum();
        if sum.cost + rest + sum.other >= layout.upper || self.is_stopped() {
            return;
        }
        let Some(next) = open.pop() else { return self.complete(layout, sum) };
        self.as_leaf(layout, open, &next, rest - next.bound, sum);
        self.as_split(layout, open, &next, rest - next.bound, sum);
        open.push(next);
    }

    /// The first side is laid out: the best places of its cuts with the best other side.
    fn complete(&mut self, layout: &mut Layout<'_>, sum: Sum) {
        let size = (layout.depth, sum.splits);
        let found = self.solve(layout.other, size, &layout.fixed, layout.upper - sum.cost);
        let Some(other) = found else { return };
        for end in [0, 1] {
            let places = layout.decided.iter().map(|one| match *one {
                Decided::Split(f, ends) => Decided::Split(f, [ends[end]; 2]),
                leaf @ Decided::Leaf(_) => leaf,
            });
            let placed: Vec<Decided> = places.collect();
            let Some(fixed) = self.boxes(layout, &placed) else { continue };
            if self.keeps_order(layout.other, &other.1, &fixed) {
                layout.upper = sum.cost + other.0;
                layout.best = Some(((sum.cost, self.tree(&mut placed.iter())), other));
                return;
            }
        }
        let Some((k, halves)) = self.widest(layout, &other.1) else { return };
        let (decided, fixed) = (layout.decided[k], layout.fixed.clone());
        for half in halves {
            layout.decided[k] = half;
            if let Some(fixed) = self.boxes(layout, &layout.decided) {
                layout.fixed = fixed;
                self.complete(layout, sum);
            }
        }
        layout.decided[k] = decided;
        layout.fixed = fixed;
    }

    /// The decided leaves with the boxes that splits leave them for sure; None where they break the order.
    fn boxes(&self, layout: &Layout<'_>, decided: &[Decided]) -> Option<Vec<Fixed>> {
        let mut fixed = layout.fixed[..layout.n_outer].to_vec();
        let mut open = vec![layout.first.bounds.clone()];
        for one in decided {
            let bounds = open.pop()?;
            match *one {
                Decided::Leaf(label) => {
                    let [low, high] = labels(&bounds, &fixed, &self.directions, self.n_labels);
                    (low..=high).contains(&label).then_some(())?;
                    fixed.push(Fixed { bounds, label });
                }
                Decided::Split(f, places) => open.extend([1, 0].map(|s| side(&bounds, f, places[s], s))),
            }
        }
        Some(fixed)
    }

    /// The split with the most places and its halves; one of a feature that the other side reads comes first.
    fn widest(&self, layout: &Layout<'_>, other: &Tree) -> Option<(usize, [Decided; 2])> {
        let width = |&k: &usize| match layout.decided[k] {
            Decided::Split(f, places) => {
                let n = layout.places_between(f, places).len();
                (n > 1).then_some((other.reads(self.samples.features[f]), n))
            }
            Decided::Leaf(_) => None,
        };
        let k = (0..layout.decided.len()).max_by_key(width).filter(|k| width(k).is_some())?;
        let Decided::Split(f, ends) = layout.decided[k] else { return None };
        let places = layout.places_between(f, ends);
        let (low, high) = places.split_at(places.len() / 2);
        Some((k, [low, high].map(|half| Decided::Split(f, [half[0], half[half.len() - 1]]))))
    }

    fn as_leaf(&mut self, layout: &mut Layout<'_>, open: &mut Vec<Open>, next: &Open, rest: i64, sum: Sum) {
        let [low, high] = labels(&next.node.bounds, &layout.fixed, &self.directions, self.n_labels);
        let costs = self.label_costs(&next.node);
        for label in low..=high {
            let cost = sum.cost + costs[label as usize];
            // Two leaves of one label under a split are one leaf, which costs no more.
            let is_twin = matches!(layout.decided[..], [.., Decided::Split(..), Decided::Leaf(twin)] if twin == label);
            if is_twin || cost + rest + sum.other >= layout.upper {
                continue;
            }
            layout.fixed.push(Fixed { bounds: next.node.bounds.clone(), label });
            layout.decided.push(Decided::Leaf(label));
            let other = match open.is_empty() {
                true => Some(sum.other), // solved when complete
                false => self.other(layout, sum.splits, layout.upper - cost - rest),
            };
            if let Some(other) = other {
                self.lay_out(layout, open, Sum { cost, other: other.max(sum.other), ..sum });
            }
            layout.fixed.pop();
            layout.decided.pop();
        }
    }

    /// What the other side costs at least beside the decided leaves, None where that is `budget` or more.
    fn other(&mut self, layout: &Layout<'_>, splits: usize, budget: i64) -> Option<i64> {
        let found: Found = self.solve(layout.other, (layout.depth, splits), &layout.fixed, budget);
        found.map(|(cost, _)| cost)
    }

    fn as_split(&mut self, layout: &mut Layout<'_>, open: &mut Vec<Open>, next: &Open, rest: i64, sum: Sum) {
        let (depth, _) = least_size(next.depth, sum.splits);
        let budget = layout.upper - sum.cost - rest - sum.other;
        if depth == 0 || budget <= self.penalty || !self.can_split(&next.node) {
            return;
        }
        let Some(cuts) = self.cuts(&next.node, depth, budget) else { return };
        let sum = Sum { cost: sum.cost + self.penalty, splits: sum.splits - 1, ..sum };
        for &cut in cuts.iter() {
            if sum.cost + cut.bounds[0] + cut.bounds[1] + rest + sum.other >= layout.upper || self.is_stopped() {
                break;
            }
            self.at_cut(layout, open, next, &cut, sum);
        }
    }

    fn at_cut(&mut self, layout: &mut Layout<'_>, open: &mut Vec<Open>, next: &Open, cut: &Cut, sum: Sum) {
        // The first is the rank of a sample, so there is one.
        let places = layout.places_between(cut.feature, self.ends(&next.node, cut));
        let places = [places[0], places[places.len() - 1]];
        let views = self.split(&next.node, cut);
        for s in [1, 0] {
            let node = Node { view: views[s].clone(), bounds: side(&next.node.bounds, cut.feature, places[s], s) };
            open.push(Open { node, depth: next.depth - 1, bound: cut.bounds[s] });
        }
        layout.decided.push(Decided::Split(cut.feature, places));
        self.lay_out(layout, open, sum);
        layout.decided.pop();
        open.truncate(open.len() - 2);
    }

    fn tree<'d>(&self, decided: &mut impl Iterator<Item = &'d Decided>) -> Tree {
        match decided.next() {
            Some(Decided::Split(feature, [place, _])) => {
                let [left, right] = [self.tree(decided), self.tree(decided)];
                Tree::join(self.samples.features[*feature], *place, &left, &right)
            }
            Some(Decided::Leaf(label)) => Tree::leaf(*label),
            None => Tree::leaf(0), // every split has two sides
        }
    }
}

//! The tree during a search: nodes in an arena, every leaf holding the samples that reach it.

use crate::gains::prices::Prices;
use crate::gains::tally::Tally;
use crate::tree::rule::Rule;
use octmip_check::problem::Problem;
use octmip_frame::tree::{Node as Row, Tree};

/// A node of the arena.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    /// Its rule.
    pub(crate) rule: Rule,
    /// Left and right child; 0 in a leaf.
    pub(crate) children: [u32; 2],
    /// Samples of a leaf; empty in a split.
    pub(crate) samples: Vec<u32>,
}

/// The tree with its samples. Node 0 is the root; nodes cut off stay behind until `compact`.
#[derive(Debug, Clone)]
pub(crate) struct State {
    /// The arena.
    pub(crate) nodes: Vec<Node>,
}

impl State {
    /// One leaf with all samples.
    pub(crate) fn leaf(problem: &Problem) -> Self {
        Self { nodes: vec![Node { rule: Rule::Leaf, children: [0; 2], samples: (0..problem.n as u32).collect() }] }
    }

    /// The state of a finished tree.
    pub(crate) fn from_tree(problem: &Problem, tree: &Tree) -> Self {
        let mut state = Self::leaf(problem);
        state.attach(problem, 0, tree);
        state
    }

    /// Put a finished tree in the place of leaf `v`; its samples go where the tree sends them, empty sides vanish.
    pub(crate) fn attach(&mut self, problem: &Problem, v: u32, tree: &Tree) {
        self.attach_row(problem, v, tree, 0);
    }

    fn attach_row(&mut self, problem: &Problem, v: u32, tree: &Tree, row: u32) {
        let (rule, children) = match &tree.nodes[row as usize] {
            Row::Leaf { .. } => return,
            Row::Split { feature, cut, left, right } => (Rule::Axis { feature: *feature, cut: *cut }, [*left, *right]),
            Row::Hyperplane { terms, offset, left, right } => {
                (Rule::Plane { terms: terms.clone(), offset: *offset }, [*left, *right])
            }
        };
        let n_left = self.nodes[v as usize].samples.iter().filter(|&&i| rule.goes_left(problem, i)).count();
        if n_left == 0 || n_left == self.nodes[v as usize].samples.len() {
            return self.attach_row(problem, v, tree, children[usize::from(n_left == 0)]);
        }
        let [left, right] = self.split(problem, v, rule);
        self.attach_row(problem, left, tree, children[0]);
        self.attach_row(problem, right, tree, children[1]);
    }

    /// Split leaf `v`; returns its new leaves.
    pub(crate) fn split(&mut self, problem: &Problem, v: u32, rule: Rule) -> [u32; 2] {
        let samples = std::mem::take(&mut self.nodes[v as usize].samples);
        let (left, right) = samples.into_iter().partition(|&i| rule.goes_left(problem, i));
        let first = self.nodes.len() as u32;
        for samples in [left, right] {
            self.nodes.push(Node { rule: Rule::Leaf, children: [0; 2], samples });
        }
        self.nodes[v as usize].rule = rule;
        self.nodes[v as usize].children = [first, first + 1];
        [first, first + 1]
    }

    /// Whether `v` is a leaf.
    pub(crate) fn is_leaf(&self, v: u32) -> bool {
        self.nodes[v as usize].rule == Rule::Leaf
    }

    /// The nodes at and below `v` in preorder.
    pub(crate) fn below(&self, v: u32) -> Vec<u32> {
        let (mut found, mut stack) = (Vec::new(), vec![v]);
        while let Some(node) = stack.pop() {
            found.push(node);
            if !self.is_leaf(node) {
                let [left, right] = self.nodes[node as usize].children;
                stack.extend([right, left]);
            }
        }
        found
    }

    /// The leaves at and below `v`, from left to right.
    pub(crate) fn leaves(&self, v: u32) -> Vec<u32> {
        self.below(v).into_iter().filter(|&node| self.is_leaf(node)).collect()
    }

    /// The samples that reach `v`.
    pub(crate) fn samples(&self, v: u32) -> Vec<u32> {
        self.leaves(v).iter().flat_map(|&leaf| &self.nodes[leaf as usize].samples).copied().collect()
    }

    /// The leaf at or below `v` that a sample would reach from there.
    #[inline]
    pub(crate) fn route(&self, problem: &Problem, v: u32, sample: u32) -> u32 {
        let mut v = v;
        loop {
            let node = &self.nodes[v as usize];
            if node.rule == Rule::Leaf {
                return v;
            }
            v = node.children[usize::from(!node.rule.goes_left(problem, sample))];
        }
    }

    /// The nodes from the root to `v`, both included; none when `v` is cut off.
    pub(crate) fn path(&self, v: u32) -> Option<Vec<u32>> {
        let mut path = vec![0];
        self.descend(v, &mut path).then_some(path)
    }

    fn descend(&self, v: u32, path: &mut Vec<u32>) -> bool {
        let last = path[path.len() - 1];
        if last == v {
            return true;
        }
        if !self.is_leaf(last) {
            for child in self.nodes[last as usize].children {
                path.push(child);
                if self.descend(v, path) {
                    return true;
                }
                path.pop();
            }
        }
        false
    }

    /// Features summed over the splits at and below `v`.
    pub(crate) fn complexity(&self, v: u32) -> i64 {
        self.below(v).iter().map(|&node| self.nodes[node as usize].rule.size() as i64).sum()
    }

    /// Send samples down from `v` again, after rules at or below it have changed.
    pub(crate) fn reroute(&mut self, problem: &Problem, v: u32, samples: Vec<u32>) {
        for leaf in self.leaves(v) {
            self.nodes[leaf as usize].samples.clear();
        }
        for i in samples {
            let leaf = self.route(problem, v, i);
            self.nodes[leaf as usize].samples.push(i);
        }
    }

    /// Make `v` a leaf with all its samples.
    pub(crate) fn collapse(&mut self, v: u32) {
        let samples = self.samples(v);
        self.nodes[v as usize] = Node { rule: Rule::Leaf, children: [0; 2], samples };
    }

    /// Put the node `child` below `v` in the place of `v`; the caller has already moved the samples.
    pub(crate) fn promote(&mut self, v: u32, child: u32) {
        let empty = Node { rule: Rule::Leaf, children: [0; 2], samples: Vec::new() };
        self.nodes[v as usize] = std::mem::replace(&mut self.nodes[child as usize], empty);
    }

    /// Remove the splits at and below `v` that send all their samples to one side.
    pub(crate) fn remove_empty_sides(&mut self, v: u32) {
        while !self.is_leaf(v) {
            let [left, right] = self.nodes[v as usize].children;
            self.remove_empty_sides(left);
            self.remove_empty_sides(right);
            let is_empty = |node: u32| self.is_leaf(node) && self.nodes[node as usize].samples.is_empty();
            match (is_empty(left), is_empty(right)) {
                (true, _) => self.promote(v, right),
                (_, true) => self.promote(v, left),
                _ => return,
            }
        }
    }

    /// Drop the nodes that were cut off.
    pub(crate) fn compact(&mut self) {
        let kept = self.below(0);
        let mut position = vec![0; self.nodes.len()];
        for (new, &old) in kept.iter().enumerate() {
            position[old as usize] = new as u32;
        }
        let mut nodes: Vec<Option<Node>> = std::mem::take(&mut self.nodes).into_iter().map(Some).collect();
        self.nodes = kept.iter().filter_map(|&old| nodes[old as usize].take()).collect();
        for node in &mut self.nodes {
            node.children = node.children.map(|child| position[child as usize]);
        }
    }

    /// The objective, recounted from the samples in the leaves.
    pub(crate) fn objective(&self, prices: &Prices) -> i64 {
        self.cost_below(prices, 0)
    }

    /// Cost of the samples at and below `v`, with the price of the splits there.
    pub(crate) fn cost_below(&self, prices: &Prices, v: u32) -> i64 {
        let mut tally = Tally::new(prices);
        let mut cost = prices.price(self.complexity(v));
        for leaf in self.leaves(v) {
            tally.clear(1);
            for &i in &self.nodes[leaf as usize].samples {
                tally.add(0, prices.weighed(i));
                cost += prices.highest_cost_of(i);
            }
            cost -= tally.total;
        }
        cost
    }

    /// The finished tree, leaves labelled with their cheapest class (the lowest of equals).
    pub(crate) fn to_tree(&self, prices: &Prices) -> Tree {
        let order = self.below(0);
        let mut position = vec![0; self.nodes.len()];
        for (row, &node) in order.iter().enumerate() {
            position[node as usize] = row as u32;
        }
        let mut tally = Tally::new(prices);
        let mut row = |v: &u32| {
            let node = &self.nodes[*v as usize];
            let [left, right] = node.children.map(|child| position[child as usize]);
            match &node.rule {
                Rule::Leaf => {
                    tally.clear(1);
                    node.samples.iter().for_each(|&i| tally.add(0, prices.weighed(i)));
                    Row::Leaf { label: tally.label(0) }
                }
                Rule::Axis { feature, cut } => Row::Split { feature: *feature, cut: *cut, left, right },
                Rule::Plane { terms, offset } => Row::Hyperplane { terms: terms.clone(), offset: *offset, left, right },
            }
        };
        Tree { nodes: order.iter().map(&mut row).collect() }
    }
}

//! Depth 3: regions of root lines as at depth 2, with the proof of depth 2 itself as the bound of a child.
//!
//! With L, R, O the samples that a region sends left, sends right, leaves open, and LESS the least cost of a tree of
//! one level less, every tree with a root of the region costs at least `LESS(L) + LESS(R)`: dropping samples lowers no
//! optimum. A leaf size of m asks for m samples with the open ones, of L and R alone for m less those.
//!
//! A child is asked only whether it costs what the target still lacks, so most proofs of depth 2 end early. They are
//! dear all the same: regions are halved unasked until few enough samples are open for them to be worth it.

use std::time::Instant;

use crate::depth_two::solve_depth_two;
use crate::geometry::line::Line;
use crate::instance::Instance;
use crate::label_count::labels_at_least;
use crate::line_tree::{LineTree, join, split_node, to_tree};
use crate::loss::INFEASIBLE;
use crate::nodes::known::{Known, Lessons};
use crate::nodes::node::{Partition, SearchContext};
use crate::options::Options;
use crate::regions::dichotomies::{Dichotomies, End, end_of};
use crate::regions::realisation::{Realisation, Separability, realise};
use crate::regions::region::{Region, split};
use crate::subproblem::{child_of, objective};
use octmip_check::problem::Problem;
use octmip_frame::control::{KeepGoing, Limits, Outcome, Progress, Stop};
use octmip_frame::supervise::{POLL, Supervision};
use octmip_frame::tree::Tree;

/// Slope intervals of the tables, which serve to halve regions.
const N_INTERVALS: usize = 64;
/// Most bounds of sets that are kept.
const MOST_SETS: usize = 3000;
/// Share of the samples that may be open for a child to be asked, at first; what that brings moves it.
const OPEN_SHARE: f64 = 1.0 / 16.0;
/// Factors of that number when a child closed the node, and when it did not.
const CLOSED: f64 = 1.05;
const LEFT_OPEN: f64 = 0.85;
/// Least number of open samples at which a child is always asked.
const ALWAYS_ASKED: f64 = 8.0;

/// A region of root lines, with lower bounds of both children and of the tree.
#[derive(Debug, Clone)]
struct Node {
    dual_plane: usize,
    region: Region,
    floors: [i64; 2],
    key: i64,
}

/// What a child costs at least, and its best tree where that is less than was asked for.
struct Child {
    bound: i64,
    tree: Option<Tree>,
}

struct Search<'a, 'k> {
    context: &'a SearchContext<'a>,
    supervision: &'a Supervision,
    options: &'a Options,
    keep_going: KeepGoing<'k>,
    polled: Instant,
    known: Known,
    open_limit: f64,
    stack: Vec<Node>,
    aside: Vec<Node>,
    target: i64,
    undecided: i64,
    upper: i64,
    best: Option<(Tree, i64)>,
    n_nodes: u64,
}

/// Find the best tree of depth 3 over all features of a problem without a budget.
pub(crate) fn solve_depth_three(
    problem: &Problem,
    instance: &Instance,
    supervision: &Supervision,
    options: &Options,
    keep_going: KeepGoing,
) -> Outcome {
    let leaf = to_tree(problem, instance, &LineTree::Leaf);
    let (tree, objective) = leaf.unwrap_or((Tree::leaf(0), INFEASIBLE));
    let upper = options.known.unwrap_or(objective).min(objective);
    let Some(context) = SearchContext::new(problem, instance, N_INTERVALS, supervision.flag()) else {
        let stop = supervision.reason().unwrap_or(Stop::Interrupted);
        return Outcome { tree, objective, bound: 0, stop, n_nodes: 0 };
    };
    let roots = context.dual_planes.iter().enumerate().map(|(dual_plane, table)| Node {
        dual_plane,
        region: table.whole(),
        floors: [0, 0],
        key: 0,
    });
    let mut search = Search {
        context: &context,
        supervision,
        options,
        keep_going,
        polled: Instant::now(),
        known: Known::with_sets(instance, MOST_SETS),
        open_limit: (problem.n as f64 * OPEN_SHARE).max(ALWAYS_ASKED),
        stack: roots.collect(),
        aside: Vec::new(),
        target: 0,
        undecided: i64::MAX,
        upper,
        best: None,
        n_nodes: 0,
    };
    let stop = search.run();
    let (bound, n_nodes) = (search.bound(), search.n_nodes);
    let (tree, objective) = search.best.unwrap_or((tree, objective));
    Outcome { tree, objective, bound, stop, n_nodes }
}

impl Search<'_, '_> {
    fn problem(&self) -> &Problem {
        self.context.problem
    }

    /// No tree costs less.
    fn bound(&self) -> i64 {
        let nodes = self.stack.iter().chain(&self.aside).map(|node| node.key).min();
        nodes.unwrap_or(i64::MAX).min(self.undecided).min(self.upper)
    }

    fn run(&mut self) -> Stop {
        loop {
            if let Some(stop) = self.stop() {
                return stop;
            }
            match self.stack.pop() {
                Some(node) if node.key >= self.target.min(self.upper) => self.aside.push(node),
                Some(node) => self.process(node),
                None => {
                    self.aside.retain(|node| node.key < self.upper);
                    let least = self.aside.iter().map(|node| node.key).min();
                    let Some(least) = least.filter(|&least| least < self.undecided) else {
                        return if self.bound() >= self.upper { Stop::Optimal } else { Stop::Finished };
                    };
                    self.target = self.target_above(least);
                    self.stack.append(&mut self.aside);
                }
            }
        }
    }

    /// The reason to stop, if there is one; the caller is asked every few hundredths of a second.
    fn stop(&mut self) -> Option<Stop> {
        if self.polled.elapsed() >= POLL {
            let state = self.progress();
            self.supervision.poll(&mut *self.keep_going, state);
            self.polled = Instant::now();
        }
        let gap = || self.supervision.gap_reached((self.upper - self.bound()) as f64, self.upper as f64);
        let spent = || self.supervision.spent(self.n_nodes, self.bytes());
        self.supervision.reason().or_else(gap).or_else(spent)
    }

    /// Half-way up the gap, and to its end when little is left, as at depth 2; a quarter at first, for an early bound.
    fn target_above(&self, bound: i64) -> i64 {
        let gap = self.upper - bound;
        let parts = if bound == 0 { 4 } else { 2 };
        if gap * 25 <= self.upper { self.upper } else { bound + (gap + parts - 1) / parts }
    }

    fn bytes(&self) -> f64 {
        ((self.stack.len() + self.aside.len()) * size_of::<Node>()) as f64
    }

    fn progress(&self) -> Progress {
        Progress { seconds: 0.0, objective: self.upper, bound: self.bound(), n_nodes: self.n_nodes }
    }

    /// Bound a node until the target; where that fails, try a tree and halve the node or part its last samples.
    fn process(&mut self, mut node: Node) {
        let context = self.context;
        let features = context.dual_planes[node.dual_plane].features;
        let partition = context.partition(features, &node.region);
        if context.is_infeasible(&partition) {
            self.n_nodes += 1;
            return;
        }
        let relaxed = context.need() - partition.open.len() as i64;
        let children = self.raise(&mut node, &partition.sides, relaxed, self.target, Some(&partition));
        if self.supervision.is_stopped() {
            self.stack.push(node);
            return;
        }
        self.n_nodes += 1;
        if node.key >= self.target {
            self.aside.push(node);
            return;
        }
        if let [Some(left), Some(right)] = children {
            self.try_center(&node, &partition, [&left, &right]);
        }
        match end_of(&context.instance.plane, features, &node.region, &partition.open) {
            End::Parts { points, dichotomies } => self.part(&node, &partition, (&points, &dichotomies)),
            End::Stuck => self.undecided = self.undecided.min(node.key),
            End::Split => {
                let region = &node.region;
                let at = context.dual_planes[node.dual_plane].middle_boundary(region.t0, region.t1);
                let halves = split(&context.instance.plane, features, region, &partition.open, at);
                self.stack.extend(halves.map(|region| Node { region, ..node.clone() }));
            }
        }
    }

    /// Raise the bounds of both children over these samples, with at least `need` in a leaf, and so the node's, to a
    /// target as far as they go. A partition has open samples beside, which may be too many for a child to be asked.
    fn raise(
        &mut self,
        node: &mut Node,
        sides: &[Vec<u32>; 2],
        need: i64,
        target: i64,
        partition: Option<&Partition>,
    ) -> [Option<Tree>; 2] {
        let price = self.context.instance.samples().price(self.context.dual_planes[node.dual_plane].features);
        for (floor, side) in node.floors.iter_mut().zip(sides) {
            let tally = self.context.instance.samples().tally(side);
            let by_labels = labels_at_least(&self.context.instance.loss, &tally, 1 << (self.problem().depth - 1));
            *floor = (*floor).max(by_labels).max(self.known.at_least_of(side));
        }
        let key = |floors: [i64; 2]| floors[0] + floors[1] + price;
        node.key = node.key.max(key(node.floors));
        let n_open = partition.map_or(0, |partition| partition.open.len()) as f64;
        let mut trees = [None, None];
        if node.key >= target || n_open > self.open_limit {
            return trees;
        }
        // The larger child first: it costs what is lacking more often.
        let first = usize::from(sides[1].len() > sides[0].len());
        for s in [first, 1 - first] {
            let cutoff = target - price - node.floors[1 - s];
            let child = self.ask(&sides[s], need, cutoff);
            if self.supervision.is_stopped() {
                return [None, None];
            }
            node.floors[s] = node.floors[s].max(child.bound);
            node.key = node.key.max(key(node.floors));
            trees[s] = child.tree;
            if node.key >= target {
                break;
            }
        }
        if partition.is_some() {
            let factor = if node.key >= target { CLOSED } else { LEFT_OPEN };
            self.open_limit = (self.open_limit * factor).min(self.problem().n as f64).max(ALWAYS_ASKED);
        }
        trees
    }

    /// The least cost of a tree of one level less over some samples, as far as `cutoff`.
    fn ask(&mut self, ids: &[u32], need: i64, cutoff: i64) -> Child {
        if ids.is_empty() {
            return Child { bound: 0, tree: Some(Tree::leaf(0)) };
        }
        let child = child_of(self.problem(), ids, need.max(1) as usize);
        let mut instance = Instance::new(&child);
        instance.switches = self.options.switches;
        let limits = self.supervision.limits();
        let left = Limits {
            seconds: limits.seconds - self.supervision.seconds(),
            gap: 0.0,
            nodes: limits.nodes - self.n_nodes as f64,
            ..*limits
        };
        let options = Options { limits: left, known: Some(cutoff), ..*self.options };
        let (own, supervision) = (Supervision::new(left), self.supervision);
        let state = self.progress();
        let keep_going = &mut |inner: Progress| {
            supervision.poll(&mut *self.keep_going, Progress { n_nodes: state.n_nodes + inner.n_nodes, ..state });
            !supervision.is_stopped()
        };
        let outcome = solve_depth_two(&child, &instance, &own, &options, (None, None), keep_going);
        let Ok(outcome) = outcome else {
            return Child { bound: 0, tree: None };
        };
        self.n_nodes += outcome.n_nodes;
        if !matches!(outcome.stop, Stop::Optimal | Stop::Finished) {
            supervision.stop(outcome.stop);
            return Child { bound: 0, tree: None };
        }
        self.known.learn(Lessons { sets: vec![(self.known.bits([ids, &[]]), outcome.bound)], ..Lessons::default() });
        let is_below = outcome.objective < cutoff;
        Child { bound: outcome.bound, tree: is_below.then_some(outcome.tree) }
    }

    /// Try the root line in the middle of the region above the trees that its children took without the open samples.
    fn try_center(&mut self, node: &Node, partition: &Partition, children: [&Tree; 2]) {
        let instance = self.context.instance;
        let features = self.context.dual_planes[node.dual_plane].features;
        let (t, r) = node.region.center();
        let line = Line { features, t, r };
        let mut sides = partition.sides.clone();
        for &i in &partition.open {
            sides[usize::from(!line.sends_left(&instance.plane, i))].push(i);
        }
        if line.is_clear_of(&instance.plane, &partition.open) {
            self.offer(features, &sides, children);
        }
    }

    /// Take the tree of a root that parts the samples like this, where it is better; whether it was.
    fn offer(&mut self, features: (usize, usize), sides: &[Vec<u32>; 2], children: [&Tree; 2]) -> bool {
        if sides.iter().any(Vec::is_empty) {
            return false;
        }
        let Some(root) = split_node(self.problem(), self.context.instance, features, &sides[0], &sides[1]) else {
            return false;
        };
        let tree = join(root, children[0], children[1]);
        let cost = objective(self.problem(), &tree);
        let is_better = cost < self.upper;
        if is_better {
            (self.upper, self.best) = (cost, Some((tree, cost)));
        }
        is_better
    }

    /// Solve every dichotomy of the open points by a root line of the region.
    fn part(&mut self, node: &Node, partition: &Partition, (points, dichotomies): (&[Vec<u32>], &Dichotomies)) {
        let features = self.context.dual_planes[node.dual_plane].features;
        let plane = &self.context.instance.plane;
        for dichotomy in dichotomies.iter() {
            let how = (points, &dichotomy[..]);
            let realised = realise(plane, features, &node.region, &self.context.all, how, &mut Separability::new());
            if matches!(realised, Realisation::Never) {
                continue;
            }
            let sides = partition.with(points, &dichotomy);
            if sides.iter().any(|side| side.len() < self.problem().leaf_size) {
                continue;
            }
            let mut fixed = node.clone();
            let trees = self.raise(&mut fixed, &sides, self.context.need(), self.upper, None);
            if self.supervision.is_stopped() {
                self.stack.push(node.clone());
                return;
            }
            if fixed.key >= self.upper {
                continue;
            }
            if let [Some(left), Some(right)] = &trees {
                self.offer(features, &sides, [left, right]);
            }
            if fixed.key < self.upper {
                self.undecided = self.undecided.min(fixed.key);
            }
        }
    }
}

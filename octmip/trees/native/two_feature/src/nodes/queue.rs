//! The search over nodes: best bound first, in batches, several threads, one result.
//!
//! A batch is a fixed number of nodes in the order of the queue. The result of a node depends on the node, the target
//! and the incumbent at the start of its batch alone, and results are taken in the order of the batch: so tree, bound
//! and counters do not depend on the number of threads, nor on which thread did what.
//!
//! Nodes are bounded up to a target between bound and incumbent, and set aside when they reach it; when none is left
//! the target has become the bound, and the next one is raised.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use crate::line_tree::{LineTree, to_tree};
use crate::nodes::known::Known;
use crate::nodes::node::{Child, Node, Processed, SearchContext};
use crate::nodes::numbers::{Reader, Writer};
use crate::nodes::state::{ReadTables, WrittenTables};
use octmip_frame::control::{KeepGoing, Progress, Stop};
use octmip_frame::supervise::Supervision;
use octmip_frame::tree::Tree;

/// Nodes of a batch.
const BATCH: usize = 64;
/// Memory of a node beside its intervals.
const NODE_BYTES: u64 = 600;
/// Number of batches between two measurements of the memory.
const BATCHES_PER_LOOK: u64 = 8;

/// A search between two batches.
pub struct Saved {
    /// All but its best tree (`state`).
    pub state: Vec<u8>,
    /// Most slope intervals of a dual plane.
    pub n_intervals: usize,
    /// The best tree of the search's own, and its cost.
    pub best: Option<(Tree, i64)>,
    /// Proven bound.
    pub bound: i64,
    /// Nodes processed.
    pub n_nodes: u64,
}

/// Taker of the state, every so often.
pub struct Saver<'a> {
    /// Seconds between two times.
    pub every: f64,
    /// When it was last given.
    pub saved: Instant,
    /// Seconds that it is left alone after that.
    pub pause: f64,
    /// Takes it; `false` means stop now.
    pub save: &'a mut dyn FnMut(&Saved) -> bool,
}

/// A search over nodes.
pub(crate) struct Queue<'a> {
    context: &'a SearchContext<'a>,
    supervision: &'a Supervision,
    n_threads: usize,
    /// Waiting nodes by bound, then the youngest first.
    waiting: BinaryHeap<Reverse<(i64, Reverse<u64>)>>,
    nodes: std::collections::HashMap<u64, Node>,
    aside: Vec<Node>,
    n_made: u64,
    target: i64,
    /// Least bound of what rounding left numerically undecided.
    undecided: i64,
    /// Trees of this much and more are of no interest: the best one's objective, or a caller's.
    upper: i64,
    best: Option<(Tree, i64)>,
    n_nodes: u64,
    n_batches: u64,
    /// Memory of the nodes at the last measurement.
    bytes: u64,
    known: Known,
}

impl<'a> Queue<'a> {
    /// A search from these nodes; `upper` is known to be attainable.
    pub(crate) fn new(
        context: &'a SearchContext<'a>,
        supervision: &'a Supervision,
        n_threads: usize,
        roots: Vec<Node>,
        upper: i64,
        known: Known,
    ) -> Self {
        let mut queue = Self {
            context,
            supervision,
            n_threads,
            waiting: BinaryHeap::new(),
            nodes: std::collections::HashMap::new(),
            aside: Vec::new(),
            n_made: 0,
            target: 0,
            undecided: i64::MAX,
            upper,
            best: None,
            n_nodes: 0,
            n_batches: 0,
            bytes: 0,
            known,
        };
        roots.into_iter().for_each(|root| queue.push(root));
        queue
    }

    fn push(&mut self, root: Node) {
        self.n_made += 1;
        self.push_as(self.n_made - 1, root);
    }

    fn push_as(&mut self, id: u64, root: Node) {
        self.waiting.push(Reverse((root.key, Reverse(id))));
        self.nodes.insert(id, root);
    }

    /// The state between two batches, the best tree left out.
    fn state(&self) -> Vec<u8> {
        let mut out = Writer::default();
        [self.n_made, self.n_nodes, self.n_batches].into_iter().for_each(|number| out.number(number));
        [self.target, self.undecided, self.upper].into_iter().for_each(|number| out.signed(number));
        self.known.write(&mut out);
        let mut waiting: Vec<u64> = self.nodes.keys().copied().collect();
        waiting.sort_unstable();
        let mut tables = WrittenTables::default();
        out.list(waiting.iter(), |out, id| {
            out.number(*id);
            tables.write(out, &self.nodes[id]);
        });
        out.list(self.aside.iter(), |out, node| tables.write(out, node));
        out.into_bytes()
    }

    /// The search that has this state; None where the bytes are none of such a search.
    pub(crate) fn go_on(mut self, kept: &Saved) -> Option<Self> {
        let from = &mut Reader::new(&kept.state, self.context.instance.plane.p);
        (self.n_made, self.n_nodes, self.n_batches) = (from.count()?, from.count()?, from.count()?);
        (self.target, self.undecided) = (from.cost()?, from.signed()?);
        let upper = from.cost()?;
        let is_cost = (0..=self.upper).contains(&upper);
        self.upper = upper;
        self.known.read(from)?;
        let mut tables = ReadTables::new(self.context);
        let waiting = from.list(|from| Some((from.number()?, tables.read(from)?)))?;
        self.aside = from.list(|from| tables.read(from))?;
        let is_right = is_cost && from.is_at_end() && waiting.iter().all(|(id, _)| *id < self.n_made);
        self.waiting = waiting.iter().map(|(id, node)| Reverse((node.key, Reverse(*id)))).collect();
        self.nodes = waiting.into_iter().collect();
        self.best = kept.best.clone();
        (is_right && self.nodes.len() == self.waiting.len()).then_some(self)
    }

    /// The proven bound.
    pub(crate) fn bound(&self) -> i64 {
        let waiting = self.waiting.peek().map(|entry| entry.0.0);
        let aside = self.aside.iter().map(|root| root.key).min();
        let open = waiting.into_iter().chain(aside).min().unwrap_or(i64::MAX);
        open.min(self.undecided).min(self.upper)
    }

    /// Take a tree, if it is better than what is known.
    pub(crate) fn offer(&mut self, line_tree: &LineTree) -> bool {
        let drawn = to_tree(self.context.problem, self.context.instance, line_tree);
        match drawn.filter(|(_, cost)| *cost < self.upper) {
            Some((tree, cost)) => {
                self.upper = cost;
                self.best = Some((tree, cost));
                if self.target > 0 {
                    self.target = self.target.min(self.target_above(self.bound()));
                }
                true
            }
            None => false,
        }
    }

    /// The best tree of the search's own, and the number of nodes processed.
    pub(crate) fn into_best(self) -> (Option<(Tree, i64)>, u64) {
        (self.best, self.n_nodes)
    }

    /// Search until the bound meets the best tree or a limit is met, handing out the state every so often and at the
    /// end.
    pub(crate) fn run(&mut self, mut saver: Option<Saver<'_>>, keep_going: KeepGoing) -> Stop {
        let stop = self.search(&mut saver, keep_going);
        if let Some(saver) = &mut saver {
            self.save(saver);
        }
        stop
    }

    fn save(&self, saver: &mut Saver<'_>) -> bool {
        let begun = Instant::now();
        let goes_on = (saver.save)(&Saved {
            state: self.state(),
            n_intervals: self.context.n_intervals,
            best: self.best.clone(),
            bound: self.bound(),
            n_nodes: self.n_nodes,
        });
        // A large state takes long to write: a tenth of the time at most.
        saver.pause = 9.0 * begun.elapsed().as_secs_f64();
        saver.saved = Instant::now();
        goes_on
    }

    fn search(&mut self, saver: &mut Option<Saver<'_>>, keep_going: KeepGoing) -> Stop {
        loop {
            let bound = self.bound();
            if bound >= self.upper {
                return Stop::Optimal;
            }
            if let Some(stop) = self.limit_met(bound) {
                return stop;
            }
            if let Some(saver) =
                saver.as_mut().filter(|saver| saver.saved.elapsed().as_secs_f64() >= saver.every.max(saver.pause))
                && !self.save(saver)
            {
                return Stop::Interrupted;
            }
            let batch = self.next_batch();
            if batch.is_empty() {
                if self.aside.is_empty() {
                    return Stop::Finished;
                }
                self.raise_target();
                continue;
            }
            let results = self.process(&batch, keep_going);
            if let Some(stop) = self.supervision.reason() {
                batch.into_iter().for_each(|(id, root)| self.push_as(id, root));
                return stop;
            }
            self.n_nodes += batch.len() as u64;
            for result in results {
                self.take(result);
            }
        }
    }

    /// The limit that the search has met, if any.
    fn limit_met(&mut self, bound: i64) -> Option<Stop> {
        if self.n_batches.is_multiple_of(BATCHES_PER_LOOK) {
            self.bytes = self.nodes.values().chain(&self.aside).map(bytes_of).sum();
        }
        self.n_batches += 1;
        let gap = self.supervision.gap_reached((self.upper - bound) as f64, self.upper as f64);
        gap.or_else(|| self.supervision.spent(self.n_nodes, self.bytes as f64))
    }

    fn next_batch(&mut self) -> Vec<(u64, Node)> {
        let mut batch = Vec::with_capacity(BATCH);
        while batch.len() < BATCH {
            let Some(Reverse((key, Reverse(id)))) = self.waiting.pop() else {
                break;
            };
            match self.nodes.remove(&id) {
                Some(root) if key < self.target.min(self.upper) => batch.push((id, root)),
                // The target fell when a better tree was found.
                Some(root) if key < self.upper => self.aside.push(root),
                _ => {}
            }
        }
        batch
    }

    /// Half-way up the gap, and to its end when little is left. A node set aside has its key for a bound, whatever the
    /// target was.
    fn raise_target(&mut self) {
        let upper = self.upper;
        self.aside.retain(|root| root.key < upper);
        let bound = self.aside.iter().map(|root| root.key).min().unwrap_or(upper);
        self.target = self.target_above(bound);
        for root in std::mem::take(&mut self.aside) {
            if root.key >= self.target {
                self.aside.push(root);
            } else {
                self.push(root);
            }
        }
    }

    fn target_above(&self, bound: i64) -> i64 {
        let gap = self.upper - bound;
        let halves = self.context.instance.switches.targets;
        if gap * 25 <= self.upper || !halves { self.upper } else { bound + (gap + 1) / 2 }
    }

    fn take(&mut self, result: Processed) {
        self.known.learn(result.lessons);
        if let Some((cost, line_tree)) = &result.found
            && *cost < self.upper
            && !self.offer(line_tree)
        {
            // Rounding spoilt the tree: its cost stays possible for the bound.
            self.undecided = self.undecided.min(*cost);
        }
        self.undecided = self.undecided.min(result.undecided.unwrap_or(i64::MAX));
        for root in result.nodes {
            if root.key >= self.target.min(self.upper) {
                self.aside.push(root);
            } else {
                self.push(root);
            }
        }
    }

    /// Process a batch in several threads; results come in the order of the batch.
    fn process(&self, batch: &[(u64, Node)], keep_going: KeepGoing) -> Vec<Processed> {
        let state = Progress {
            seconds: 0.0,
            objective: self.upper,
            bound: self.bound().min(batch.iter().map(|(_, root)| root.key).min().unwrap_or(i64::MAX)),
            n_nodes: self.n_nodes,
        };
        let next = AtomicUsize::new(0);
        let slots: Vec<Mutex<Processed>> = batch.iter().map(|_| Mutex::default()).collect();
        let work = || {
            let mut position = next.fetch_add(1, Ordering::Relaxed);
            while position < batch.len() && !self.supervision.is_stopped() {
                let root = batch[position].1.clone();
                let result = self.context.process(root, self.target, self.upper, &self.known);
                if let Ok(mut slot) = slots[position].lock() {
                    *slot = result;
                }
                position = next.fetch_add(1, Ordering::Relaxed);
            }
        };
        self.supervision
            .run_all(self.n_threads.min(batch.len()), work, || self.supervision.poll(&mut *keep_going, state));
        self.supervision.poll(keep_going, state);
        slots.into_iter().map(|slot| slot.into_inner().unwrap_or_default()).collect()
    }
}

/// Memory of a node; intervals that several nodes share are shared out among them.
fn bytes_of(root: &Node) -> u64 {
    let intervals = |child: &Child| {
        let size = std::mem::size_of_val(&child.intervals[..]);
        size as u64 / Arc::strong_count(&child.intervals) as u64
    };
    NODE_BYTES + root.children.iter().map(intervals).sum::<u64>()
}

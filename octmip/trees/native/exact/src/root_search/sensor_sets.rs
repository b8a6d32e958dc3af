//! A hard sensor budget, exactly: branching on which sensors may be read.
//!
//! A node of this search holds some sensors (paid for already) and bans others. Its relaxation ignores the budget: the
//! best tree over the sensors that are held, or free and each affordable beside the held ones. Every tree within the
//! budget that reads no banned sensor is one of those, so
//!
//! * when no such tree costs less than the incumbent, the node is closed: error never falls as sensors are taken away;
//! * a tree that is found and keeps the budget is the new incumbent;
//! * a tree that breaks the budget names the sensors to branch on: ban one of them, or hold it.
//!
//! Nodes are visited depth first. Threads visit those that come next beforehand; such a visit counts if no better tree
//! was found meanwhile, else it is made again. So every search and the tree are those of one thread.
//!
//! Branching ends: every branch bans or holds one more sensor, and once all that are left fit, the relaxation is exact.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::node::search::Search;
use crate::root_search::known::Held;
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_check::problem::Problem;
use octmip_frame::effort::Control;
use octmip_frame::tree::{Node, Tree};

/// Sensors that a node holds and bans, and those of a tree that is known to break the budget here.
#[derive(Debug, Clone)]
pub(crate) struct Choice {
    held: Vec<bool>,
    banned: Vec<bool>,
    breaking: Option<Vec<usize>>,
}

impl Choice {
    fn bytes(&self) -> usize {
        let sensors = self.breaking.iter().map(Vec::capacity).sum::<usize>();
        size_of::<Self>() + self.held.capacity() + self.banned.capacity() + 8 * sensors
    }
}

/// Result of a relaxation.
pub(crate) enum Relaxed {
    /// No tree over these features is below the incumbent.
    Closed(Vec<usize>),
    /// A tree that keeps the budget, and its cost.
    Within(i64, Tree),
    /// A tree below the incumbent breaks the budget: its sensors.
    Breaking(Vec<usize>),
}

/// Result of a visit to a node: the last of its trees within the budget, each cheaper than the one before, and its
/// branches, the one to visit first last.
#[derive(Debug, Default)]
struct Visit {
    better: Option<(i64, Tree)>,
    branches: Vec<Choice>,
}

/// Progress of an open node.
#[derive(Debug)]
enum Mark {
    Waiting,
    InWork,
    /// Visited with an incumbent of this cost.
    Visited(i64, Visit),
}

#[derive(Debug)]
struct State {
    /// Nodes to visit, the next one last. What lies below a node stays where it is until the node is gone.
    open: Vec<(Choice, Mark)>,
    cost: i64,
    tree: Option<Tree>,
}

impl State {
    fn see(&mut self, better: Option<(i64, Tree)>) {
        if let Some((cost, tree)) = better.filter(|better| better.0 < self.cost) {
            (self.cost, self.tree) = (cost, Some(tree));
        }
    }

    /// Enter the visits of the nodes that are next, as long as they are as one thread would have made them.
    fn advance(&mut self) {
        while let Some((choice, mark)) = self.open.pop() {
            match mark {
                Mark::Visited(upper, visit) if upper == self.cost => {
                    self.see(visit.better);
                    let branches = visit.branches.into_iter();
                    self.open.extend(branches.map(|node| (node, Mark::Waiting)));
                }
                Mark::Visited(..) => self.open.push((choice, Mark::Waiting)),
                mark => return self.open.push((choice, mark)),
            }
        }
    }
}

/// The search over sensor sets, shared by the threads.
pub(crate) struct Sets<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) samples: &'a Samples,
    pub(crate) switches: Switches,
    pub(crate) control: &'a Control,
    state: Mutex<State>,
    changed: Condvar,
}

impl<'a> Sets<'a> {
    /// All sensor sets; trees that cost less than `upper` (above the base) are wanted. `relaxed`: a tree below it
    /// that breaks the budget, if one is known.
    pub(crate) fn new(
        problem: &'a Problem,
        samples: &'a Samples,
        switches: Switches,
        control: &'a Control,
        relaxed: Option<&Tree>,
        upper: i64,
    ) -> Self {
        let none = vec![false; problem.sensor_cost.len()];
        let breaking = relaxed.map(|tree| sensors_of(problem, tree));
        let all = Choice { held: none.clone(), banned: none, breaking };
        let state = State { open: vec![(all, Mark::Waiting)], cost: upper, tree: None };
        Self { problem, samples, switches, control, state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Go on from the nodes that an earlier search left open.
    pub(crate) fn go_on(self, open: &[Held]) -> Self {
        let node = |(held, banned): &Held| Choice { held: held.clone(), banned: banned.clone(), breaking: None };
        self.lock().open = open.iter().map(|nodes| (node(nodes), Mark::Waiting)).collect();
        self
    }

    /// The nodes that are open; what visits to them found is left out.
    pub(crate) fn open(&self) -> Vec<Held> {
        self.lock().open.iter().map(|(node, _)| (node.held.clone(), node.banned.clone())).collect()
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lowest cost so far, and the tree that has it if it was found here.
    pub(crate) fn best(&self) -> (i64, Option<Tree>) {
        let state = self.lock();
        (state.cost, state.tree.clone())
    }

    /// Bytes of the nodes that wait or are in work.
    pub(crate) fn bytes(&self) -> usize {
        let state = self.lock();
        let of_mark = |mark: &Mark| match mark {
            Mark::Visited(_, visit) => visit.branches.iter().map(Choice::bytes).sum(),
            _ => size_of::<Mark>(),
        };
        let nodes = state.open.iter();
        nodes.map(|(node, mark)| node.bytes() + of_mark(mark)).sum()
    }

    /// Work until no set is open or the search is stopped.
    pub(crate) fn work(&self) {
        while let Some((index, choice, upper)) = self.next() {
            let visit = self.visit(&choice, upper);
            let mut state = self.lock();
            if self.control.is_stopped() {
                state.see(visit.better); // a tree is a tree; what was closed may be no proof
                break;
            }
            state.open[index].1 = Mark::Visited(upper, visit);
            state.advance();
            drop(state);
            self.changed.notify_all();
        }
        self.changed.notify_all();
    }

    /// The next node that waits, its place, and the incumbent's cost.
    fn next(&self) -> Option<(usize, Choice, i64)> {
        let mut state = self.lock();
        loop {
            if self.control.is_stopped() || state.open.is_empty() {
                return None;
            }
            let waiting = |open: &(Choice, Mark)| matches!(open.1, Mark::Waiting);
            if let Some(index) = state.open.iter().rposition(waiting) {
                state.open[index].1 = Mark::InWork;
                return Some((index, state.open[index].0.clone(), state.cost));
            }
            // Woken by visits; looks up now and then, as nobody wakes it when the search is stopped.
            let waited = self.changed.wait_timeout(state, Duration::from_millis(20));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Search a node until it is closed or a tree breaks the budget.
    fn visit(&self, choice: &Choice, upper: i64) -> Visit {
        let mut visit = Visit::default();
        loop {
            let upper = visit.better.as_ref().map_or(upper, |better| better.0);
            match self.relax(choice, upper) {
                Relaxed::Closed(_) => return visit,
                Relaxed::Within(cost, tree) => visit.better = Some((cost, tree)),
                Relaxed::Breaking(sensors) => {
                    let decided = self.decide(choice, &sensors);
                    let branches = decided.map(|(_, without, with)| vec![without, with]);
                    visit.branches = branches.unwrap_or_default();
                    return visit;
                }
            }
        }
    }

    /// The sensor to decide, and the nodes that ban and hold it: the first that a tree breaking the budget reads and
    /// that is not yet held. There is one, as a tree over held sensors alone keeps the budget.
    pub(crate) fn decide(&self, choice: &Choice, breaking: &[usize]) -> Option<(usize, Choice, Choice)> {
        let costs = &self.problem.sensor_cost;
        let sensor = breaking.iter().copied().find(|&s| !choice.held[s] && costs[s] > 0.0)?;
        let mut without = Choice { breaking: None, ..choice.clone() };
        without.banned[sensor] = true;
        let mut with = Choice { breaking: Some(breaking.to_vec()), ..choice.clone() };
        with.held[sensor] = true;
        Some((sensor, without, with))
    }

    /// The nodes to begin with.
    pub(crate) fn take_open(&self) -> Vec<Choice> {
        let open = std::mem::take(&mut self.lock().open);
        open.into_iter().map(|(choice, _)| choice).collect()
    }

    /// Sensors that a node may read: held ones, and those that are not banned and affordable beside them.
    fn usable(&self, choice: &Choice) -> Vec<bool> {
        let costs = &self.problem.sensor_cost;
        let held: f64 = costs.iter().zip(&choice.held).filter(|(_, held)| **held).map(|(cost, _)| cost).sum();
        let left = self.problem.sensor_limit - held;
        let fits = |s: usize| choice.held[s] || (!choice.banned[s] && (costs[s] <= left || costs[s] == 0.0));
        (0..costs.len()).map(fits).collect()
    }

    /// Search a node's relaxation for trees that cost less than `upper`.
    ///
    /// The first tree will do when the sensors break the budget together; else the best one is wanted.
    pub(crate) fn relax(&self, choice: &Choice, upper: i64) -> Relaxed {
        let usable = self.usable(choice);
        if let Some(sensors) = &choice.breaking
            && sensors.iter().all(|&s| usable[s])
        {
            return Relaxed::Breaking(sensors.clone());
        }
        let sensor_of = |f: usize| self.problem.sensor_of_feature[self.samples.features[f] as usize] as usize;
        let features: Vec<usize> = (0..self.samples.p).filter(|&f| usable[sensor_of(f)]).collect();
        let samples = self.samples.with_features(&features);
        let view = View::root(&samples);
        let mut search = Search::new(&samples, self.switches, self.control, self.problem.depth);
        let costs = self.problem.sensor_cost.iter().zip(&usable);
        let all: f64 = costs.filter(|(_, usable)| **usable).map(|(cost, _)| cost).sum();
        search.takes_first = all > self.problem.sensor_limit;
        let result = search.solve(&view, self.problem.depth, upper, 0);
        match result.best.filter(|_| !self.control.is_stopped()) {
            None => Relaxed::Closed(features),
            Some((cost, plan)) => {
                let tree = plan.tree(&samples, &view);
                match is_within(self.problem, &tree) {
                    true => Relaxed::Within(cost, tree),
                    false => Relaxed::Breaking(sensors_of(self.problem, &tree)),
                }
            }
        }
    }
}

/// Whether a tree keeps the budget.
pub(crate) fn is_within(problem: &Problem, tree: &Tree) -> bool {
    let total: f64 = sensors_of(problem, tree).iter().map(|&s| problem.sensor_cost[s]).sum();
    total <= problem.sensor_limit
}

/// The sensors that a tree reads, in preorder, none twice.
fn sensors_of(problem: &Problem, tree: &Tree) -> Vec<usize> {
    let mut sensors = Vec::new();
    for node in &tree.nodes {
        if let Node::Split { feature, .. } = node {
            let sensor = problem.sensor_of_feature[*feature as usize] as usize;
            if !sensors.contains(&sensor) {
                sensors.push(sensor);
            }
        }
    }
    sensors
}

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
//! Branching ends: every branch bans or holds one more sensor, and once all that are left fit, the relaxation is exact.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::exact::Switches;
use crate::exact::branch::Search;
use crate::exact::effort::Control;
use crate::exact::samples::Samples;
use crate::exact::view::View;
use crate::problem::Problem;
use crate::tree::{Node, Tree};

/// Which sensors a node holds and bans, and the sensors of a tree that is known to break the budget here.
#[derive(Debug, Clone)]
pub struct Choice {
    held: Vec<bool>,
    banned: Vec<bool>,
    breaking: Option<Vec<usize>>,
}

/// What a relaxation says.
pub enum Relaxed {
    /// No tree over these features is below the incumbent.
    Closed(Vec<usize>),
    /// A tree that keeps the budget, and its cost.
    Within(i64, Tree),
    /// A tree below the incumbent breaks the budget: its sensors.
    Breaking(Vec<usize>),
}

#[derive(Debug)]
struct State {
    open: Vec<Choice>,
    n_in_work: usize,
    cost: i64,
    tree: Option<Tree>,
}

/// The search over sensor sets, shared by the threads.
pub struct Sets<'a> {
    pub(super) problem: &'a Problem,
    pub(super) samples: &'a Samples,
    pub(super) switches: Switches,
    pub(super) control: &'a Control,
    state: Mutex<State>,
    changed: Condvar,
}

impl<'a> Sets<'a> {
    /// All sensor sets; trees that cost less than `upper` (above the base) are wanted. `relaxed`: a tree below it
    /// that breaks the budget, if one is known.
    pub fn new(
        problem: &'a Problem,
        samples: &'a Samples,
        switches: Switches,
        control: &'a Control,
        relaxed: Option<&Tree>,
        upper: i64,
    ) -> Self {
        let none = vec![false; problem.sensor_cost.len()];
        let breaking = relaxed.map(|tree| sensors_of(problem, tree));
        let open = vec![Choice {
            held: none.clone(),
            banned: none,
            breaking,
        }];
        let state = State {
            open,
            n_in_work: 0,
            cost: upper,
            tree: None,
        };
        Self {
            problem,
            samples,
            switches,
            control,
            state: Mutex::new(state),
            changed: Condvar::new(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lowest cost so far, and the tree that has it if it was found here.
    pub fn best(&self) -> (i64, Option<Tree>) {
        let state = self.lock();
        (state.cost, state.tree.clone())
    }

    /// Work until no set is open or someone says stop.
    pub fn work(&self) {
        while let Some(choice) = self.next() {
            let branches = self.process(&choice);
            let mut state = self.lock();
            state.n_in_work -= 1;
            state.open.extend(branches);
            drop(state);
            self.changed.notify_all();
        }
    }

    fn next(&self) -> Option<Choice> {
        let mut state = self.lock();
        loop {
            if self.control.is_stopped() {
                return None;
            }
            if let Some(choice) = state.open.pop() {
                state.n_in_work += 1;
                return Some(choice);
            }
            if state.n_in_work == 0 {
                return None;
            }
            let waited = self.changed.wait_timeout(state, Duration::from_millis(20));
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Close a node or return its branches, the one to visit first last.
    fn process(&self, choice: &Choice) -> Vec<Choice> {
        loop {
            match self.relax(choice) {
                Relaxed::Closed(_) => return Vec::new(),
                Relaxed::Within(cost, tree) => {
                    let mut state = self.lock();
                    if cost < state.cost {
                        (state.cost, state.tree) = (cost, Some(tree));
                    }
                }
                Relaxed::Breaking(sensors) => {
                    let branches = self.decide(choice, &sensors);
                    return branches
                        .map_or_else(Vec::new, |(_, without, with)| vec![without, with]);
                }
            }
        }
    }

    /// The sensor to decide, and the nodes that ban and hold it: the first that a tree breaking the budget reads and
    /// that is not yet held. There is one, as a tree over held sensors alone keeps the budget.
    pub(super) fn decide(
        &self,
        choice: &Choice,
        breaking: &[usize],
    ) -> Option<(usize, Choice, Choice)> {
        let costs = &self.problem.sensor_cost;
        let sensor = breaking
            .iter()
            .copied()
            .find(|&s| !choice.held[s] && costs[s] > 0.0)?;
        let mut without = Choice {
            breaking: None,
            ..choice.clone()
        };
        without.banned[sensor] = true;
        let mut with = Choice {
            breaking: Some(breaking.to_vec()),
            ..choice.clone()
        };
        with.held[sensor] = true;
        Some((sensor, without, with))
    }

    /// The nodes to begin with.
    pub(super) fn take_open(&self) -> Vec<Choice> {
        std::mem::take(&mut self.lock().open)
    }

    /// Sensors that a node may read: held ones, and those that are not banned and affordable beside them.
    fn usable(&self, choice: &Choice) -> Vec<bool> {
        let costs = &self.problem.sensor_cost;
        let held: f64 = costs
            .iter()
            .zip(&choice.held)
            .filter(|(_, held)| **held)
            .map(|(cost, _)| cost)
            .sum();
        let left = self.problem.sensor_limit - held;
        let fits = |s: usize| {
            choice.held[s] || (!choice.banned[s] && (costs[s] <= left || costs[s] == 0.0))
        };
        (0..costs.len()).map(fits).collect()
    }

    /// Search a node's relaxation below the incumbent.
    ///
    /// The first tree will do when the sensors break the budget together; else the best one is wanted.
    pub(super) fn relax(&self, choice: &Choice) -> Relaxed {
        let usable = self.usable(choice);
        if let Some(sensors) = &choice.breaking
            && sensors.iter().all(|&s| usable[s])
        {
            return Relaxed::Breaking(sensors.clone());
        }
        let sensor_of =
            |f: usize| self.problem.sensor_of_feature[self.samples.features[f] as usize] as usize;
        let features: Vec<usize> = (0..self.samples.p)
            .filter(|&f| usable[sensor_of(f)])
            .collect();
        let samples = self.samples.with_features(&features);
        let view = View::root(&samples);
        let mut search = Search::new(&samples, self.switches, self.control, self.problem.depth);
        let costs = self.problem.sensor_cost.iter().zip(&usable);
        let all: f64 = costs
            .filter(|(_, usable)| **usable)
            .map(|(cost, _)| cost)
            .sum();
        search.takes_first = all > self.problem.sensor_limit;
        let upper = self.lock().cost;
        let answer = search.solve(&view, self.problem.depth, upper, 0);
        match answer.best.filter(|_| !self.control.is_stopped()) {
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
pub fn is_within(problem: &Problem, tree: &Tree) -> bool {
    let total: f64 = sensors_of(problem, tree)
        .iter()
        .map(|&s| problem.sensor_cost[s])
        .sum();
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

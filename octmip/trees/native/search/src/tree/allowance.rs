//! The features that one split may read, given what the rest of the tree reads.

use crate::tree::state::State;
use octmip_check::problem::Problem;

/// The sensors that the rest of the tree reads, and what it leaves of the budget; groups and size are the problem's.
#[derive(Debug)]
pub(crate) struct Allowance<'a> {
    problem: &'a Problem,
    used: Vec<bool>,
    spent: f64,
    has_budget: bool,
}

impl<'a> Allowance<'a> {
    /// The allowance of the split at `v`; what `v` itself reads now is not counted.
    pub(crate) fn at(problem: &'a Problem, state: &State, v: u32) -> Self {
        let has_budget = problem.sensor_limit.is_finite();
        let used = if has_budget { used_sensors(problem, state, |node| node != v) } else { Vec::new() };
        let spent = if has_budget { spent(problem, &used) } else { 0.0 };
        Self { problem, used, spent, has_budget }
    }

    /// The features that an axis-aligned split may read, ascending.
    pub(crate) fn axis_features(&self) -> Vec<u32> {
        let allowed = (0..self.problem.p as u32).filter(|&f| self.problem.allowed[f as usize]);
        allowed.filter(|&f| self.affords(&[f])).collect()
    }

    /// Whether a split may read all these features.
    pub(crate) fn admits(&self, features: &[u32]) -> bool {
        self.has_size_for(features) && self.affords(features)
    }

    fn has_size_for(&self, features: &[u32]) -> bool {
        let Some(planes) = &self.problem.planes else {
            return features.len() <= 1;
        };
        let in_one_group =
            |groups: &Vec<Vec<u32>>| groups.iter().any(|group| features.iter().all(|f| group.binary_search(f).is_ok()));
        features.len() <= planes.split_size && planes.groups.as_ref().is_none_or(in_one_group)
    }

    fn affords(&self, features: &[u32]) -> bool {
        if !self.has_budget {
            return true;
        }
        let mut cost = self.spent;
        for (k, &f) in features.iter().enumerate() {
            let sensor = self.problem.sensor_of_feature[f as usize];
            let is_new = |e: &u32| self.problem.sensor_of_feature[*e as usize] != sensor;
            if !self.used[sensor as usize] && features[..k].iter().all(is_new) {
                cost += self.problem.sensor_cost[sensor as usize];
            }
        }
        cost <= self.problem.sensor_limit
    }

    /// The first features of a list that may be read together, taken greedily, `size` at most, ascending.
    pub(crate) fn first_admitted(&self, features: &[u32], size: usize) -> Vec<u32> {
        let mut chosen: Vec<u32> = Vec::new();
        for &f in features {
            if chosen.len() == size {
                break;
            }
            chosen.push(f);
            if !self.admits(&chosen) {
                chosen.pop();
            }
        }
        chosen.sort_unstable();
        chosen
    }
}

/// The sensors that are read by the nodes counted.
pub(crate) fn used_sensors(problem: &Problem, state: &State, is_counted: impl Fn(u32) -> bool) -> Vec<bool> {
    let mut used = vec![false; problem.sensor_cost.len()];
    for node in state.below(0) {
        if is_counted(node) {
            for f in state.nodes[node as usize].rule.features() {
                used[problem.sensor_of_feature[f as usize] as usize] = true;
            }
        }
    }
    used
}

/// Sum of the costs of these sensors.
pub(crate) fn spent(problem: &Problem, used: &[bool]) -> f64 {
    used.iter().zip(&problem.sensor_cost).filter(|(used, _)| **used).map(|(_, cost)| cost).sum()
}

/// Whether all leaves are large enough and all sensors affordable.
pub(crate) fn keeps_limits(problem: &Problem, state: &State) -> bool {
    let is_large = |&leaf: &u32| state.nodes[leaf as usize].samples.len() >= problem.leaf_size;
    let is_affordable = || spent(problem, &used_sensors(problem, state, |_| true)) <= problem.sensor_limit;
    (state.is_leaf(0) || state.leaves(0).iter().all(is_large)) && is_affordable()
}

/// The features whose sensors the tree reads already, so that any tree over them is affordable; none without a budget.
pub(crate) fn paid_features(problem: &Problem, state: &State) -> Option<Vec<bool>> {
    problem.sensor_limit.is_finite().then(|| features_of(problem, &used_sensors(problem, state, |_| true)))
}

/// The features read from these sensors.
pub(crate) fn features_of(problem: &Problem, sensors: &[bool]) -> Vec<bool> {
    problem.sensor_of_feature.iter().map(|&sensor| sensors[sensor as usize]).collect()
}

/// The sensors read now, one of them dropped, and others at random as long as they fit the budget.
pub(crate) fn redrawn_sensors(problem: &Problem, state: &State, rng: &mut fastrand::Rng) -> Vec<bool> {
    let mut chosen = used_sensors(problem, state, |_| true);
    let used: Vec<usize> = (0..chosen.len()).filter(|&s| chosen[s]).collect();
    let dropped = if used.is_empty() { None } else { Some(used[rng.usize(..used.len())]) };
    if let Some(dropped) = dropped {
        chosen[dropped] = false;
    }
    let mut others: Vec<usize> = (0..chosen.len()).filter(|&s| !chosen[s] && Some(s) != dropped).collect();
    rng.shuffle(&mut others);
    for sensor in others.into_iter().chain(dropped) {
        chosen[sensor] = true;
        chosen[sensor] = spent(problem, &chosen) <= problem.sensor_limit;
    }
    chosen
}

//! Which features a split may read, given what the rest of the tree reads.

use crate::problem::Problem;
use crate::search::state::State;

/// The features open to one node.
///
/// A feature is open when it is allowed at all and its sensor is read elsewhere in the tree or still fits the budget.
pub fn open_features(problem: &Problem, state: &State, v: u32) -> Vec<u32> {
    let allowed = (0..problem.p as u32).filter(|&f| problem.allowed[f as usize]);
    if problem.sensor_limit.is_infinite() {
        return allowed.collect();
    }
    let used = used_sensors(problem, state, |node| node != v);
    let spent = spent(problem, &used);
    let fits = |f: &u32| {
        let sensor = problem.sensor_of_feature[*f as usize] as usize;
        used[sensor] || spent + problem.sensor_cost[sensor] <= problem.sensor_limit
    };
    allowed.filter(fits).collect()
}

/// Which sensors are read by the nodes that are counted.
pub fn used_sensors(
    problem: &Problem,
    state: &State,
    is_counted: impl Fn(u32) -> bool,
) -> Vec<bool> {
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

/// What these sensors cost together.
pub fn spent(problem: &Problem, used: &[bool]) -> f64 {
    used.iter()
        .zip(&problem.sensor_cost)
        .filter(|(used, _)| **used)
        .map(|(_, cost)| cost)
        .sum()
}

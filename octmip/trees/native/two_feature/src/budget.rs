//! A sensor budget as a list of feature sets: every affordable tree reads from one of them.

use octmip_check::problem::Problem;

/// Features that the splits of a tree of depth 2 can read.
const MOST_READ: usize = 6;
const MOST_SETS: usize = 20_000;

/// For every largest affordable set of sensors, whether each feature is in it; one set of all where the budget does not
/// bind.
///
/// None if there are too many sets.
pub(crate) fn affordable_sets(problem: &Problem) -> Option<Vec<Vec<bool>>> {
    let mut costs = problem.sensor_cost.clone();
    costs.sort_unstable_by(|a, b| b.total_cmp(a));
    let highest: f64 = costs.iter().take(MOST_READ).sum();
    if highest <= problem.sensor_limit {
        return Some(vec![vec![true; problem.p]]);
    }
    let mut sets = Vec::new();
    extend(problem, 0, &mut Vec::new(), 0.0, &mut sets)?;
    let features = |set: &Vec<usize>| {
        let sensors = problem.sensor_of_feature.iter();
        sensors.map(|&s| set.contains(&(s as usize))).collect()
    };
    Some(sets.iter().map(features).collect())
}

fn extend(problem: &Problem, next: usize, set: &mut Vec<usize>, cost: f64, sets: &mut Vec<Vec<usize>>) -> Option<()> {
    let n_sensors = problem.sensor_cost.len();
    let fits = |s: usize| cost + problem.sensor_cost[s] <= problem.sensor_limit;
    let is_full = set.len() == MOST_READ;
    if is_full || !(0..n_sensors).any(|s| !set.contains(&s) && fits(s)) {
        sets.push(set.clone());
        return (sets.len() <= MOST_SETS).then_some(());
    }
    for s in next..n_sensors {
        if fits(s) {
            set.push(s);
            extend(problem, s + 1, set, cost + problem.sensor_cost[s], sets)?;
            set.pop();
        }
    }
    Some(())
}

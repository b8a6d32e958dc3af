//! Tests that need no Python; the optimum itself is checked against enumeration in tests/test_octmip.

use super::problem::SequentialProblem;
use super::solve::solve;
use crate::control::{Limits, Stop};
use crate::tree::{Node, Tree};

/// Two sensors: the first separates the classes 0 | 1, 2, the second 0, 1 | 2; both open one group.
fn problem() -> SequentialProblem {
    SequentialProblem {
        n: 6,
        p: 2,
        n_classes: 3,
        ranks: vec![0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1],
        paid: [0, 0, 1, 1, 2, 2].iter().flat_map(|&y| (0..3).map(move |k| f64::from(u8::from(k != y)))).collect(),
        frequency: vec![1.0; 6],
        delay_costs: vec![0.0; 6],
        penalty: 0.0,
        depth: 2,
        leaf_size: 1,
        sensor_of_feature: vec![0, 1],
        sensor_cost: vec![1.0, 1.0],
        group_of_sensor: vec![0, 0],
        setup_costs: vec![2.0],
        most_readings: vec![usize::MAX; 3],
        allowed: vec![true; 2],
        read: Vec::new(),
        multiplier: 0.0,
        cap: None,
    }
}

fn tree_of(problem: &SequentialProblem) -> Tree {
    let result = solve(problem, f64::INFINITY, Limits::default(), &mut |_| true);
    assert_eq!(result.stop, Stop::Optimal);
    result.tree.expect("a leaf at least")
}

#[test]
fn an_open_group_makes_the_second_sensor_cheap() {
    let problem = problem();
    let (path, first) = problem.step(problem.start(), 0);
    let (path, second) = problem.step(path, 1);
    assert_eq!((first, second, path.n_read), (3.0, 1.0, 2));
    assert_eq!(problem.step(path, 0).1, 0.0);
}

#[test]
fn readings_that_cost_more_than_they_save_are_left_out() {
    assert_eq!(tree_of(&problem()).nodes.len(), 5);
    assert_eq!(tree_of(&SequentialProblem { multiplier: 1.0, ..problem() }).nodes.len(), 1);
}

#[test]
fn a_cap_is_kept() {
    let tree = tree_of(&SequentialProblem { multiplier: 0.0, cap: Some(18.0), ..problem() });
    assert_eq!(tree.nodes.len(), 3);
}

#[test]
fn a_label_with_a_limit_is_predicted_in_time() {
    let tree = tree_of(&SequentialProblem { most_readings: vec![9, 9, 1], ..problem() });
    assert!(matches!(tree.nodes[0], Node::Split { feature: 1, .. }));
}

//! What can be seen without Python; the optimum itself is checked against enumeration in tests/test_octmip.

use super::question::Question;
use super::solve::solve;
use crate::control::{Limits, Stop};
use crate::tree::{Node, Tree};

/// Two sensors: the first tells the classes 0 | 1, 2 apart, the second 0, 1 | 2; both open one group.
fn question() -> Question {
    Question {
        n: 6,
        p: 2,
        n_classes: 3,
        ranks: vec![0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1],
        paid: [0, 0, 1, 1, 2, 2].iter().flat_map(|&y| (0..3).map(move |k| f64::from(u8::from(k != y)))).collect(),
        frequency: vec![1.0; 6],
        haste: vec![0.0; 6],
        penalty: 0.0,
        depth: 2,
        leaf_size: 1,
        sensor_of_feature: vec![0, 1],
        sensor_cost: vec![1.0, 1.0],
        group_of_sensor: vec![0, 0],
        opening: vec![2.0],
        most_readings: vec![usize::MAX; 3],
        allowed: vec![true; 2],
        read: Vec::new(),
        multiplier: 0.0,
        cap: None,
    }
}

fn tree_of(question: &Question) -> Tree {
    let answer = solve(question, f64::INFINITY, Limits::default(), &mut |_| true);
    assert_eq!(answer.stop, Stop::Optimal);
    answer.tree.expect("a leaf at least")
}

#[test]
fn an_open_group_makes_the_second_sensor_cheap() {
    let question = question();
    let (path, first) = question.step(question.start(), 0);
    let (path, second) = question.step(path, 1);
    assert_eq!((first, second, path.n_read), (3.0, 1.0, 2));
    assert_eq!(question.step(path, 0).1, 0.0);
}

#[test]
fn readings_that_cost_more_than_they_tell_are_left_out() {
    assert_eq!(tree_of(&question()).nodes.len(), 5);
    assert_eq!(tree_of(&Question { multiplier: 1.0, ..question() }).nodes.len(), 1);
}

#[test]
fn a_cap_is_kept() {
    let tree = tree_of(&Question { multiplier: 0.0, cap: Some(18.0), ..question() });
    assert_eq!(tree.nodes.len(), 3);
}

#[test]
fn a_label_with_a_limit_is_told_in_time() {
    let tree = tree_of(&Question { most_readings: vec![9, 9, 1], ..question() });
    assert!(matches!(tree.nodes[0], Node::Split { feature: 1, .. }));
}

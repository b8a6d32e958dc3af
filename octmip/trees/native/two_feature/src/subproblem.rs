//! A problem over some of its samples, and what a tree costs over all of them by its own rule.

use octmip_check::problem::{Planes, Problem};
use octmip_frame::tree::{Node, Tree};

use crate::loss::INFEASIBLE;

/// The problem of one level less over some samples.
pub(crate) fn child_of(problem: &Problem, ids: &[u32], leaf_size: usize) -> Problem {
    let pick = |f: usize| ids.iter().map(move |&i| problem.feature(f)[i as usize]);
    let planes = problem.planes.as_ref();
    Problem {
        n: ids.len(),
        ranks: (0..problem.p).flat_map(pick).collect::<Vec<_>>().into(),
        n_ranks: problem.n_ranks.clone(),
        labels: ids.iter().map(|&i| problem.labels[i as usize]).collect(),
        weights: ids.iter().map(|&i| problem.weights[i as usize]).collect(),
        depth: problem.depth - 1,
        leaf_size,
        planes: planes.map(|planes| Planes {
            values: ids.iter().flat_map(|&i| problem.row(i).iter().copied()).collect(),
            ..planes.clone()
        }),
        ..problem.clone()
    }
}

/// The objective of a tree, each sample sent down by the tree's own rule; infeasible where a leaf is too small.
pub(crate) fn objective(problem: &Problem, tree: &Tree) -> i64 {
    let mut sizes = vec![0; tree.nodes.len()];
    let mut cost = 0;
    for i in 0..problem.n {
        let mut at = 0;
        let label = loop {
            at = match &tree.nodes[at] {
                Node::Leaf { label } => break *label,
                Node::Split { feature, cut, left, right } => {
                    if problem.feature(*feature as usize)[i] <= *cut {
                        *left
                    } else {
                        *right
                    }
                }
                Node::Hyperplane { terms, offset, left, right } => {
                    let row = problem.row(i as u32);
                    let reach = terms.iter().fold(0.0, |sum, &(f, coefficient)| sum + coefficient * row[f as usize]);
                    if reach <= *offset { *left } else { *right }
                }
            } as usize;
        };
        sizes[at] += 1;
        cost += problem.weights[i] * problem.cost(problem.labels[i] as usize, label as usize);
    }
    for (node, &size) in tree.nodes.iter().zip(&sizes) {
        match node {
            Node::Leaf { .. } if size < problem.leaf_size => return INFEASIBLE,
            Node::Leaf { .. } => {}
            Node::Split { .. } => cost += problem.penalty,
            Node::Hyperplane { terms, .. } => cost += problem.penalty * terms.len() as i64,
        }
    }
    cost
}

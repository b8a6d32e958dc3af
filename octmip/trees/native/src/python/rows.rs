//! Trees at the Python border: flat tables of nodes.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::tree::{Node, Tree};

/// One row of the node table: type, feature, cut, left, right, label, hyperplane terms, hyperplane offset.
pub(crate) type NodeRow = (u8, u32, u32, u32, u32, u32, Vec<(u32, f64)>, f64);

/// The node table of a tree.
pub(crate) fn rows_from_tree(tree: &Tree) -> Vec<NodeRow> {
    tree.nodes
        .iter()
        .map(|node| match node {
            Node::Leaf { label } => (0, 0, 0, 0, 0, *label, Vec::new(), 0.0),
            Node::Split { feature, cut, left, right } => (1, *feature, *cut, *left, *right, 0, Vec::new(), 0.0),
            Node::Hyperplane { terms, offset, left, right } => (2, 0, 0, *left, *right, 0, terms.clone(), *offset),
        })
        .collect()
}

/// The tree of a node table.
pub(crate) fn tree_from_rows(rows: Vec<NodeRow>) -> PyResult<Tree> {
    let n = rows.len() as u32;
    let nodes = rows
        .into_iter()
        .enumerate()
        .map(|(i, (node_type, feature, cut, left, right, label, terms, offset))| {
            if node_type != 0 && !(left > i as u32 && left < n && right > i as u32 && right < n) {
                return Err(PyValueError::new_err(format!("node {i} of {n} has children {left} and {right}")));
            }
            Ok(match node_type {
                0 => Node::Leaf { label },
                1 => Node::Split { feature, cut, left, right },
                _ => Node::Hyperplane { terms, offset, left, right },
            })
        })
        .collect::<PyResult<Vec<_>>>()?;
    if nodes.is_empty() {
        return Err(PyValueError::new_err("the node table is empty"));
    }
    Ok(Tree { nodes })
}

//! Trees at the Python border: flat tables of nodes.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use octmip_frame::tree::{Node, Tree};

/// One row of the node table: a dict with these names. Children are rows further down.
#[derive(Clone, FromPyObject, IntoPyObject)]
pub(crate) enum NodeRow {
    /// A leaf.
    Leaf {
        /// Label that it predicts.
        #[pyo3(item)]
        label: u32,
    },
    /// A split at a rank: as much and less goes left.
    Split {
        /// Feature that it reads.
        #[pyo3(item)]
        feature: u32,
        /// The largest rank on its left.
        #[pyo3(item)]
        cut: u32,
        /// Row of the left child.
        #[pyo3(item)]
        left: u32,
        /// Row of the right child.
        #[pyo3(item)]
        right: u32,
    },
    /// A split by a hyperplane.
    Hyperplane {
        /// Features and coefficients.
        #[pyo3(item)]
        terms: Vec<(u32, f64)>,
        /// What the sum of the terms is held against.
        #[pyo3(item)]
        offset: f64,
        /// Row of the left child.
        #[pyo3(item)]
        left: u32,
        /// Row of the right child.
        #[pyo3(item)]
        right: u32,
    },
}

/// A feasible tree and its cost, as a search takes it.
pub(crate) type Incumbent = Option<(i64, Vec<NodeRow>)>;

/// The node table of a tree.
pub(crate) fn rows_from_tree(tree: &Tree) -> Vec<NodeRow> {
    let row = |node: &Node| match node {
        Node::Leaf { label } => NodeRow::Leaf { label: *label },
        Node::Split { feature, cut, left, right } => {
            NodeRow::Split { feature: *feature, cut: *cut, left: *left, right: *right }
        }
        Node::Hyperplane { terms, offset, left, right } => {
            NodeRow::Hyperplane { terms: terms.clone(), offset: *offset, left: *left, right: *right }
        }
    };
    tree.nodes.iter().map(row).collect()
}

/// The tree of an incumbent, with its cost.
pub(crate) fn known_tree(incumbent: Incumbent) -> PyResult<Option<(i64, Tree)>> {
    incumbent.map(|(cost, rows)| Ok((cost, tree_from_rows(rows)?))).transpose()
}

/// The tree of a node table.
pub(crate) fn tree_from_rows(rows: Vec<NodeRow>) -> PyResult<Tree> {
    let n = rows.len() as u32;
    let nodes = rows
        .into_iter()
        .enumerate()
        .map(|(i, row)| {
            let parent = |left: u32, right: u32| {
                let holds = |child: u32| child > i as u32 && child < n;
                let complaint = || format!("node {i} of {n} has children {left} and {right}");
                if holds(left) && holds(right) { Ok(()) } else { Err(PyValueError::new_err(complaint())) }
            };
            Ok(match row {
                NodeRow::Leaf { label } => Node::Leaf { label },
                NodeRow::Split { feature, cut, left, right } => {
                    parent(left, right)?;
                    Node::Split { feature, cut, left, right }
                }
                NodeRow::Hyperplane { terms, offset, left, right } => {
                    parent(left, right)?;
                    Node::Hyperplane { terms, offset, left, right }
                }
            })
        })
        .collect::<PyResult<Vec<_>>>()?;
    if nodes.is_empty() {
        return Err(PyValueError::new_err("the node table is empty"));
    }
    Ok(Tree { nodes })
}

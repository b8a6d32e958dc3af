//! Trees as a flat table of nodes, root first.

pub mod reached;

/// One node. A sample goes left when `rank <= cut`, or when `terms . x <= offset`.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// A prediction.
    Leaf {
        /// Class index.
        label: u32,
    },
    /// A cut of one feature.
    Split {
        /// Feature index.
        feature: u32,
        /// Largest rank that goes left.
        cut: u32,
        /// Index of the left child.
        left: u32,
        /// Index of the right child.
        right: u32,
    },
    /// A hyperplane, in the units of the feature values.
    Hyperplane {
        /// Feature and coefficient, features ascending.
        terms: Vec<(u32, f64)>,
        /// Largest projection that goes left.
        offset: f64,
        /// Index of the left child.
        left: u32,
        /// Index of the right child.
        right: u32,
    },
}

/// A tree: `nodes[0]` is the root.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// The nodes in preorder.
    pub nodes: Vec<Node>,
}

impl Tree {
    /// A tree of one leaf.
    pub fn leaf(label: u32) -> Self {
        Self { nodes: vec![Node::Leaf { label }] }
    }

    /// A tree with a cut at its root.
    pub fn join(feature: u32, cut: u32, left: &Tree, right: &Tree) -> Self {
        let first_right = 1 + left.nodes.len() as u32;
        let mut nodes = vec![Node::Split { feature, cut, left: 1, right: first_right }];
        nodes.extend(left.nodes.iter().map(|node| node.shifted(1)));
        nodes.extend(right.nodes.iter().map(|node| node.shifted(first_right)));
        Self { nodes }
    }

    /// Number of splits.
    pub fn n_splits(&self) -> usize {
        self.nodes.len() / 2
    }

    /// Whether a split of one feature asks this one.
    pub fn reads(&self, asked: u32) -> bool {
        self.nodes.iter().any(|node| matches!(node, Node::Split { feature, .. } if *feature == asked))
    }
}

impl Node {
    fn shifted(&self, by: u32) -> Self {
        let mut node = self.clone();
        match &mut node {
            Node::Leaf { .. } => {}
            Node::Split { left, right, .. } | Node::Hyperplane { left, right, .. } => {
                *left += by;
                *right += by;
            }
        }
        node
    }
}

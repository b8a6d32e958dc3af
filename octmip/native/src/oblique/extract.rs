//! From a search's lines to a tree over the values as given, every split in mid-gap and recounted in floating point.

use crate::problem::Problem;
use crate::tree::{Node, Tree};

use super::ground::Ground;
use super::loss::INFEASIBLE;
use super::margin::widest_gap;
use super::view::Line;

/// A tree as a search knows it: lines with children, none = a leaf.
#[derive(Debug, Clone, PartialEq)]
pub enum Sketch {
    /// A leaf, its label still open.
    Leaf,
    /// A line and what follows on both sides.
    Split(Line, Box<[Sketch; 2]>),
}

impl Sketch {
    /// A stump (or a leaf).
    pub fn stump(line: Option<Line>) -> Self {
        line.map_or(Self::Leaf, |line| {
            Self::Split(line, Box::new([Self::Leaf, Self::Leaf]))
        })
    }
}

/// Draw the tree of a sketch and count its objective by the tree's own rule; None where rounding spoils a split.
///
/// Idle parts go: a split with an empty side, or with two leaves of one label.
pub fn draw(problem: &Problem, ground: &Ground, sketch: &Sketch) -> Option<(Tree, i64)> {
    let (tree, cost) = draw_part(problem, ground, sketch, &ground.all())?;
    (cost < INFEASIBLE).then_some((tree, cost))
}

fn draw_part(
    problem: &Problem,
    ground: &Ground,
    sketch: &Sketch,
    ids: &[u32],
) -> Option<(Tree, i64)> {
    let tally = ground.view().tally(ids);
    let (leaf_cost, label) = ground.loss.leaf(&tally);
    let leaf = || {
        let is_too_small = tally[ground.loss.k] < ground.loss.leaf_size as i64;
        let cost = if is_too_small { INFEASIBLE } else { leaf_cost };
        Some((Tree::leaf(label as u32), cost))
    };
    let Sketch::Split(line, children) = sketch else {
        return leaf();
    };
    let (left, right): (Vec<u32>, Vec<u32>) = ids
        .iter()
        .partition(|&&i| line.sends_left(&ground.plane, i));
    if left.is_empty() || right.is_empty() {
        let side = usize::from(left.is_empty());
        return draw_part(problem, ground, &children[side], ids);
    }
    let (left_tree, left_cost) = draw_part(problem, ground, &children[0], &left)?;
    let (right_tree, right_cost) = draw_part(problem, ground, &children[1], &right)?;
    let node = split_node(problem, ground, line.features, &left, &right);
    let n_features = match &node {
        Some(Node::Hyperplane { terms, .. }) => terms.len(),
        _ => 1,
    };
    let price = ground.loss.prices[n_features - 1];
    let cost = (left_cost + right_cost + price).min(INFEASIBLE);
    let size = tally[ground.loss.k];
    if size >= ground.loss.leaf_size as i64 && leaf_cost <= cost {
        return leaf();
    }
    Some((join(node?, &left_tree, &right_tree), cost))
}

/// A split that parts two sets of samples, its children still to be linked.
fn split_node(
    problem: &Problem,
    ground: &Ground,
    (f, g): (usize, usize),
    left: &[u32],
    right: &[u32],
) -> Option<Node> {
    if g == ground.plane.p {
        let highest = left.iter().map(|&i| ground.plane.point(f, g, i).0).max()?;
        return Some(axis_node(f, highest));
    }
    let (f, g) = (f.min(g), f.max(g));
    let (normal, _) = widest_gap(&ground.plane, (f, g), left, right)?;
    let coefficients = [
        normal.0 / ground.plane.half_spans[f],
        normal.1 / ground.plane.half_spans[g],
    ];
    let largest = coefficients[0].abs().max(coefficients[1].abs());
    let real = [coefficients[0] / largest, coefficients[1] / largest];
    let most = problem
        .planes
        .as_ref()
        .and_then(|planes| planes.integer_normals);
    let chosen = match most {
        Some(most) => whole_normals(real, most)
            .find(|&normal| offset_of(ground, (f, g), normal, left, right).is_some())?,
        None => real,
    };
    let offset = offset_of(ground, (f, g), chosen, left, right)?;
    let terms: Vec<(u32, f64)> = [(f as u32, chosen[0]), (g as u32, chosen[1])]
        .into_iter()
        .filter(|term| term.1 != 0.0)
        .collect();
    Some(Node::Hyperplane {
        terms,
        offset,
        left: 0,
        right: 0,
    })
}

fn axis_node(f: usize, cut: u32) -> Node {
    Node::Split {
        feature: f as u32,
        cut,
        left: 0,
        right: 0,
    }
}

/// Whole-number normals of at most this size near a direction, the shortest first.
fn whole_normals(direction: [f64; 2], most: i64) -> impl Iterator<Item = [f64; 2]> {
    const TRIED: i64 = 10_000;
    (1..=most.min(TRIED)).flat_map(move |size| {
        let at = size as f64;
        let near = direction.map(|c| (c * at).round());
        let steps = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        steps.into_iter().filter_map(move |step| {
            let normal = [near[0] + step[0], near[1] + step[1]];
            let fits = normal.iter().all(|c| c.abs() <= most as f64);
            (fits && normal != [0.0, 0.0]).then_some(normal)
        })
    })
}

/// The offset midway between both sides, None if this normal does not part them by the rule of `octmip.tree`.
fn offset_of(
    ground: &Ground,
    (f, g): (usize, usize),
    normal: [f64; 2],
    left: &[u32],
    right: &[u32],
) -> Option<f64> {
    let (x, y) = (ground.plane.values(f), ground.plane.values(g));
    // Products rounded, then added from the first feature to the last, beginning with zero; zero terms are left out.
    let reach = |&i: &u32| {
        let mut total = 0.0;
        if normal[0] != 0.0 {
            total += normal[0] * x[i as usize];
        }
        if normal[1] != 0.0 {
            total += normal[1] * y[i as usize];
        }
        total
    };
    let highest = left.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
    let lowest = right.iter().map(reach).fold(f64::INFINITY, f64::min);
    let middle = highest / 2.0 + lowest / 2.0;
    let offset = if highest <= middle && middle < lowest {
        middle
    } else {
        highest
    };
    (highest < lowest && offset.is_finite()).then_some(offset)
}

fn join(node: Node, left: &Tree, right: &Tree) -> Tree {
    // Any cut serves to lay out the table; the node itself takes its place.
    let mut tree = Tree::join(0, 0, left, right);
    let (first, second) = (1, 1 + left.nodes.len() as u32);
    tree.nodes[0] = match node {
        Node::Split { feature, cut, .. } => Node::Split {
            feature,
            cut,
            left: first,
            right: second,
        },
        Node::Hyperplane { terms, offset, .. } => Node::Hyperplane {
            terms,
            offset,
            left: first,
            right: second,
        },
        leaf @ Node::Leaf { .. } => leaf,
    };
    tree
}

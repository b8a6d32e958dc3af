//! Trees of lines, and the trees over the values as given that they become: every split in mid-gap and recounted in
//! floating point.

use crate::geometry::hull::hull;
use crate::geometry::line::Line;
use crate::geometry::margin::widest_gap;
use crate::instance::Instance;
use crate::loss::INFEASIBLE;
use octmip_check::problem::Problem;
use octmip_frame::tree::{Node, Tree};

/// A tree of lines over scaled coordinates, as a search finds it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum LineTree {
    /// A leaf, its label still open.
    Leaf,
    /// A line and what follows on both sides.
    Split(Line, Box<[LineTree; 2]>),
}

impl LineTree {
    /// A stump (or a leaf).
    pub(crate) fn stump(line: Option<Line>) -> Self {
        line.map_or(Self::Leaf, |line| Self::Split(line, Box::new([Self::Leaf, Self::Leaf])))
    }
}

/// The tree of a tree of lines and its objective, counted by the tree's own rule; None where rounding spoils a split.
///
/// Idle parts go: a split with an empty side, or with two leaves of one label.
pub(crate) fn to_tree(problem: &Problem, instance: &Instance, line_tree: &LineTree) -> Option<(Tree, i64)> {
    let (tree, cost) = to_subtree(problem, instance, line_tree, &instance.all())?;
    (cost < INFEASIBLE).then_some((tree, cost))
}

fn to_subtree(problem: &Problem, instance: &Instance, line_tree: &LineTree, ids: &[u32]) -> Option<(Tree, i64)> {
    let tally = instance.samples().tally(ids);
    let (leaf_cost, label) = instance.loss.leaf(&tally);
    let leaf = || {
        let is_too_small = tally[instance.loss.k] < instance.loss.leaf_size as i64;
        let cost = if is_too_small { INFEASIBLE } else { leaf_cost };
        Some((Tree::leaf(label as u32), cost))
    };
    let LineTree::Split(line, children) = line_tree else {
        return leaf();
    };
    let (left, right): (Vec<u32>, Vec<u32>) = ids.iter().partition(|&&i| line.sends_left(&instance.plane, i));
    if left.is_empty() || right.is_empty() {
        let side = usize::from(left.is_empty());
        return to_subtree(problem, instance, &children[side], ids);
    }
    let (left_tree, left_cost) = to_subtree(problem, instance, &children[0], &left)?;
    let (right_tree, right_cost) = to_subtree(problem, instance, &children[1], &right)?;
    let node = split_node(problem, instance, line.features, &left, &right);
    let n_features = match &node {
        Some(Node::Hyperplane { terms, .. }) => terms.len(),
        _ => 1,
    };
    let price = instance.loss.prices[n_features - 1];
    let cost = (left_cost + right_cost + price).min(INFEASIBLE);
    let size = tally[instance.loss.k];
    if size >= instance.loss.leaf_size as i64 && leaf_cost <= cost {
        return leaf();
    }
    Some((join(node?, &left_tree, &right_tree), cost))
}

/// A split that parts two sets of samples, its children still to be linked.
pub(crate) fn split_node(
    problem: &Problem,
    instance: &Instance,
    (f, g): (usize, usize),
    left: &[u32],
    right: &[u32],
) -> Option<Node> {
    if g == instance.plane.p {
        let highest = left.iter().map(|&i| instance.plane.point(f, g, i).0).max()?;
        return Some(axis_node(f, highest));
    }
    let (f, g) = (f.min(g), f.max(g));
    let (normal, _) = widest_gap(&instance.plane, (f, g), left, right)?;
    let spans = [instance.plane.half_spans[f], instance.plane.half_spans[g]];
    let least = spans[0].min(spans[1]);
    let coefficients = [normal.0 * (least / spans[0]), normal.1 * (least / spans[1])];
    let largest = coefficients[0].abs().max(coefficients[1].abs());
    let real = [coefficients[0] / largest, coefficients[1] / largest];
    let planes = problem.planes.as_ref();
    let demanded = planes.and_then(|planes| planes.integer_normals);
    let whole = demanded.or(instance.preferred).and_then(|most| {
        let cone = parting_cone(instance, (f, g), real, left, right)?;
        whole_normals(real, cone, most).find(|&normal| offset_of(instance, (f, g), normal, left, right).is_some())
    });
    let chosen = match whole {
        Some(normal) => normal,
        None if demanded.is_some() => return None,
        None => real,
    };
    let offset = offset_of(instance, (f, g), chosen, left, right)?;
    let terms: Vec<(u32, f64)> =
        [(f as u32, chosen[0]), (g as u32, chosen[1])].into_iter().filter(|term| term.1 != 0.0).collect();
    Some(Node::Hyperplane { terms, offset, left: 0, right: 0 })
}

fn axis_node(f: usize, cut: u32) -> Node {
    Node::Split { feature: f as u32, cut, left: 0, right: 0 }
}

/// The range over which a normal can turn to either side (tangents of the angles, the right-hand one negative) and
/// still part two sets.
///
/// A normal parts them if every step from left to right runs along it; steps between corners of the hulls decide.
fn parting_cone(
    instance: &Instance,
    (f, g): (usize, usize),
    normal: [f64; 2],
    left: &[u32],
    right: &[u32],
) -> Option<[f64; 2]> {
    let plane = &instance.plane;
    let (x, y) = (plane.column(f), plane.column(g));
    let (from, to) = (hull(plane, (f, g), left), hull(plane, (f, g), right));
    let mut cone = [f64::NEG_INFINITY, f64::INFINITY];
    for (&i, &j) in from.iter().flat_map(|i| to.iter().map(move |j| (i, j))) {
        let (i, j) = (i as usize, j as usize);
        let step = [(x[j] - x[i]) * plane.half_spans[f], (y[j] - y[i]) * plane.half_spans[g]];
        let along = normal[0] * step[0] + normal[1] * step[1];
        let across = normal[0] * step[1] - normal[1] * step[0];
        // normal + turn * (normal turned left) runs along the step while along + turn * across > 0.
        let turn = -along / across;
        if across > 0.0 {
            cone[0] = cone[0].max(turn);
        } else if across < 0.0 {
            cone[1] = cone[1].min(turn);
        }
    }
    Some(cone)
}

/// Whole-number normals of at most this size within a cone about a direction, the shortest first.
///
/// One coefficient after the other takes each size in turn; where the cone's edges meet that size lies between what the
/// other may be, and whole numbers there, the middle ones first, are tried.
fn whole_normals(direction: [f64; 2], cone: [f64; 2], most: i64) -> impl Iterator<Item = [f64; 2]> {
    const TRIED: i64 = 100_000;
    const NEAR: [f64; 5] = [0.0, 1.0, -1.0, 2.0, -2.0];
    // The cone within the quarter turns about the direction; parallels beyond are met from the other coefficient.
    let edges = cone.map(|turn| {
        let turn = turn.clamp(-1e9, 1e9);
        let [a, b] = direction;
        [a - turn * b, b + turn * a]
    });
    let sizes = (1..=most.min(TRIED)).map(|size| size as f64);
    sizes.flat_map(move |size| {
        let tries = (0..2).flat_map(move |k| [size, -size].map(|value| (k, value)));
        tries.flat_map(move |(k, value)| {
            // Where the edge rays pass this value of coefficient k, if they do.
            let at = |edge: [f64; 2]| {
                let scale = value / edge[k];
                let other = (edge[1 - k] * scale).clamp(-size, size);
                let far = if edge[1 - k] > 0.0 { size } else { -size };
                if scale > 0.0 { other } else { far }
            };
            let (low, high) = (at(edges[0]), at(edges[1]));
            let middle = ((low + high) / 2.0).round();
            let is_met = edges.iter().any(|edge| edge[k] * value > 0.0);
            NEAR.into_iter().filter_map(move |step| {
                let mut normal = [value; 2];
                normal[1 - k] = middle + step;
                let is_inside = low.min(high) <= normal[1 - k] && normal[1 - k] <= low.max(high);
                (is_met && is_inside).then_some(normal)
            })
        })
    })
}

/// The offset midway between both sides, None if this normal does not part them by `octmip.trees.nodes.tree`'s rule.
fn offset_of(
    instance: &Instance,
    (f, g): (usize, usize),
    normal: [f64; 2],
    left: &[u32],
    right: &[u32],
) -> Option<f64> {
    let (x, y) = (instance.plane.values(f), instance.plane.values(g));
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
    let offset = if highest <= middle && middle < lowest { middle } else { highest };
    (highest < lowest && offset.is_finite()).then_some(offset)
}

/// A tree with this split at its root.
pub(crate) fn join(node: Node, left: &Tree, right: &Tree) -> Tree {
    // Any cut serves to lay out the table; the node itself takes its place.
    let mut tree = Tree::join(0, 0, left, right);
    let (first, second) = (1, 1 + left.nodes.len() as u32);
    tree.nodes[0] = match node {
        Node::Split { feature, cut, .. } => Node::Split { feature, cut, left: first, right: second },
        Node::Hyperplane { terms, offset, .. } => Node::Hyperplane { terms, offset, left: first, right: second },
        leaf @ Node::Leaf { .. } => leaf,
    };
    tree
}

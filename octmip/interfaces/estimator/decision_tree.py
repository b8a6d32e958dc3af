"""A tree as scikit-learn's own DecisionTreeClassifier, for programs that read those: SHAP, dtreeviz, skl2onnx.

scikit-learn rounds the samples to float32 before it compares them with a threshold, so a sample within that rounding
of a threshold may go the other way. What would differ on the training samples is refused.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.tree import DecisionTreeClassifier
from sklearn.tree._tree import NODE_DTYPE, TREE_LEAF, TREE_UNDEFINED, Tree

from octmip.errors import TreeError
from octmip.interfaces.estimator.paths import NodeTable
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, depth, goes_left, leaf_index, leaves, splits
from octmip.trees.question.problem import Problem
from octmip.trees.uncertainty import LeafDistribution

Floats = NDArray[np.float64]


def sklearn_tree(problem: Problem, distribution: LeafDistribution, classes: NDArray[Any]) -> DecisionTreeClassifier:
    """Return a fitted DecisionTreeClassifier with the splits and leaf probabilities of a tree.

    Raises
    ------
    TreeError
        the tree reads hyperplanes, or scikit-learn's tree would predict another class for a training sample.
    """
    tree = distribution.tree
    if any(isinstance(split, HyperplaneSplit) for split in splits(tree)):
        raise TreeError(
            "a tree with hyperplanes has no form as a DecisionTreeClassifier, whose splits read one feature each; fit "
            "with split='axis'"
        )
    _refuse_rounding(problem, tree)
    _refuse_other_labels(distribution, classes)
    model = DecisionTreeClassifier(max_depth=problem.shape.depth, min_samples_leaf=problem.shape.leaf_size)
    model.classes_, model.n_classes_ = classes.copy(), np.int64(len(classes))
    model.n_features_in_ = model.max_features_ = problem.samples.n_features
    model.n_outputs_ = 1
    model.tree_ = _cython_tree(problem, distribution)
    return model


def _refuse_rounding(problem: Problem, tree: Node) -> None:
    """Refuse a split that sends a training sample to its other side once the sample is rounded to float32."""
    samples = problem.samples
    with np.errstate(over="ignore"):
        rounded = samples.features.astype(np.float32).astype(np.float64)
    moved = np.flatnonzero(leaf_index(tree, samples.features) != leaf_index(tree, rounded))
    if not len(moved) and not np.isinf(rounded).any():
        return
    for split in splits(tree):
        assert isinstance(split, Split)
        other = goes_left(split, samples.features, moved) != goes_left(split, rounded, moved)
        if other.any():
            name, value = (samples.feature_names[split.feature], samples.features[moved[other][0], split.feature])
            raise TreeError(
                f"scikit-learn reads samples as float32, which takes {name!r} = {value} to the other side "
                f"of {split.threshold}; subtract an offset from this column, or round it to float32 before fitting"
            )
    raise TreeError("a sample lies beyond float32 (3.4e38), as which scikit-learn reads it; scale the columns down")


def _refuse_other_labels(distribution: LeafDistribution, classes: NDArray[Any]) -> None:
    """Refuse leaves whose label is not that of their greatest share, which a DecisionTreeClassifier would predict."""
    labels = np.array([leaf.label for leaf in leaves(distribution.tree)])
    greatest = distribution.probabilities.argmax(axis=1)
    if (labels != greatest).any():
        k = int(np.flatnonzero(labels != greatest)[0])
        raise TreeError(
            f"leaf {k} (from the left) predicts {classes[labels[k]]!r}, which costs least there, and a "
            f"DecisionTreeClassifier would predict {classes[greatest[k]]!r}, which has the greatest share; state costs "
            "by class_weight or sample_weight"
        )


def _cython_tree(problem: Problem, distribution: LeafDistribution) -> Tree:
    table = NodeTable.of(distribution.tree)
    samples, weights = _node_totals(problem, distribution, table)
    totals = weights.sum(axis=1)
    rows = np.zeros(len(table.nodes), dtype=NODE_DTYPE)
    rows["left_child"] = np.where(table.left < 0, TREE_LEAF, table.left)
    rows["right_child"] = np.where(table.right < 0, TREE_LEAF, table.right)
    rows["feature"] = [node.feature if isinstance(node, Split) else TREE_UNDEFINED for node in table.nodes]
    rows["threshold"] = [_threshold(node) for node in table.nodes]
    rows["missing_go_to_left"] = [not isinstance(node, Leaf) and node.missing == "left" for node in table.nodes]
    rows["n_node_samples"], rows["weighted_n_node_samples"] = samples, totals
    shares = weights / np.where(totals > 0, totals, 1.0)[:, None]
    rows["impurity"] = 1 - (shares**2).sum(axis=1)
    shares[table.leaf_nodes] = distribution.probabilities
    tree = Tree(problem.samples.n_features, np.array([problem.samples.n_classes], dtype=np.intp), 1)
    state = {"max_depth": depth(distribution.tree), "node_count": len(rows), "nodes": rows, "values": shares[:, None]}
    tree.__setstate__(state)
    return tree


def _threshold(node: Node) -> float:
    """Return a threshold as scikit-learn has it: infinite where a split asks for missing readings alone."""
    if not isinstance(node, Split):
        return float(TREE_UNDEFINED)
    if node.threshold is None:
        return -np.inf if node.missing == "left" else np.inf
    return node.threshold


def _node_totals(
    problem: Problem, distribution: LeafDistribution, table: NodeTable
) -> tuple[NDArray[np.int64], Floats]:
    """Return samples (n_nodes,) and weight of each class (n_nodes, n_classes) in every node."""
    reached = leaf_index(distribution.tree, problem.samples.features)
    samples = np.zeros(len(table.nodes), dtype=np.int64)
    weights = np.zeros((len(table.nodes), problem.samples.n_classes))
    samples[table.leaf_nodes] = np.bincount(reached, minlength=len(table.leaf_nodes))
    weights[table.leaf_nodes] = distribution.weights
    for k in reversed(range(len(table.nodes))):
        if not isinstance(table.nodes[k], Leaf):
            samples[k] = samples[table.left[k]] + samples[table.right[k]]
            weights[k] = weights[table.left[k]] + weights[table.right[k]]
    return samples, weights

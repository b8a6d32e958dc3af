"""What a leaf predicts for its samples: one number, or a ridge regression over some features."""

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.tree import Node, ValueLeaf, predict_values
from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
LARGEST = 1e300
"""Sum of errors that is told from a larger one."""


def errors(problem: Problem, node: Node, rows: Rows) -> Floats:
    """Return the weighted error of each of some samples under a subtree, shape (n_rows,)."""
    misses = problem.samples.targets[rows] - predict_values(node, problem.samples.features[rows])
    with np.errstate(over="ignore"):
        weighted: Floats = problem.samples.weights[rows] * problem.number_loss.of_misses(misses)
    # Sums stay finite: beyond that size a tree is worse than any other, and how much worse does not matter.
    return np.minimum(weighted, LARGEST / max(1, len(rows)))


def fitted_leaf(problem: Problem, rows: Rows, usable: Rows) -> ValueLeaf:
    """Return the leaf for some samples: by least error its number, or a ridge over `usable` where that is better."""
    constant = ValueLeaf(constant_of(problem, rows))
    if problem.shape.leaf_model == "constant":
        return constant
    linear = _ridge(problem, rows, usable)
    is_better = linear is not None and errors(problem, linear, rows).sum() < errors(problem, constant, rows).sum()
    return linear if linear is not None and is_better else constant


def constant_of(problem: Problem, rows: Rows) -> float:
    """Return the constant of least error for the targets of some samples, in float64."""
    weights, targets = problem.samples.weights[rows], problem.samples.targets[rows]
    return _constant(problem, targets, weights if weights.any() else np.ones(len(rows)))


def _constant(problem: Problem, values: Floats, weights: Floats) -> float:
    """Return the weighted mean, or the lowest weighted quantile of a sloped error."""
    slopes = problem.number_loss.slopes
    if slopes is None:
        return float(np.average(values, weights=weights))
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return float(values[order[int(np.searchsorted(below, below[-1] * slopes.up / (slopes.up + slopes.down)))]])


def _ridge(problem: Problem, rows: Rows, usable: Rows) -> ValueLeaf | None:
    """Return a ridge regression of the samples over the features that vary, None where none does.

    Minimises ``sum_i w_i (y_i - a - sum_j b_j x_ij)^2 + ridge * W * sum_j var_j b_j^2``, W the sum of the weights and
    var_j the variance of feature j in the leaf; the number `a` is not shrunk. Source: Hoerl & Kennard (1970), eq. 2.1.
    For sloped errors `a` becomes the quantile of what is left.
    """
    samples = problem.samples
    weights = samples.weights[rows]
    if not weights.any():
        return None
    weights = weights / weights.sum()
    values = samples.features[np.ix_(rows, usable)]
    centre = weights @ values
    spread = np.sqrt(weights @ (values - centre) ** 2)
    varies = spread > 1e-9 * np.abs(values).max(axis=0)
    if not varies.any():
        return None
    scaled = (values[:, varies] - centre[varies]) / spread[varies]
    target = samples.targets[rows] - weights @ samples.targets[rows]
    gram = scaled.T @ (weights[:, None] * scaled) + max(problem.shape.ridge, 1e-12) * np.eye(int(varies.sum()))
    slopes = np.linalg.solve(gram, scaled.T @ (weights * target)) / spread[varies]
    kept = slopes != 0
    features, slopes = usable[varies][kept], slopes[kept]
    if not len(features) or not np.isfinite(slopes).all():
        return None
    left = samples.targets[rows] - samples.features[np.ix_(rows, features)] @ slopes
    return ValueLeaf(_constant(problem, left, weights), tuple(features.tolist()), tuple(slopes.tolist()))

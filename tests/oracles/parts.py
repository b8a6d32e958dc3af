"""The least cost of trees with parts that are asked for, of a small problem: every tree is looked at, none is cut off.

Imports nothing of octmip but the problem and its trees. A threshold lies between two neighbouring values of all
samples, or where a given or an old one does; missing readings go to either side.
"""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.tree import Leaf, Node, Split
from octmip.trees.question.parts import GivenSplit, PathRule
from octmip.trees.question.problem import Problem

Costs = dict[tuple[int, int], Fraction]
"""Least cost by the numbers of splits and of changes."""


def least_cost_with_parts(problem: Problem) -> Fraction | None:
    """Return the least objective over all trees that have the parts and keep the rules; None where there is none."""
    asked = {part.path: part for part in problem.shape.fixed_splits or ()}
    rules = problem.shape.path_rules or ()
    costs = _costs(problem, asked, rules, np.arange(problem.samples.n_samples), "", (), problem.shape.old_tree)
    most = np.inf if problem.shape.max_splits is None else problem.shape.max_splits
    limit = np.inf if problem.shape.max_changes is None else problem.shape.max_changes
    return min((cost for (splits, changes), cost in costs.items() if splits <= most and changes <= limit), default=None)


def _costs(
    problem: Problem,
    asked: dict[str, GivenSplit],
    rules: tuple[PathRule, ...],
    rows: NDArray[np.int64],
    path: str,
    above: tuple[int, ...],
    old: Node | None,
) -> Costs:
    found: Costs = {}
    if len(rows) < problem.shape.leaf_size:
        return found
    here = asked.get(path)
    is_split_below = any(part.features and one.startswith(path) for one, part in asked.items())
    if not is_split_below:
        leaf = min(Fraction(float(cost)) for cost in problem.class_costs(rows))
        found[0, _n_splits(old)] = leaf
    if len(path) == problem.shape.depth or (here is not None and not here.features):
        return found
    for feature in range(problem.samples.n_features):
        if not all(_may_follow(rule, feature, above) for rule in rules):
            continue
        for threshold, side_of_missing in _cuts(problem, feature):
            if here is not None and (feature not in here.features or here.threshold not in (None, threshold)):
                continue
            values = problem.samples.features[rows, feature]
            # Without a threshold the question is whether there is a reading.
            is_left = values <= threshold if threshold is not None else np.full(len(rows), side_of_missing == "right")
            is_left = np.where(np.isnan(values), side_of_missing == "left", is_left)
            is_old = (
                isinstance(old, Split)
                and (old.feature, old.threshold) == (feature, threshold)
                and (None in (old.missing, side_of_missing) or old.missing == side_of_missing)
            )
            was = [None, None] if old is None or isinstance(old, Leaf) else [old.left, old.right]
            sides = [
                _costs(problem, asked, rules, rows[part], path + "LR"[side], (*above, feature), was[side])
                for side, part in enumerate((is_left, ~is_left))
            ]
            for (splits, changes), cost in sides[0].items():
                for (more, others), other in sides[1].items():
                    key = splits + more + 1, changes + others + (not is_old)
                    total = cost + other + Fraction(problem.shape.leaf_penalty)
                    found[key] = min(total, found.get(key, total))
    return found


def _may_follow(rule: tuple[str, tuple[int, ...]], feature: int, above: tuple[int, ...]) -> bool:
    kind, features = rule
    if kind == "not-below":
        return feature != features[0] or not set(features[1:]) & set(above)
    if kind == "apart":
        return feature not in features or not (set(features) - {feature}) & set(above)
    return feature not in features or not above


def _cuts(problem: Problem, feature: int) -> list[tuple[float | None, str | None]]:
    """Return the thresholds of a feature with every side that missing readings may take."""
    if not problem.samples.takes_missing:
        return [(threshold, None) for threshold in _thresholds(problem, feature)]
    return [(threshold, side) for threshold in (*_thresholds(problem, feature), None) for side in ("left", "right")]


def _thresholds(problem: Problem, feature: int) -> list[float]:
    values = np.unique(problem.samples.features[:, feature])
    values = values[~np.isnan(values)]
    found = set(((values[:-1] + values[1:]) / 2).tolist())
    found |= {
        part.threshold
        for part in problem.shape.fixed_splits or ()
        if feature in part.features and part.threshold is not None
    }
    return sorted(found | _old_thresholds(problem.shape.old_tree, feature))


def _old_thresholds(old: Node | None, feature: int) -> set[float]:
    if old is None or isinstance(old, Leaf):
        return set()
    own = {old.threshold} if isinstance(old, Split) and old.feature == feature and old.threshold is not None else set()
    return own | _old_thresholds(old.left, feature) | _old_thresholds(old.right, feature)


def _n_splits(old: Node | None) -> int:
    return 0 if old is None or isinstance(old, Leaf) else 1 + _n_splits(old.left) + _n_splits(old.right)

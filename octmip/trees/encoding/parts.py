"""Parts that a problem asks for, as the native core holds them, and the thresholds of a tree that it returns.

The core parts samples at ranks: a given threshold is a rank, and a split of the old tree stays where it parts the
samples that reach it alike. Its tree then gets those very thresholds, which change no prediction of a sample.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding.ranks import Ranks, split_as_cut
from octmip.trees.nodes.tree import Leaf, Node, Split, goes_left
from octmip.trees.question.parts import banned_below
from octmip.trees.question.problem import Problem

NamedRow = tuple[list[tuple[int, int | None]], bool, list[int | None]]
"""Columns with a largest rank on their left (or any), whether a leaf stands there, rows of both sides."""


def rules_of(problem: Problem, ranks: Ranks) -> dict[str, Any]:
    """Return what the core's search for a shape is told of parts."""
    banned = banned_below((problem.shape.path_rules or ()), problem.samples.n_features)
    columns = [ranks.columns_of(feature) for feature in range(problem.samples.n_features)]
    below = [[column for feature in sorted(features) for column in columns[feature]] for features in banned]
    return {
        "given": _given_rows(problem, ranks),
        "old": _old_rows(problem, ranks),
        "max_changes": problem.shape.max_changes,
        "bans": [below[ranks.feature(column)] for column in range(ranks.n_columns)],
    }


def _given_rows(problem: Problem, ranks: Ranks) -> list[NamedRow]:
    given = {part.path: part for part in problem.shape.fixed_splits or ()}
    paths = sorted({path[:k] for path in given for k in range(len(path) + 1)}, key=lambda path: (len(path), path))
    row_of = {path: k for k, path in enumerate(paths)}

    def row(path: str) -> NamedRow:
        part = given.get(path)
        sides = [row_of.get(path + turn) for turn in "LR"]
        if part is None or not part.features:
            return [], part is not None, sides
        return [cut for one in part.features for cut in _splits(one, part.threshold, ranks)], False, sides

    return [row(path) for path in paths]


def _splits(feature: int, threshold: float | None, ranks: Ranks) -> list[tuple[int, int | None]]:
    def cut(column: int) -> int | None:
        if threshold is None:
            return None
        # Below the smallest value the cut would be -1: a rank that parts nothing says the same.
        found = int(np.searchsorted(ranks.values[column], threshold, side="right")) - 1
        return found if found >= 0 else ranks.n_values[column]

    return [(column, cut(column)) for column in ranks.columns_of(feature)]


def _old_rows(problem: Problem, ranks: Ranks) -> list[NamedRow]:
    thresholds = {part.path: part.threshold for part in problem.shape.fixed_splits or ()}
    rows: list[NamedRow] = []

    def add(node: Node, path: str) -> int | None:
        if isinstance(node, Leaf):
            return None
        assert isinstance(node, Split)
        index = len(rows)
        rows.append(([], False, [None, None]))
        is_moved = thresholds.get(path) not in (None, node.threshold)
        sides = [add(node.left, path + "L"), add(node.right, path + "R")]
        rows[index] = ([_nowhere(node, ranks)] if is_moved else _kept(node, ranks)), False, sides
        return index

    add(problem.shape.old_tree or Leaf(0), "")
    return rows


def _kept(split: Split, ranks: Ranks) -> list[tuple[int, int | None]]:
    """Return the cuts that are the same split."""
    if split.missing is not None and len(ranks.columns_of(split.feature)) > 1:
        column, cut = split_as_cut(ranks, split)
        return [(column, cut) if cut >= 0 else _nowhere(split, ranks)]
    if split.threshold is None:
        return [_nowhere(split, ranks)]
    return _splits(split.feature, split.threshold, ranks)


def _nowhere(split: Split, ranks: Ranks) -> tuple[int, int]:
    """Return a cut that parts no samples: the split is one that no tree here can have."""
    column = ranks.columns_of(split.feature)[0]
    return column, ranks.n_values[column]


def with_given_thresholds(problem: Problem, tree: Node) -> Node:
    """Return a tree with the given thresholds, and those of the old tree, wherever they part its samples alike."""
    given: Mapping[str, float] = {
        part.path: part.threshold for part in problem.shape.fixed_splits or () if part.threshold is not None
    }

    def told(node: Node, old: Node | None, path: str, rows: NDArray[np.int64]) -> Node:
        if isinstance(node, Leaf):
            return node
        assert isinstance(node, Split)
        is_left = goes_left(node, problem.samples.features, rows)
        before = old if isinstance(old, Split) else None
        left = told(node.left, before and before.left, path + "L", rows[is_left])
        right = told(node.right, before and before.right, path + "R", rows[~is_left])
        found = replace(node, left=left, right=right)
        thresholds = [given[path]] if path in given else []
        if before is not None and before.feature == node.feature and not thresholds:
            is_alike = None in (before.missing, node.missing) or before.missing == node.missing
            thresholds = [before.threshold] if is_alike and before.threshold is not None else []
        for threshold in thresholds:
            moved = replace(found, threshold=threshold)
            if (goes_left(moved, problem.samples.features, rows) == is_left).all():
                return moved
        return found

    return told(tree, problem.shape.old_tree, "", np.arange(problem.samples.n_samples))


def with_old_sides(problem: Problem, tree: Node) -> Node:
    """Return a tree whose splits that stayed send missing readings where the old tree does, if none of its samples is.

    Nothing was learnt of the side there, and another one would be a change.
    """

    def told(node: Node, old: Node | None, rows: NDArray[np.int64]) -> Node:
        if not isinstance(node, Split) or not isinstance(old, Split):
            return node
        is_left = goes_left(node, problem.samples.features, rows)
        left, right = told(node.left, old.left, rows[is_left]), told(node.right, old.right, rows[~is_left])
        is_alike = (old.feature, old.threshold) == (node.feature, node.threshold)
        is_free = (
            is_alike and old.missing is not None and not np.isnan(problem.samples.features[rows, node.feature]).any()
        )
        return replace(node, left=left, right=right, missing=old.missing if is_free else node.missing)

    return told(tree, problem.shape.old_tree, np.arange(problem.samples.n_samples))

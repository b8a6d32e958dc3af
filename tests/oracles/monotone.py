"""The least cost of monotone trees of a small problem: every tree is listed, by the definition of order alone.

Imports nothing of octmip but the problem. Thresholds lie between two neighbouring values of all samples: where one lies
between them changes no prediction, and equal thresholds put fewest leaves beside each other.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from octmip.trees.question.problem import Problem

Box = tuple[tuple[int, int], ...]  # first and last rank of each feature
Leaves = list[tuple[Box, float]]


def least_monotone_cost(problem: Problem) -> float:
    """Return the least objective over all trees of a problem that keep its order."""
    values = [np.unique(column) for column in problem.samples.features.T]
    ranks = np.array([np.searchsorted(v, c) for v, c in zip(values, problem.samples.features.T, strict=True)])
    everything: Box = tuple((0, len(v) - 1) for v in values)
    most = 2**problem.shape.depth - 1 if problem.shape.max_splits is None else problem.shape.max_splits

    def trees(rows: NDArray[np.int64], box: Box, depth: int, splits: int) -> Iterator[tuple[float, Leaves, int]]:
        """Yield cost, leaves and splits of every tree of these samples in this box."""
        if len(rows) < problem.shape.leaf_size:
            return
        yield from ((float(cost), [(box, float(label))], 0) for label, cost in enumerate(problem.class_costs(rows)))
        if not depth or not splits:
            return
        for feature, (low, high) in enumerate(box):
            for cut in range(low, high):
                is_left = ranks[feature, rows] <= cut
                sides = [(*box[:feature], ends, *box[feature + 1 :]) for ends in ((low, cut), (cut + 1, high))]
                rights = list(trees(rows[~is_left], sides[1], depth - 1, splits - 1))
                for cost, leaves, used in trees(rows[is_left], sides[0], depth - 1, splits - 1):
                    for other_cost, others, other_used in rights:
                        total = used + other_used + 1
                        if total <= splits and in_order(leaves, others, problem.shape.directions):
                            yield cost + other_cost + problem.shape.leaf_penalty, leaves + others, total

    return min(
        cost for cost, _, _ in trees(np.arange(problem.samples.n_samples), everything, problem.shape.depth, most)
    )


def in_order(leaves: Leaves, others: Leaves, directions: tuple[int, ...]) -> bool:
    """Whether no leaf and no other that overlap in all features but one are out of order along that one."""
    for box, label in leaves:
        for other, other_label in others:
            apart = [f for f, (a, b) in enumerate(zip(box, other, strict=True)) if a[1] < b[0] or b[1] < a[0]]
            if len(apart) == 1:
                is_below = box[apart[0]][1] < other[apart[0]][0]
                rise = other_label - label if is_below else label - other_label
                if rise * directions[apart[0]] < 0:
                    return False
    return True

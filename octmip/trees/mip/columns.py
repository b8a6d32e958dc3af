"""A problem that lacks readings, to the mixed-integer methods: one of complete columns of ranks.

A feature that lacks readings is two columns, and a tree over the columns is a tree with a side for missing readings at
each split: `octmip.trees.encoding.ranks`, docs/theory/missing.md.
"""

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from octmip.trees.answer.solution import Solution
from octmip.trees.encoding import Ranks, rank_features, rows_from_tree, tree_from_rows
from octmip.trees.nodes.reached import without_empty_sides
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_values import refuse_missing


def over_columns(solver: Callable[..., Solution]) -> Callable[..., Solution]:
    """Return a solver of complete problems as one of problems that lack readings, too.

    It refuses hyperplanes where readings are missing.
    """

    @functools.wraps(solver)
    def solve(problem: Problem, *, incumbent: Node | None = None, **settings: Any) -> Solution:
        if not problem.samples.n_missing:
            solution = solver(problem, incumbent=incumbent, **settings)
            return solution if solution.tree is None else replace(solution, tree=problem.with_sides(solution.tree))
        if problem.shape.split != "axis":
            refuse_missing(problem.samples.n_missing, "hyperplanes add readings", "use split='axis', or fill them in")
        ranks = rank_features(problem)
        complete = column_problem(problem, ranks)
        of_complete = rank_features(complete)
        start = None if incumbent is None else without_empty_sides(incumbent, problem.samples.features)
        start = None if start is None else tree_from_rows(rows_from_tree(start, ranks), of_complete)
        solution = solver(complete, incumbent=start, **settings)
        if solution.tree is None:
            return solution
        rows = rows_from_tree(without_empty_sides(solution.tree, complete.samples.features), of_complete)
        return replace(solution, tree=problem.with_sides(tree_from_rows(rows, ranks)))

    return solve


def column_problem(problem: Problem, ranks: Ranks) -> Problem:
    """Return the problem of complete columns, their ranks as features; sensors and permissions are the features'."""
    shape = problem.shape
    feature_of = [ranks.feature(column) for column in range(ranks.n_columns)]
    ends = {"left": " (missing below)", "right": " (missing above)", None: ""}
    names = [problem.samples.feature_names[j] + ends[ranks.side(column)] for column, j in enumerate(feature_of)]
    groups = None
    if shape.allowed_splits is not None:
        groups = [[column] for column, j in enumerate(feature_of) if shape.is_allowed((j,))]
    sensors = shape.sensor_of_feature or ()
    return problem.replace(
        features=np.ascontiguousarray(ranks.ranks.T.astype(np.float64)),
        takes_missing=False,
        # A feature may be called like another one's column.
        feature_names=tuple(f"{column} {name}" for column, name in enumerate(names)),
        sensor_of_feature=[sensors[j] for j in feature_of],
        sensor_cost=dict(zip(shape.sensors, shape.sensor_costs.tolist(), strict=True)),
        allowed_splits=groups,
    )

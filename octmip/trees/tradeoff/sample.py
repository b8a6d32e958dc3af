"""The rows that a default tree is chosen and grown on where the seconds do not suffice for all of them.

The first family of trees is always finished (octmip.trees.tradeoff.family), so its work must fit the time: one tree of
CART for all rows and one for each fold. How long a tree takes is measured on few rows, as it depends on the machine,
on what else runs there, on the loss and on the columns. For n rows it is taken to rise as n log n, since CART sorts
every column at every level.

The rows are drawn at random, of each class its share. Their number is that of all rows, halved until the time
suffices, so that times which differ a little seldom make another tree.
"""

import math
import time

import numpy as np

from octmip.trees.answer.solution import Limits
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import MAX_DEPTH
from octmip.trees.runs.registry import Run
from octmip.trees.tradeoff.held_out import held_out_rows, strata_of
from octmip.trees.tradeoff.path import trace_run

FEWEST_ROWS = 5000
"""They are always used, where two trees of them fit the time; folds are given up before them."""
FEW_READINGS = 500_000
"""Of so many, and of `FEWEST_MEASURED` rows at the least, one tree is grown to measure; with `MANY_CLASSES` CART takes
twice as long."""
FEWEST_MEASURED, MANY_CLASSES = 500, 50


def sampled(problem: Problem, seconds: float, turns: int, seed: int) -> Problem | None:
    """Return the problem of as many rows as a first family can be finished for; None where it can for all.

    Parameters
    ----------
    problem
        all rows.
    seconds
        for the trees of that family, their prunings included [s].
    turns
        so many of these trees are grown one after the other.
    seed
        of the draw.
    """
    n = problem.samples.n_samples
    readings = problem.samples.n_features * (1 + problem.samples.n_classes // MANY_CLASSES)
    n_few = min(FEWEST_ROWS, max(FEWEST_MEASURED, FEW_READINGS // readings))
    if n <= n_few or math.isinf(seconds):
        return None
    few = _drawn(problem, n_few / n, seed)
    by_work = _seconds_of_path(few, seconds / turns) / _work(n_few)

    def fits(n_rows: float) -> bool:
        return by_work * _work(n_rows) * (turns if n_rows > FEWEST_ROWS else min(turns, 2)) <= seconds

    halvings = 0
    while n / 2**halvings > n_few and not fits(n / 2**halvings):
        halvings += 1
    if halvings == 0:
        return None
    return few if n / 2**halvings <= n_few else _drawn(problem, 1 / 2**halvings, seed)


def _seconds_of_path(problem: Problem, seconds: float) -> float:
    start = time.perf_counter()
    trace_run(problem.replace(depth=MAX_DEPTH), Run("cart", Limits(seconds=seconds)))
    return time.perf_counter() - start


def _work(n_rows: float) -> float:
    return n_rows * math.log2(n_rows)


def _drawn(problem: Problem, share: float, seed: int) -> Problem:
    rows = np.flatnonzero(held_out_rows(strata_of(problem.loss, problem.samples.targets), share, seed))
    return problem.of_rows(rows)

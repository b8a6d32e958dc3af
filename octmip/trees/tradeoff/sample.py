"""The rows that a default tree is chosen and grown on where the seconds do not suffice for all of them.

The first family of trees is always finished (octmip.trees.tradeoff.family), so its work must fit the time: one tree of
CART for all rows and one for each fold. A tree takes so many seconds for n rows of p features:

    n * (PER_ROW + growth * p * log2 n)      growth of the loss: CART sorts every feature at every level

The rows are drawn at random, of each class its share, so that one seed and one limit give the same rows anywhere.
"""

import math
from dataclasses import replace

import numpy as np

from octmip.trees.problem import Problem
from octmip.trees.tradeoff.held_out import held_out_rows, strata_of

PER_ROW = 8e-6
"""Seconds of pruning and judging; measured with growth on 20,000 to 200,000 rows of 4 to 16 features."""
GROWTH, GROWTH_BY_MEDIAN = 1e-7, 5e-7
"""Seconds by row, feature and doubling of rows: Gini and squared error 0.7e-7 on an idle core; absolute error."""
FEWEST_ROWS = 20_000
"""They are always used."""


def sampled(problem: Problem, seconds: float, seed: int) -> Problem | None:
    """Return the problem of as many rows as a first family can be finished for; None where it can for all.

    Parameters
    ----------
    problem
        all rows.
    seconds
        for one tree of that family, its prunings included [s].
    seed
        of the draw.
    """
    growth = GROWTH if problem.loss.predicts == "class" or problem.number_loss.slopes is None else GROWTH_BY_MEDIAN
    by_row = PER_ROW + growth * problem.n_features * math.log2(max(2, problem.n_samples))
    n_rows = max(FEWEST_ROWS, math.floor(min(seconds / by_row, problem.n_samples)))
    if n_rows >= problem.n_samples:
        return None
    rows = np.flatnonzero(held_out_rows(strata_of(problem.loss, problem.targets), n_rows / problem.n_samples, seed))
    return replace(
        problem, features=problem.features[rows], targets=problem.targets[rows], weights=problem.weights[rows]
    )

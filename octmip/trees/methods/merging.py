"""The same problem in fewer rows: equal samples merged, in an order that does not depend on how they came.

    rows      x = (1, 2), class a, weight 1      x = (0, 5), class b, weight 2      x = (1, 2), class a, weight 3
    merged    x = (0, 5), class b, weight 2      x = (1, 2), class a, weight 4

No split separates equal samples, so both problems have the same trees at the same cost; and a search that draws
samples at random draws the same ones whether a sample comes three times or once with three times the weight. A leaf
size of 2 and more counts samples: then they stay apart, and only their order is made one.
"""

from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks, rank_features
from octmip.trees.question.problem import Problem

MOST_INTEGER = 2**53
"""Integer coefficients up to this size are float64 values, all of them; larger ones need not be looked for."""
FAR = 1024.0
"""A row without weight whose values lie so many times further out than all others stays: trees must place it, too."""
MOST_KEY = 2**62


def merged(problem: Problem) -> tuple[Problem, Ranks]:
    """Return a problem whose trees are those of `problem` at the same cost, in as few rows as can be, and its ranks.

    Rows without weight are left out where leaves may be of any size. The order of the rows is that of their values,
    then of their targets.
    """
    if problem.shape.integer_normals is not None:
        problem = problem.replace(integer_normals=min(problem.shape.integer_normals, MOST_INTEGER))
    if problem.shape.leaf_size == 1:
        problem = _taken(problem, _weighted(problem), problem.samples.weights)
    ranks = rank_features(problem)
    is_class = problem.loss.predicts == "class"
    codes = problem.samples.codes if is_class else np.unique(problem.samples.codes, return_inverse=True)[1]
    group, first = _groups(ranks, codes)
    if problem.shape.leaf_size > 1 or len(first) == problem.samples.n_samples:
        rows, weights = np.argsort(group, kind="stable"), problem.samples.weights
    else:
        rows, weights = first, np.zeros(problem.samples.n_samples)
        weights[first] = np.bincount(group, problem.samples.weights)
    # Every distinct value is still there, so the ranks stay.
    return _taken(problem, rows, weights), replace(ranks, table=ranks.table.of_rows(rows))


def _weighted(problem: Problem) -> NDArray[np.intp]:
    """Return the rows that weigh anything; all rows where the others cannot be left out."""
    samples = problem.samples
    rows = np.flatnonzero(samples.weights)
    if len(rows) == samples.n_samples:
        return rows
    sizes = np.nan_to_num(np.abs(samples.features))  # a missing reading lies nowhere
    is_far = (sizes.max(axis=0) / FAR > sizes[rows].max(axis=0)).any()
    has_one_class = len(set(samples.codes[rows].tolist())) == 1
    return np.arange(samples.n_samples) if is_far or has_one_class else rows


def _taken(problem: Problem, rows: NDArray[np.intp], weights: NDArray[np.float64]) -> Problem:
    """Return the problem of these rows, in this order."""
    if np.array_equal(rows, np.arange(problem.samples.n_samples)):
        return problem
    return problem.of_rows(rows, weights=weights[rows])


def _groups(ranks: Ranks, codes: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the group of equal samples that each row belongs to, in the order of the values, and a row of each."""
    key, size = np.zeros(len(codes), dtype=np.int64), 1
    columns = ((ranks.column(k).astype(np.int64), ranks.n_values[k]) for k in range(ranks.n_columns))
    for column, n_values in chain(columns, [(codes, int(codes.max()) + 1)]):
        if size * n_values > MOST_KEY:
            distinct, key = np.unique(key, return_inverse=True)
            size = len(distinct)
            if size == len(codes):
                break
        key, size = key * n_values + column, size * n_values
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    return group, first

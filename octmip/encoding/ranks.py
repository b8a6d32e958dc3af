"""Features as dense ranks, and a problem as the native core holds it.

Ranks, not values, enter the core. Feature values of float64 become dense ranks 0, 1, ...; a cut "rank <= k" comes back
as the guarded midpoint of the k-th and (k+1)-th distinct value, so no float64 value is ever compared after rounding:

    values       0.5  0.5  1.5  4.0  4.0
    ranks          0    0    1    2    2
    cut 1 means   rank <= 1, threshold midpoint(1.5, 4.0) = 2.75
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip import _native
from octmip.encoding.costs import IntegerCosts
from octmip.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Ranks:
    """Dense ranks of each feature, and the distinct values behind them.

    Attributes
    ----------
    ranks
        (n_features, n_samples) uint32, C-contiguous.
    values
        for each feature its distinct values, ascending: ``features[i, j] == values[j][ranks[j, i]]``.
    """

    ranks: NDArray[np.uint32]
    values: tuple[NDArray[np.float64], ...]


def rank_features(problem: Problem) -> Ranks:
    """Return the dense ranks of every feature of a problem."""
    ranks, values = _native.dense_ranks(problem.features)
    return Ranks(ranks, tuple(values))


def native_problem(problem: Problem, ranks: Ranks, costs: IntegerCosts) -> _native.Problem:
    """Return the problem as the native core holds it."""
    allowed = [problem.is_allowed((feature,)) for feature in range(problem.n_features)]
    return _native.Problem(
        ranks.ranks,
        [len(values) for values in ranks.values],
        costs.rows.astype(np.uint32),
        costs.weights,
        costs.costs,
        costs.penalty,
        problem.depth,
        problem.leaf_size,
        problem.sensor_index.tolist(),
        problem.sensor_costs.tolist(),
        problem.sensor_limit,
        allowed,
        _planes(problem),
    )


def _planes(
    problem: Problem,
) -> tuple[NDArray[np.float64], int, list[list[int]] | None, int | None] | None:
    """Return data of hyperplane splits beside the ranks: values (n_samples, n_features) and the limits of a split."""
    if problem.max_split_size == 1:
        return None
    groups = problem.allowed_splits
    members = None if groups is None else [[int(feature) for feature in group] for group in groups]
    return np.ascontiguousarray(problem.features), problem.max_split_size, members, problem.integer_normals

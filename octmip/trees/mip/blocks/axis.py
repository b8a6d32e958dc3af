"""Axis-aligned splits as cuts of dense ranks: cut k of feature j sends the ranks 0 .. k left, as in `encoding`."""

import numpy as np

from octmip.errors import ProblemError
from octmip.trees.encoding import Ranks
from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import HyperplaneSplit, Split
from octmip.trees.question.problem import Problem


def require_axis(problem: Problem, method: str) -> None:
    """Refuse a problem whose trees are not all axis-aligned.

    Raises
    ------
    ProblemError
        the problem asks for hyperplanes.
    """
    if problem.shape.split != "axis":
        raise ProblemError(
            f"method {method!r} finds axis-aligned trees but split is {problem.shape.split!r}; choose 'oct_h' or 'flow'"
        )


def n_cuts(ranks: Ranks) -> list[int]:
    """Return the number of cuts of each feature: its number of values less one."""
    return [n_values - 1 for n_values in ranks.n_values]


def usable_features(problem: Problem, ranks: Ranks) -> list[int]:
    """Return the features that may be split on: allowed, affordable and not constant."""
    shape = problem.shape
    affordable = shape.sensor_costs[shape.sensor_index] <= shape.sensor_limit
    cuts = n_cuts(ranks)
    return [j for j in range(problem.samples.n_features) if cuts[j] > 0 and affordable[j] and shape.is_allowed((j,))]


def cut_of(split: Split | HyperplaneSplit, ranks: Ranks) -> int:
    """Return the cut of an axis-aligned split: the rank of the largest value on its left."""
    assert isinstance(split, Split)
    assert split.threshold is not None  # columns of ranks are complete
    return int(np.searchsorted(ranks.values[split.feature], split.threshold, side="right")) - 1


def threshold_at(feature: int, cut: int, ranks: Ranks) -> float:
    """Return the threshold of a cut of `cut_of`, which leaves samples on both sides."""
    values = ranks.values[feature]
    return midpoint(float(values[cut]), float(values[cut + 1]))

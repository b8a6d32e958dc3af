"""What other splits cost: the best tree with a split of a sensor at a node, proven."""

import math
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import NoTreeError, ProblemError
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.nodes.tree import Node, Split, goes_left
from octmip.trees.question.parts import address
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve

Above = tuple[tuple[str, tuple[int, float]], ...]
"""Addresses of splits with feature and threshold."""
MOST_SPLITS, MOST_SENSORS = 7, 6
"""Of a tree's splits, the root first, and of other sensors at each, those that lose least in a tree of one split."""

MOST_CELLS = 1_000_000
"""So many readings of a node are looked at to choose these; of more every second row, or every third, ..."""


@dataclass(frozen=True, slots=True)
class EditPrice:
    """The best tree with a split of a sensor at a node.

    Attributes
    ----------
    sensor
        its name.
    objective, bound
        of that tree; the objective +inf where none was found, both where there is none.
    stop
        why the search ended.
    """

    sensor: str
    objective: float
    bound: float
    stop: Stop

    @property
    def is_possible(self) -> bool:
        """Whether there may be such a tree."""
        return math.isfinite(self.bound) or self.stop is not Stop.OPTIMAL


def with_splits(problem: Problem, given: Mapping[str, object]) -> Problem:
    """Return the problem with given splits, by address, beside or in place of its own.

    Raises
    ------
    ProblemError
        one is no split, or the problem is one that no search knows with given splits.
    """
    names, given_before = problem.samples.feature_names, problem.shape.fixed_splits or ()
    own = {address(part.path): part.split_words(names) for part in given_before}
    return problem.replace(fixed_splits=own | dict(given))


def edit_prices(problem: Problem, path: str, sensors: Iterable[str], end: float) -> Iterator[EditPrice]:
    """Yield what the best tree with each of these sensors at the node of a path costs.

    Each search gets an equal share of the time that is left until `end` of `time.perf_counter`, none once it is over.
    """
    left = list(sensors)
    while left:
        seconds = (end - time.perf_counter()) / len(left)
        sensor = left.pop(0)
        if seconds <= 0:
            yield EditPrice(sensor, math.inf, 0.0, Stop.TIME)
            continue
        try:
            asked = with_splits(problem, {address(path): sensor})
            found = solve(asked, "exact", Limits(seconds=seconds))
            yield EditPrice(sensor, found.objective, found.bound, found.stop)
        except NoTreeError:
            yield EditPrice(sensor, math.inf, math.inf, Stop.OPTIMAL)


def tree_edits(problem: Problem, tree: Node, seconds: float) -> dict[str, tuple[EditPrice, ...]]:
    """Return by path what other sensors at the first splits of a tree cost, with the splits above as they are.

    Empty where no search knows given splits: of numbers, of hyperplanes, under an order or a budget.
    """
    end, found = time.perf_counter() + seconds, {}
    first = sorted(_splits(problem, tree, np.arange(problem.samples.n_samples)), key=lambda one: (len(one[0]), one[0]))
    for k, (path, split, rows, above) in enumerate(first[:MOST_SPLITS]):
        now = time.perf_counter()
        try:
            asked, sensors = with_splits(problem, dict(above)), _next_sensors(problem, split, rows)
            found[path] = tuple(
                edit_prices(asked, path, sensors, now + (end - now) / (min(MOST_SPLITS, len(first)) - k))
            )
        except ProblemError:
            return {}
    return found


def _splits(
    problem: Problem, node: Node, rows: NDArray[np.int64], path: str = "", above: Above = ()
) -> Iterator[tuple[str, Split, NDArray[np.int64], Above]]:
    """Yield path, split, rows and the splits above; a split for missing readings alone cannot be given."""
    if isinstance(node, Split) and len(rows):
        yield path, node, rows, above
        if node.threshold is not None:
            is_left = goes_left(node, problem.samples.features, rows)
            above = (*above, (address(path), (node.feature, node.threshold)))
            yield from _splits(problem, node.left, rows[is_left], path + "L", above)
            yield from _splits(problem, node.right, rows[~is_left], path + "R", above)


def _next_sensors(problem: Problem, split: Split, rows: NDArray[np.int64]) -> list[str]:
    """Return the sensors that lose least in a tree of one split over some rows, but that of the split."""
    shape = problem.shape
    least: dict[str, float] = {}
    rows = rows[:: max(1, len(rows) * problem.samples.n_features // MOST_CELLS)]
    for j in range(problem.samples.n_features):
        sensor = shape.sensors[shape.sensor_index[j]]
        least[sensor] = min(least.get(sensor, math.inf), _least_of_one_split(problem, j, rows))
    least.pop(shape.sensors[shape.sensor_index[split.feature]])
    return sorted(least, key=least.__getitem__)[:MOST_SENSORS]


def _least_of_one_split(problem: Problem, feature: int, rows: NDArray[np.int64]) -> float:
    values = problem.samples.features[rows, feature]
    order = np.argsort(values, kind="stable")
    costs = (problem.samples.weights[rows, None] * problem.cost_table[problem.cost_rows[rows]])[order].cumsum(axis=0)
    ends = np.flatnonzero(np.diff(values[order]) > 0)
    return float((costs[ends].min(axis=1) + (costs[-1] - costs[ends]).min(axis=1)).min(initial=math.inf))

"""What a formula asks: ranks, whole prices of errors, a penalty, and which columns a split may read."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.encoding import IntegerCosts, Ranks, integer_costs, rank_features
from octmip.errors import ProblemError
from octmip.problem import Problem

MOST_DEPTH = 2
CURE = "write octmip's own log (a name that does not end in .pbp)"


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A problem as a formula states it: all numbers are whole.

    Attributes
    ----------
    ranks
        (n_columns, n_samples) int64, dense ranks of the columns that a split may read, each of two ranks at least.
    columns
        which of the columns of `octmip.encoding.rank_features` these are.
    n_ranks
        (n_columns,) int64, number of ranks of each.
    prices
        (n_samples,) int64, what an error on each sample costs; of samples that cost nothing there is none here.
    labels
        (n_samples,) int64, class of each sample.
    n_classes
        number of labels that a leaf can have.
    depth
        levels of splits, 1 or 2.
    penalty
        price of a split.
    leaf_size
        at least so many samples, those that cost nothing included, in every leaf.
    counted
        (n_samples,) int64, which of all samples these are.
    all_ranks
        (n_columns, n_all_samples) int64, the same ranks with the samples that cost nothing.
    sensors
        (n_columns,) int64, sensor of each column.
    sensor_prices
        cost of each sensor, whole.
    sensor_limit
        at most so much in a tree; None where all of them are within it.
    """

    ranks: NDArray[np.int64]
    columns: tuple[int, ...]
    n_ranks: NDArray[np.int64]
    prices: NDArray[np.int64]
    labels: NDArray[np.int64]
    n_classes: int
    depth: int
    penalty: int
    leaf_size: int
    counted: NDArray[np.int64]
    all_ranks: NDArray[np.int64]
    sensors: NDArray[np.int64]
    sensor_prices: tuple[int, ...]
    sensor_limit: int | None

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return len(self.prices)

    @property
    def n_columns(self) -> int:
        """Number of columns."""
        return len(self.columns)

    def is_affordable(self, columns: Iterable[int]) -> bool:
        """Whether a tree may read these columns."""
        read = {int(self.sensors[j]) for j in columns}
        return self.sensor_limit is None or sum(self.sensor_prices[t] for t in read) <= self.sensor_limit

    @property
    def nodes(self) -> tuple[int, ...]:
        """The splits of a tree: 0 is the root, 1 and 2 its sides."""
        return (0,) if self.depth == 1 else (0, 1, 2)

    @property
    def stumps(self) -> tuple[int, ...]:
        """The splits whose sides are leaves."""
        return (0,) if self.depth == 1 else (1, 2)


def question_of(problem: Problem) -> tuple[Question, IntegerCosts, Ranks]:
    """Return what a formula asks of a problem, its costs as whole numbers, and its ranks.

    Raises
    ------
    ProblemError
        there is no formula for such trees or costs; one sentence says why.
    """
    _refuse(problem)
    costs = integer_costs(problem)
    prices = _prices(problem, costs)
    ranks = rank_features(problem)
    n_ranks = np.array(ranks.n_values, dtype=np.int64)
    columns = tuple(j for j in range(ranks.n_columns) if n_ranks[j] > 1 and _may_be_read(problem, ranks.feature(j)))
    sensors = np.array([problem.sensor_index[ranks.feature(j)] for j in columns], dtype=np.int64)
    counted = np.flatnonzero(prices)
    if not len(counted):
        raise ProblemError(f"no error costs anything, so there is nothing to prove; {CURE}")
    kept = list(columns)
    question = Question(
        ranks.ranks.astype(np.int64)[kept][:, counted],
        columns,
        n_ranks[kept],
        prices[counted],
        problem.codes[counted],
        problem.n_classes,
        problem.depth,
        costs.penalty,
        problem.leaf_size,
        counted,
        ranks.ranks.astype(np.int64)[kept],
        sensors,
        *_budget(problem, set(sensors.tolist())),
    )
    return question, costs, ranks


def _refuse(problem: Problem) -> None:
    if problem.split != "axis" or problem.depth > MOST_DEPTH:
        raise ProblemError(
            f"depth {problem.depth} with split {problem.split!r} has no pseudo-Boolean proof; expected axis-aligned "
            f"trees of depth {MOST_DEPTH} at most; {CURE}"
        )


def _may_be_read(problem: Problem, feature: int) -> bool:
    """Whether a split may read a feature, and the budget pays for its sensor."""
    return problem.is_allowed((feature,)) and bool(
        problem.sensor_costs[problem.sensor_index[feature]] <= problem.sensor_limit
    )


def _budget(problem: Problem, used: set[int]) -> tuple[tuple[int, ...], int | None]:
    """Return the costs of the sensors and the limit as whole numbers of one unit, no limit where there is none."""
    if math.isinf(problem.sensor_limit):
        return (0,) * len(problem.sensors), None
    prices = [Fraction(price) for price in problem.sensor_costs.tolist()]
    unit = math.lcm(*(price.denominator for price in prices))
    whole = tuple(int(price * unit) for price in prices)
    limit = math.floor(Fraction(problem.sensor_limit) * unit)
    return whole, limit if sum(whole[t] for t in used) > limit else None


def _prices(problem: Problem, costs: IntegerCosts) -> NDArray[np.int64]:
    """Return what an error costs on each sample, (n_samples,), if all errors on it cost the same and no answer else."""
    if costs.is_rounded:
        raise ProblemError(
            "weights, costs or leaf_penalty are not whole numbers of one power of two within 2^52, and a "
            f"pseudo-Boolean proof does not round; {CURE}"
        )
    table = costs.costs[:, : problem.n_classes]
    for row, own in enumerate(table):
        wrong = np.delete(own, row)
        if own[row] or (wrong != wrong[0]).any():
            raise ProblemError(
                f"costs of class {problem.class_names[row]} are {problem.costs[row].tolist()}; a pseudo-Boolean proof "
                f"needs 0 for the right label and one price for all the others; {CURE}"
            )
    return np.asarray(costs.weights * table.max(axis=1)[costs.rows], dtype=np.int64)

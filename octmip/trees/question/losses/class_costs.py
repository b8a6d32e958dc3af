"""ClassCosts: what each decision costs, by the class of a sample (0/1 unless given) or sample by sample.

``cost(k, l) = costs[k, l]``, k the class or the sample; the best leaf predicts the class of least cost, the first of
equals.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.trees.question.classes import in_class_order
from octmip.trees.question.losses.exact_sums import whole_numbers
from octmip.trees.question.losses.loss import Floats, Loss
from octmip.trees.question.problem_values import numbers_of

SAMPLE_COSTS = "sample costs"
"""Name of costs of single samples in files."""
MOST_SETS = 20_000
"""Sets of labels that are gone through one by one."""
LEAST_COST, MOST_COST = 1e-280, 1e303  # of the worst tree


@dataclass(frozen=True, slots=True, eq=False)
class ClassCosts(Loss):
    """What it costs to predict one class for a sample of another, or for one sample.

    Attributes
    ----------
    costs
        (n_classes, n_classes) cost, 0 or more, of predicting column k for a sample of class row i, in the order of
        `Samples.class_names`, or a frame that names them; None: 0 for the own class and 1 for any other. In a Problem
        it is always the matrix.
    per_sample
        whether the rows are the samples instead, (n_samples, n_classes): the classes are decisions, and the targets
        only say which of them counts as right.

    Examples
    --------
    >>> to_miss_a_leak = ClassCosts([[0, 1], [20, 0]])  # rows are the true class: "dry", "leak"
    >>> solve(Problem([[0], [1], [1]], ["dry", "dry", "leak"], depth=1, loss=to_miss_a_leak)).objective
    1.0
    """

    costs: ArrayLike | None = None
    per_sample: bool = False
    _is_whole: bool | None = field(default=None, kw_only=True, repr=False)  # of a Problem's table, gone through once

    name = "classes"
    predicts = "class"
    measured = ("errors",)

    def __repr__(self) -> str:
        if self.per_sample:
            return f"ClassCosts(<{len(self.table)} samples>, per_sample=True)"
        return "ClassCosts()" if self.costs is None else f"ClassCosts({np.asarray(self.costs).tolist()})"

    @property
    def table(self) -> Floats:
        """The costs of a Problem's loss as they were settled by `over`, a row for each class or sample."""
        table: Floats = np.asarray(self.costs)
        return table

    @property
    def matrix(self) -> Floats:
        """The costs (n_classes, n_classes) of a Problem's loss.

        Raises
        ------
        ProblemError
            they are those of single samples.
        """
        if self.per_sample:
            raise ProblemError(
                "the costs are those of single samples; this question needs costs of classes; solve, certify and "
                "model answer costs of samples"
            )
        return self.table

    @property
    def by_row(self) -> "ClassCosts":
        """The loss with the rows of its table for classes: of a sample its own row."""
        return ClassCosts(self.table)

    def over(self, class_names: tuple[Any, ...], n_samples: int) -> "ClassCosts":
        """Return the loss with its matrix, for so many samples of classes of these names; a Problem's own.

        Raises
        ------
        ProblemError
            the matrix has another size, or holds what is no cost.
        """
        k = len(class_names)
        expected = (n_samples if self.per_sample else k, k)
        if self._is_whole is not None and self.table.shape == expected:
            return self
        if self.per_sample and self.costs is None:
            raise ProblemError("per_sample is True but costs are left out; give a row of costs for each sample")
        costs = in_class_order(self.costs, class_names, "costs", first=int(self.per_sample))
        matrix = 1.0 - np.eye(k) if costs is None else numbers_of(costs, "costs", 2)
        if matrix.shape != expected:
            rows = "a row for each sample and columns" if self.per_sample else "rows and columns"
            raise ProblemError(f"costs has shape {matrix.shape}; expected {expected}, {rows} {class_names}")
        if (matrix < 0).any():
            i, j = (int(index) for index in np.argwhere(matrix < 0)[0])
            raise ProblemError(f"costs[{i}, {j}] is {matrix[i, j]}; expected 0 or more")
        matrix.flags.writeable = False
        return ClassCosts(matrix, self.per_sample, _is_whole=bool((matrix == np.floor(matrix)).all()))

    @property
    def is_zero_one(self) -> bool:
        """Whether every wrong class costs 1."""
        return not self.per_sample and bool((self.matrix == 1 - np.eye(len(self.matrix))).all())

    @property
    def words(self) -> str:
        """What is summed up."""
        return "errors" if self.is_zero_one else "cost"

    def check_range(self, weights: Floats, codes: NDArray[Any], most_prices: float) -> None:
        """Raise unless costs neither overflow nor vanish."""
        with np.errstate(over="ignore"):
            most = float(weights.sum() * self.table.max())
        if self.table.any() and not LEAST_COST <= most <= MOST_COST:
            raise ProblemError(
                f"weights and costs make trees that cost up to {most}; expected from {LEAST_COST:g} to {MOST_COST:g}, "
                "beyond which sums of float64 are no longer what they say; scale weights or costs"
            )
        if not math.isfinite(most + most_prices):
            raise ProblemError(
                f"weights up to {weights.max()}, costs up to {self.table.max()} and leaf_penalty, up to {most_prices} "
                "in all, add up to more than float64 holds (1.8e308); divide them all by one number"
            )

    def class_costs(self, weights: Floats, codes: NDArray[np.int64]) -> Floats:
        """Return the cost of predicting each class for all of some samples, shape (n_classes,)."""
        costs: Floats = np.bincount(codes, weights, len(self.matrix)) @ self.matrix
        return costs

    def least_of_labels(self, weights: Floats, codes: NDArray[Any], most: int) -> list[float]:
        """Return what samples cost at least where no more than 1, 2, ... `most` classes are predicted for them.

        Where a mistake costs more for one label than for another, and sets of labels are many, it is 0.
        """
        k = len(self.matrix)
        costs = np.bincount(codes, weights, k)[:, None] * self.matrix
        most, own = min(most, k), np.eye(k, dtype=bool)
        beside = np.where(own, -np.inf, costs).max(axis=1)
        if np.array_equal(costs, np.where(own, 0.0, beside[:, None])):
            by_worth = np.sort(beside)
            return [float(by_worth[: k - n].sum()) for n in range(1, most + 1)]
        if sum(math.comb(k, n) for n in range(1, most + 1)) > MOST_SETS:
            return [0.0] * most
        sets = [itertools.combinations(range(k), n) for n in range(1, most + 1)]
        return [min(float(costs[:, labels].min(axis=1).sum()) for labels in of_size) for of_size in sets]

    def least_saving(self, weights: Floats, rows: NDArray[np.int64]) -> float:
        """Return the least cost that the best label of one sample saves; +inf if none saves any.

        `rows` (n_samples,) says by which row of `table` each sample pays.
        """
        excess = self.table - self.table.min(axis=1, keepdims=True)
        by_row = np.where(excess > 0, excess, np.inf).min(axis=1)
        lightest = np.full(len(self.table), np.inf)
        positive = weights > 0
        np.minimum.at(lightest, rows[positive], weights[positive])
        pairs = zip(lightest.tolist(), by_row.tolist(), strict=True)
        # A product below the least float64 is something all the same.
        return min((max(w * c, math.ulp(0.0)) for w, c in pairs if math.isfinite(w)), default=math.inf)

    def best_value(self, weights: Floats, codes: NDArray[Any]) -> float:
        """Return the index of the class of least cost."""
        return int(self.class_costs(weights, codes).argmin())

    def row_costs(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Floats:
        """Return weight times cost of each prediction."""
        costs: Floats = weights * self.matrix[codes, predicted]
        return costs

    def contrasts(self, weights: Floats, codes: NDArray[Any]) -> Floats:
        """Return the most by which two predicted classes differ in cost on one row of any class of mean weight."""
        k = len(self.matrix)
        mean = np.bincount(codes, weights, k) / np.maximum(np.bincount(codes, minlength=k), 1)
        most: Floats = np.zeros((k, k))
        for paid in mean[:, None] * self.matrix:
            rare = np.flatnonzero(
                paid != np.partition(paid, k // 2)[k // 2]
            )  # two classes that cost the same do not differ
            most[rare] = np.maximum(most[rare], np.abs(paid[rare, None] - paid))
        return np.maximum(most, most.T)

    def exact_cost(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Fraction:
        """Return the cost as a rational number."""
        whole, unit = whole_numbers(weights)
        prices, grain = whole_numbers(self.matrix[codes, predicted])
        return sum(w * c for w, c in zip(whole, prices, strict=True)) * Fraction(2) ** -(unit + grain)

    def cost(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any], prices: Fraction) -> float:
        """Return the cost and the prices of splits: each is rounded once, their sum again."""
        paid = self.row_costs(weights, codes, predicted)
        # Sums of whole numbers below 2^52 are exact in any order; fsum rounds others once, but takes ten times as long.
        total = float(paid.sum()) if self.has_whole_costs(weights) else math.fsum(paid)
        return total + float(prices)

    def has_whole_costs(self, weights: Floats) -> bool:
        """Whether weights and costs are whole numbers, small enough together."""
        is_whole = (self.table == np.floor(self.table)).all() if self._is_whole is None else self._is_whole
        return bool(
            is_whole and (weights == np.floor(weights)).all() and weights.sum() * max(self.table.max(), 1.0) < 2.0**52
        )

    def measures(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Mapping[str, float]:
        """Return how many samples are wrong, unweighted."""
        return {"errors": int((predicted != codes).sum())}

    def words_of(self, measures: Mapping[str, float], n_samples: int) -> str:
        """Return how many samples are wrong, and their share."""
        errors = int(measures["errors"])
        return f"{errors} of {n_samples} samples wrong ({100 * errors / n_samples:.3g} %)"

    def to_json(self) -> dict[str, Any]:
        """Return the name, another one for costs of single samples, and the costs."""
        return {"name": SAMPLE_COSTS if self.per_sample else self.name, "costs": self.table.tolist()}

"""ClassCosts: a cost matrix of classes, 0/1 unless another is given.

``cost(k, l) = costs[k, l]``; the best leaf predicts the class of least cost, the first of equals
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.trees.losses.exact_sums import whole_numbers
from octmip.trees.losses.loss import Floats, Loss
from octmip.trees.problem_values import numbers_of

LEAST_COST, MOST_COST = 1e-280, 1e303  # of the worst tree


@dataclass(frozen=True, slots=True, eq=False)
class ClassCosts(Loss):
    """What it costs to predict one class for a sample of another.

    Attributes
    ----------
    costs
        (n_classes, n_classes) cost, 0 or more, of predicting column k for a sample of class row i, in the order of
        `Problem.class_names`; None: 0 for the own class and 1 for any other. In a Problem it is always the matrix.
    """

    costs: ArrayLike | None = None

    name = "classes"
    predicts = "class"
    measured = ("errors",)

    def __repr__(self) -> str:
        return "ClassCosts()" if self.costs is None else f"ClassCosts({np.asarray(self.costs).tolist()})"

    @property
    def matrix(self) -> Floats:
        """The costs (n_classes, n_classes) of a Problem's loss, as they were settled by `over`."""
        matrix: Floats = np.asarray(self.costs)
        return matrix

    def over(self, class_names: tuple[Any, ...]) -> "ClassCosts":
        """Return the loss with its matrix, for classes of these names; a Problem's own.

        Raises
        ------
        ProblemError
            the matrix has another size, or holds what is no cost.
        """
        k = len(class_names)
        matrix = 1.0 - np.eye(k) if self.costs is None else numbers_of(self.costs, "costs", 2)
        if matrix.shape != (k, k):
            raise ProblemError(f"costs has shape {matrix.shape}; expected ({k}, {k}), rows and columns {class_names}")
        if (matrix < 0).any():
            i, j = (int(index) for index in np.argwhere(matrix < 0)[0])
            raise ProblemError(f"costs[{i}, {j}] is {matrix[i, j]}; expected 0 or more")
        matrix.flags.writeable = False
        return ClassCosts(matrix)

    @property
    def is_zero_one(self) -> bool:
        """Whether every wrong class costs 1."""
        return bool((self.matrix == 1 - np.eye(len(self.matrix))).all())

    @property
    def words(self) -> str:
        """What is summed up."""
        return "errors" if self.is_zero_one else "cost"

    def check_range(self, weights: Floats, codes: NDArray[Any], most_prices: float) -> None:
        """Raise unless costs neither overflow nor vanish."""
        with np.errstate(over="ignore"):
            most = float(weights.sum() * self.matrix.max())
        if self.matrix.any() and not LEAST_COST <= most <= MOST_COST:
            raise ProblemError(
                f"weights and costs make trees that cost up to {most}; expected from {LEAST_COST:g} to {MOST_COST:g}, "
                "beyond which sums of float64 are no longer what they say; scale weights or costs"
            )
        if not math.isfinite(most + most_prices):
            raise ProblemError(
                f"weights up to {weights.max()}, costs up to {self.matrix.max()} and leaf_penalty, up to {most_prices} "
                "in all, add up to more than float64 holds (1.8e308); divide them all by one number"
            )

    def class_costs(self, weights: Floats, codes: NDArray[np.int64]) -> Floats:
        """Return the cost of predicting each class for all of some samples, shape (n_classes,)."""
        costs: Floats = np.bincount(codes, weights, len(self.matrix)) @ self.matrix
        return costs

    def best_value(self, weights: Floats, codes: NDArray[Any]) -> float:
        """Return the index of the class of least cost."""
        return int(self.class_costs(weights, codes).argmin())

    def row_costs(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Floats:
        """Return weight times cost of each prediction."""
        costs: Floats = weights * self.matrix[codes, predicted]
        return costs

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
        whole = all((array == np.floor(array)).all() for array in (weights, self.matrix))
        return bool(whole and weights.sum() * max(self.matrix.max(), 1.0) < 2.0**52)

    def measures(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Mapping[str, float]:
        """Return how many samples are wrong, unweighted."""
        return {"errors": int((predicted != codes).sum())}

    def words_of(self, measures: Mapping[str, float], n_samples: int) -> str:
        """Return how many samples are wrong, and their share."""
        errors = int(measures["errors"])
        return f"{errors} of {n_samples} samples wrong ({100 * errors / n_samples:.3g} %)"

    def to_json(self) -> dict[str, Any]:
        """Return the name and the matrix."""
        return {"name": self.name, "costs": self.matrix.tolist()}

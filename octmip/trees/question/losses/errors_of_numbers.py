"""Squared and absolute error of a predicted number.

``cost(y, f) = |y - f|^q``, q = 2 or 1; the best leaf predicts the weighted mean, or the lowest weighted median. Any
error that grows with the distance, by one slope above the prediction and one below it, is a `SlopedError`.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.question.losses.exact_sums import (
    Slopes,
    sloped_errors,
    squared_errors,
    weighted_mean,
    weighted_quantile,
)
from octmip.trees.question.losses.loss import Floats, Loss

LEAST_SIZE, MOST_SIZE = 1e-120, 1e120
"""Targets differ by this much, weights add up to this much: squares of float64 are numbers then."""


class NumberLoss(Loss):
    """An error of predicted numbers: what all such losses share."""

    predicts = "number"
    measured: ClassVar[tuple[str, ...]] = ("mae", "rmse")
    spellings: ClassVar[tuple[str, ...]]
    """How users name it, with a number for each parameter: for sentences, and for checks that go over every loss."""
    parameters: ClassVar[Mapping[str, tuple[float, float]]] = {}
    """Its fields in the order of a spelling, and the least and the most of each."""

    @classmethod
    def of_spelling(cls, values: str) -> Self:
        """Return the loss with what stands behind the colon of its spelling."""
        if values:
            raise ProblemError(f"loss {cls.name!r} takes nothing behind its name, but {values!r} stands there")
        return cls()

    @property
    def slopes(self) -> Slopes | None:
        """What a unit of distance costs; None of the squared error alone, which solvers and checkers take it for."""
        return None

    @abstractmethod
    def of_misses(self, misses: Floats) -> Floats:
        """Return the error of each difference ``target - predicted``."""

    def check_range(self, weights: Floats, codes: NDArray[Any], most_prices: float) -> None:
        """Raise unless some solver minimises the loss, and its errors neither overflow nor vanish."""
        if self.slopes is None and not isinstance(self, SquaredError):
            raise ProblemError(
                f"loss {self.name!r} is neither the squared error nor a SlopedError; no core has a kernel for it and "
                "would minimise the squared error"
            )
        span = float(codes.max() / 2 - codes.min() / 2)
        total = float(np.clip(weights, 0, 1e300).sum())
        size = max(float(np.abs(codes).max()), most_prices)
        if not LEAST_SIZE <= total <= MOST_SIZE or size > MOST_SIZE or 0 < span < LEAST_SIZE:
            raise ProblemError(
                f"targets from {codes.min()} to {codes.max()}, weights of {total} in all, splits of {most_prices} at "
                f"most: expected sizes from {LEAST_SIZE:g} to {MOST_SIZE:g}; scale them"
            )

    def row_costs(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Floats:
        """Return weight times error of each prediction."""
        return weights * self.of_misses(codes - predicted)

    def has_whole_costs(self, weights: Floats) -> bool:
        """Return False: what a leaf predicts need not be a whole number."""
        return False

    def measures(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Mapping[str, float]:
        """Return the weighted mean absolute error and the root of the weighted mean squared error."""
        misses = np.abs(predicted - codes)
        largest = float(misses.max(initial=0.0)) or 1.0  # squares of its shares do not overflow
        rms = largest * math.sqrt(float(np.average((misses / largest) ** 2, weights=weights)))
        return {"mae": float(np.average(misses, weights=weights)), "rmse": rms}

    def words_of(self, measures: Mapping[str, float], n_samples: int) -> str:
        """Return the mean absolute error and the root of the mean squared error."""
        off = self.short_words_of(measures, n_samples)
        return f"{n_samples} samples, {off}, root of the mean squared error {measures['rmse']:.6g}"

    def short_words_of(self, measures: Mapping[str, float], n_samples: int) -> str:
        """Return the mean absolute error."""
        return f"mean absolute error {measures['mae']:.6g}"


@dataclass(frozen=True, slots=True)
class SquaredError(NumberLoss):
    """The squared difference of target and prediction; a leaf predicts the weighted mean.

    >>> Problem([[0.0], [1.0], [2.0]], [5.0, 5.0, 8.0], depth=1, loss=SquaredError())
    Problem(3 samples, 1 feature, loss=SquaredError(), depth=1, split='axis')
    """

    name = "squared"
    spellings = ("squared",)

    @property
    def words(self) -> str:
        """What is summed up."""
        return "squared error"

    def of_misses(self, misses: Floats) -> Floats:
        """Return the squares."""
        return misses**2

    def best_value(self, weights: Floats, codes: NDArray[Any]) -> float:
        """Return the weighted mean, rounded once."""
        return weighted_mean(weights, codes)

    def exact_cost(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Fraction:
        """Return the weighted error as a rational number."""
        return squared_errors(weights, codes, predicted)


class SlopedError(NumberLoss):
    """An error in proportion to the distance, by one slope above the prediction and one below it."""

    @property
    @abstractmethod
    def slopes(self) -> Slopes:
        """What a unit of distance costs."""

    def of_misses(self, misses: Floats) -> Floats:
        """Return the distances, each times its slope."""
        up, down, over = self.slopes
        errors: Floats = np.maximum(up * misses, -down * misses) / over
        return errors

    def best_value(self, weights: Floats, codes: NDArray[Any]) -> float:
        """Return the lowest weighted quantile: no number is rounded."""
        return weighted_quantile(weights, codes, self.slopes)

    def exact_cost(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Fraction:
        """Return the weighted error as a rational number."""
        return sloped_errors(weights, codes, predicted, self.slopes)


@dataclass(frozen=True, slots=True)
class AbsoluteError(SlopedError):
    """The absolute difference of target and prediction; a leaf predicts the lowest weighted median.

    >>> solve(Problem([[0.0], [1.0], [2.0]], [5.0, 6.0, 9.0], depth=1, loss=AbsoluteError())).objective
    1.0
    """

    name = "absolute"
    spellings = ("absolute",)

    @property
    def words(self) -> str:
        """What is summed up."""
        return "absolute error"

    @property
    def slopes(self) -> Slopes:
        """The same above and below."""
        return Slopes(1, 1, 1)

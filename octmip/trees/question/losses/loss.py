"""Loss: what a Problem asks of a loss, whichever it is.

Arrays of a problem's samples: `weights` (n_samples,) float64, `codes` (n_samples,) the targets as the loss reads them
(of classes the index of each in `Samples.class_names`, of numbers the numbers), `predicted` (n_samples,) of the same
kind. Nothing here knows a tree: a leaf is the value that it predicts.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Loss(ABC):
    """The cost of a prediction: ``sum_i weights_i * cost(codes_i, predicted_i)`` is what a tree is to make small."""

    name: ClassVar[str]
    """As the command, the estimators and files name it."""
    predicts: ClassVar[Literal["class", "number"]]
    """What a leaf holds."""
    measured: ClassVar[tuple[str, ...]]
    """Names of `measures`."""

    @property
    def spelling(self) -> str:
        """The name, with what else tells the loss from others: as logs and files of problems have it."""
        return self.name

    @property
    @abstractmethod
    def words(self) -> str:
        """What is summed up, for a sentence."""

    @abstractmethod
    def check_range(self, weights: Floats, codes: NDArray[Any], most_prices: float) -> None:
        """Raise unless every objective is a number of float64 that sums of float64 can be trusted with.

        Parameters
        ----------
        weights, codes
            of the problem.
        most_prices
            of the splits of the largest tree, together.

        Raises
        ------
        ProblemError
            it is not.
        """

    @abstractmethod
    def best_value(self, weights: Floats, codes: NDArray[Any]) -> float:
        """Return the value of least cost for some samples, all of them in one leaf: a class's index or a number."""

    @abstractmethod
    def row_costs(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Floats:
        """Return weight times cost of each prediction, rounded, shape (n_samples,)."""

    def contrasts(self, weights: Floats, codes: NDArray[Any]) -> Floats | None:
        """Return the most by which two predicted classes differ in cost on one row, (n_classes, n_classes).

        The row has the class at which they differ most and the mean weight of that class. None for numbers: there is
        no such most.
        """
        return None

    @abstractmethod
    def exact_cost(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Fraction:
        """Return the cost of predictions as a rational number: nothing is rounded."""

    def cost(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any], prices: Fraction) -> float:
        """Return the cost of predictions and the prices of splits, rounded once; +inf beyond float64."""
        try:
            return float(self.exact_cost(weights, codes, predicted) + prices)
        except OverflowError:
            return math.inf

    @abstractmethod
    def has_whole_costs(self, weights: Floats) -> bool:
        """Whether every cost is a whole number below 2^52, so that sums are exact and bounds may be rounded up."""

    @abstractmethod
    def measures(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Mapping[str, float]:
        """Return what people judge predictions by, by its name."""

    @abstractmethod
    def words_of(self, measures: Mapping[str, float], n_samples: int) -> str:
        """Return the measures of so many samples in words, as a part of a sentence."""

    def short_words_of(self, measures: Mapping[str, float], n_samples: int) -> str:
        """Return the first of the measures in words."""
        return self.words_of(measures, n_samples)

    def to_json(self) -> dict[str, Any]:
        """Return what a file holds of the loss: its name, and what belongs to it; `loss_of` reads it."""
        return {"name": self.name}

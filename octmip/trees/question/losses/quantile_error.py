"""The quantile loss, also called pinball loss: a leaf predicts a low or a high quantile in place of the middle.

``cost(y, f) = q (y - f)`` where y is above f, and ``(1 - q) (f - y)`` where it is not, q the level. The best leaf
predicts the lowest weighted quantile of level q: at least a share q of the weight is at or below it, and at least 1 - q
at or above. Source: Koenker & Bassett (1978), section 3, for a constant alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.question.losses.errors_of_numbers import SlopedError
from octmip.trees.question.losses.exact_sums import Slopes
from octmip.trees.question.losses.loss import Floats

MOST_DENOMINATOR = 1000
"""A level is a fraction of whole numbers up to this: errors times its denominator are then sums of whole numbers."""


@dataclass(frozen=True, slots=True)
class QuantileError(SlopedError):
    """The quantile loss of a level; a leaf predicts the lowest weighted quantile.

    Attributes
    ----------
    level
        between 0 and 1, such as 0.9, 0.025 or 1 / 3: a fraction whose denominator is 1000 at most. Its float64 stands
        for that fraction, so 0.9 is nine tenths.

    Raises
    ------
    ProblemError
        the level is none.

    Examples
    --------
    >>> solve(Problem([[0.0], [0.0], [1.0]], [5.0, 9.0, 7.0], depth=1, loss=QuantileError(0.9))).tree
    Split(0, 0.5, ValueLeaf(9.0), ValueLeaf(7.0))
    """

    level: float

    name = "quantile"
    spellings = ("quantile:0.9", "quantile:0.1")
    parameters: ClassVar[Mapping[str, tuple[float, float]]] = {"level": (0.0, 1.0)}
    measured = ("mae", "rmse", "pinball", "covered")

    def __post_init__(self) -> None:
        is_between = isinstance(self.level, int | float) and 0 < self.level < 1
        fraction = self.fraction if is_between else Fraction(0)
        if fraction == 0 or float(fraction) != self.level:
            raise ProblemError(
                f"the level of the quantile loss is {self.level!r}; expected a number between 0 and 1 that is a "
                f"fraction of whole numbers up to {MOST_DENOMINATOR}, such as 0.9 or 1 / 3; round it"
            )

    @classmethod
    def of_spelling(cls, values: str) -> Self:
        """Return the loss of a level in digits, such as 0.9 or 1/3."""
        try:
            level = float(Fraction(values))
        except (ValueError, ArithmeticError) as error:
            raise ProblemError(
                f"the level of the quantile loss is {values!r}; expected a number between 0 and 1, such as quantile:0.9"
            ) from error
        return cls(level)

    @property
    def fraction(self) -> Fraction:
        """The level in lowest terms."""
        return Fraction(self.level).limit_denominator(MOST_DENOMINATOR)

    @property
    def spelling(self) -> str:
        """The name and the level in lowest terms."""
        return f"{self.name}:{self.fraction}"

    @property
    def words(self) -> str:
        """What is summed up."""
        return f"error of the {self.level:g} quantile"

    @property
    def slopes(self) -> Slopes:
        """The level above, the rest below."""
        up, over = self.fraction.as_integer_ratio()
        return Slopes(up, over - up, over)

    def measures(self, weights: Floats, codes: NDArray[Any], predicted: NDArray[Any]) -> Mapping[str, float]:
        """Return the measures of numbers, the weighted mean of the loss, and the share of weight at or below."""
        pinball = float(np.average(self.of_misses(codes - predicted), weights=weights))
        covered = float(np.average(codes <= predicted, weights=weights))
        return {**SlopedError.measures(self, weights, codes, predicted), "pinball": pinball, "covered": covered}

    def short_words_of(self, measures: Mapping[str, float], n_samples: int) -> str:
        """Return the mean of the loss, and how many targets lie at or below the predictions."""
        return f"mean {self.words} {measures['pinball']:.6g}, {100 * measures['covered']:.3g} % at or below"

    def to_json(self) -> dict[str, Any]:
        """Return the name and the level."""
        return {"name": self.name, "level": self.level}

"""Bands: how far the readings of each gauge may be off, and the readings that follow from it.

A gauge that is off by an error e of its band [-below, above] reads x + e, rounded to float64, in place of x. Rounding
keeps the order, so such a reading is any number between the lowest one, x - below, and the highest one, x + above.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.input.messages import several
from octmip.trees.problem import Problem

Amount = float | tuple[float, float]
"""Most that a reading is off to either side, or (most below, most above), both 0 or more."""


@dataclass(frozen=True, slots=True, eq=False)
class Bands:
    """The bands of a problem's features, in its order.

    Attributes
    ----------
    below, above
        (n_features,) most that a reading is too low, too high.
    low, high
        (n_samples, n_features) lowest and highest readings.
    """

    below: NDArray[np.float64]
    above: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @classmethod
    def of(cls, problem: Problem, given: Amount | Mapping[str, Amount]) -> "Bands":
        """Return the bands of a problem.

        Parameters
        ----------
        problem
            with ``split="axis"`` and no missing reading.
        given
            one amount for all, or amounts by the name of a sensor (for all its features) or of a feature. What is not
            named is never off.

        Raises
        ------
        ProblemError
            an amount is negative or not finite, a name is unknown, readings are missing, or splits are hyperplanes.
        """
        if problem.split != "axis":
            raise ProblemError("the worst case is of splits on one feature but split is 'hyperplane'; use 'axis'")
        if np.isnan(problem.features).any():
            raise ProblemError(
                "features holds missing readings; the worst case needs all of them; fill them or leave them out"
            )
        sides = np.array(_sides(problem, given), dtype=np.float64).reshape(problem.n_features, 2)
        with np.errstate(over="ignore"):
            low, high = problem.features - sides[:, 0], problem.features + sides[:, 1]
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            raise ProblemError("a reading and its band add up to more than float64 holds; divide both by one number")
        return cls(sides[:, 0], sides[:, 1], low, high)

    def can_be_off(self, feature: int) -> bool:
        """Whether a feature's reading may be off at all."""
        return bool(self.below[feature] > 0 or self.above[feature] > 0)

    def sensors(self, problem: Problem) -> tuple[str, ...]:
        """Return the sensors that may be off, in the order of the problem."""
        chosen = {int(problem.sensor_index[f]) for f in range(problem.n_features) if self.can_be_off(f)}
        return tuple(problem.sensors[s] for s in sorted(chosen))


def _sides(problem: Problem, given: Amount | Mapping[str, Amount]) -> list[tuple[float, float]]:
    if not isinstance(given, Mapping):
        return [_pair(given, "bands")] * problem.n_features
    unknown = [name for name in given if name not in (*problem.sensors, *problem.feature_names)]
    if unknown:
        raise ProblemError(
            f"bands names {several(unknown)}, neither a sensor nor a feature of the problem; expected some of "
            f"{several(problem.sensors)}"
        )
    sensors = problem.sensor_of_feature or ()
    named = [
        given.get(feature, given.get(sensor, 0.0))
        for feature, sensor in zip(problem.feature_names, sensors, strict=True)
    ]
    return [_pair(amount, f"band of {name!r}") for name, amount in zip(problem.feature_names, named, strict=True)]


def _pair(amount: Any, what: str) -> tuple[float, float]:
    """Return the amount below and above."""
    sides = amount if isinstance(amount, tuple | list) else (amount, amount)
    try:
        below, above = (float(side) for side in sides)
    except (TypeError, ValueError) as error:
        raise ProblemError(f"{what} is {amount!r}; expected an amount, or a pair (most below, most above)") from error
    if not (0 <= below < math.inf and 0 <= above < math.inf):
        raise ProblemError(f"{what} is {amount!r}; expected finite numbers of 0 or more")
    return below, above

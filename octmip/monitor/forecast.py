"""Forecast: in how many steps an asset fails, from what is believed of its state and of its growth rate.

With b_k the belief about an asset that has not failed by step k, not normalised, and h(s) the chance of failing in a
step in state s,

    b_k(r, s') = (1 - h(s')) * sum_s  growth_r(s -> s')  b_{k-1}(r, s),      P(life > k) = sum b_k.

Failing may mean passing a limit: h is then 0 below and 1 above it, and the limit is best an edge of the cells. Growth
moves a parameter from cell to cell, so its scatter is the cells' width times its mean: cells as wide as the scale of
the steps in which damage really grows give true bands.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.monitor.belief import Belief
from octmip.monitor.growth import Growth

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Forecast:
    """The remaining life of n assets.

    Attributes
    ----------
    survival
        (n, n_steps + 1) probability of not having failed after 0, 1, ... steps.

    Examples
    --------
    >>> Forecast(np.array([[1.0, 0.9, 0.4, 0.0]])).quantile(0.5).tolist()
    [2.0]
    """

    survival: Floats

    def quantile(self, level: float) -> Floats:
        """Return the step (n,) by which an asset has failed with probability `level`; infinite past the last step."""
        has_failed = 1.0 - self.survival >= level
        return np.where(has_failed.any(axis=1), has_failed.argmax(axis=1), np.inf)

    def interval(self, content: float = 0.9) -> tuple[Floats, Floats]:
        """Return the steps (n,), (n,) between which an asset fails with probability `content`."""
        return self.quantile(0.5 - content / 2), self.quantile(0.5 + content / 2)


def remaining_life(growth: Growth, belief: Belief, fails: ArrayLike, n_steps: int) -> Forecast:
    """Return the forecast of n_steps.

    Parameters
    ----------
    growth
        of damage, as the filter of the belief has it or as it will be.
    belief
        about each asset now.
    fails
        (n_states,) chance of failing in a step.

    Raises
    ------
    ProblemError
        `fails` has another shape or is no probability.

    Examples
    --------
    A crack that grows by one of two rates, and an asset that fails when it is 0.8 long:

    >>> from octmip.monitor import Library, Belief, steady_growth, remaining_life
    >>> library = Library(("crack",), [[0.1 * k] for k in range(9)], ("a",), [[1.0 + k] for k in range(9)], 1.0)
    >>> growth = steady_growth(library, rates=(0.01, 0.04))
    >>> sound = np.zeros((1, 2, 9)); sound[0, :, 0] = (0.2, 0.8)
    >>> life = remaining_life(growth, Belief(library, sound), fails=library.states[:, 0] > 0.75, n_steps=200)
    >>> [steps.tolist() for steps in life.interval(0.9)]
    [[13.0], [96.0]]
    """
    chances = checked_chances(fails, "fails", growth.n_states)
    weights, alive = belief.weights, [np.ones(len(belief.weights))]
    for _ in range(n_steps):
        weights = growth.advance(weights) * (1.0 - chances)
        alive.append(weights.sum(axis=(1, 2)))
    return Forecast(np.column_stack(alive))


def checked_chances(values: ArrayLike, name: str, n_states: int) -> Floats:
    """Return probabilities (n_states,), checked."""
    chances = np.asarray(values, dtype=np.float64)
    if chances.shape != (n_states,) or not ((chances >= 0.0) & (chances <= 1.0)).all():
        raise ProblemError(
            f"{name} has shape {chances.shape} and values from {chances.min(initial=np.inf)} to "
            f"{chances.max(initial=-np.inf)}; expected ({n_states},) probabilities, one for each state; correct it"
        )
    return chances

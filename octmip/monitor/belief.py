"""Belief: probabilities over the states of a library, with the means, quantiles and intervals that follow.

Within its cell a state is taken as uniform, so a parameter's distribution function is piecewise linear between the
cells' edges (a step where the width is 0), and a quantile is where it crosses a level. The price: where readings tell
places within a cell apart, sets come out wide (92 to 93 % instead of 90 % with cells of about the noise's width).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.monitor.library import Library

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """Probabilities of growth rates and states, for one asset or for n at once.

    Attributes
    ----------
    library
        the states.
    weights
        (n, n_rates, n_states) probability of every growth rate and state, 1 in all for each asset.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> belief = Belief(library, np.array([[[0.25, 0.75]]]))  # one asset, one growth rate, two states
    >>> belief.mean("crack").round(2).tolist(), belief.probability_above({"crack": 0.2}).tolist()
    ([0.3], [0.75])
    """

    library: Library
    weights: Floats

    @property
    def probability(self) -> Floats:
        """Probability (n, n_states) of every state."""
        return np.asarray(self.weights.sum(axis=1))

    @property
    def rates(self) -> Floats:
        """Probability (n, n_rates) of every growth rate."""
        return np.asarray(self.weights.sum(axis=2))

    def _axis(self, parameter: str) -> tuple[int, Floats, NDArray[np.int64]]:
        if parameter not in self.library.parameters:
            raise ProblemError(f"the library has no parameter {parameter!r}; expected one of {self.library.parameters}")
        k = self.library.parameters.index(parameter)
        levels, at = np.unique(self.library.states[:, k], return_inverse=True)
        return k, levels, at.ravel()

    def marginal(self, parameter: str) -> tuple[Floats, Floats]:
        """Return the levels (n_levels,) of a parameter and their probabilities (n, n_levels)."""
        _, levels, at = self._axis(parameter)
        table = np.zeros((self.library.n_states, len(levels)))
        table[np.arange(len(at)), at] = 1.0
        return levels, self.probability @ table

    def mean(self, parameter: str) -> Floats:
        """Return the mean (n,) of a parameter."""
        k, _, _ = self._axis(parameter)
        return np.asarray(self.probability @ self.library.states[:, k])

    def quantile(self, parameter: str, level: float) -> Floats:
        """Return the quantile (n,) of a parameter: least expected absolute error at level 0.5."""
        k, _, _ = self._axis(parameter)
        levels, mass = self.marginal(parameter)
        width = float(self.library.widths[k])
        below = np.cumsum(mass, axis=1)
        at = np.minimum((below < level * below[:, -1:]).sum(axis=1), len(levels) - 1)
        rows = np.arange(len(mass))
        own = np.maximum(mass[rows, at], 1e-300)
        share = np.clip((level * below[:, -1] - (below[rows, at] - mass[rows, at])) / own, 0.0, 1.0)
        return np.asarray(levels[at] + (share - 0.5) * width)

    def interval(self, parameter: str, content: float = 0.9) -> tuple[Floats, Floats]:
        """Return the ends (n,), (n,) of the central interval that holds a parameter with probability `content`."""
        return self.quantile(parameter, 0.5 - content / 2), self.quantile(parameter, 0.5 + content / 2)

    def probability_above(self, thresholds: Mapping[str, float]) -> Floats:
        """Return the probability (n,) that any of these parameters lies above its threshold."""
        below = np.ones(self.library.n_states)
        for name, threshold in thresholds.items():
            k, _, _ = self._axis(name)
            below *= share_below(self.library.states[:, k], float(self.library.widths[k]), threshold)
        return np.asarray(self.probability @ (1.0 - below))

    def expectation(self, of_state: Floats) -> Floats:
        """Return the mean (n,) of what `of_state` (n_states,) says of every state."""
        return np.asarray(self.probability @ of_state)


def share_below(states: Floats, width: float, threshold: float | Floats) -> Floats:
    """Return the share of each cell (n_states,) that lies at or below a threshold, one or (n, 1)."""
    if width == 0.0:
        return np.asarray(states <= threshold, dtype=np.float64)
    return np.clip((threshold - (states - width / 2)) / width, 0.0, 1.0)

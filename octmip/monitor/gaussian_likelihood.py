"""The likelihood of a whole reading in every state of a library: more than the leaf of a tree holds.

In state s at load factor L a reading is N(L strains_s, D + L^2 G_s' G_s), D the diagonal of the noise variances and
G_s (n_parameters, n_gauges) the slopes times width / sqrt(12): the spread of a state uniform in its cell, taken as
normal. By Woodbury, with W = D^-1/2 and A = W L G_s' (n_gauges, n_parameters),

    log p = -1/2 ( |W r|^2 - |C^-1 A' W r|^2 + log det(I + A' A) ) + const,   C C' = I + A' A.

A missing gauge leaves the sums; its row of A and of W r is struck.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.monitor.library import Applied, Library

Floats = NDArray[np.float64]

MOST_TABLES = 64
"""Tables kept, one for each load and set of gauges at hand."""


@dataclass(slots=True, eq=False)
class GaussianLikelihood:
    """A whole reading as an observation of the state; keeps its tables, so it is not frozen.

    Attributes
    ----------
    library
        the states.
    """

    library: Library
    _tables: dict[tuple[float, bytes], tuple[Floats, Floats, Floats, Floats]] = field(
        init=False, repr=False, default_factory=dict
    )

    def log_likelihood(self, readings: Floats, load_factor: Applied) -> Floats:
        """Return log p(reading | state) up to a constant, (n, n_states), of readings (n, n_gauges), NaN missing."""
        load = self.library.checked_load(load_factor)
        is_known = ~np.isnan(readings)
        found = np.empty((len(readings), self.library.n_states))
        patterns, of_row = np.unique(is_known, axis=0, return_inverse=True)
        for k, pattern in enumerate(patterns):
            rows = np.flatnonzero(of_row.ravel() == k)
            found[rows] = self._of_pattern(readings[rows][:, pattern], load, pattern)
        return found

    def _of_pattern(self, readings: Floats, load: float, pattern: NDArray[np.bool_]) -> Floats:
        means, square, directions, log_det = self._table(load, pattern)
        scaled = readings / self.library.noise_sd[pattern]
        # |W r|^2 without its |W x|^2, which is the same for every state
        misfit = square - 2.0 * scaled @ means.T
        for k in range(len(self.library.parameters)):
            along = scaled @ directions[:, k].T - np.einsum("sg,sg->s", means, directions[:, k])
            misfit -= along**2
        return np.asarray(-0.5 * (misfit + log_det))

    def _table(self, load: float, pattern: NDArray[np.bool_]) -> tuple[Floats, Floats, Floats, Floats]:
        key = (load, pattern.tobytes())
        if key not in self._tables:
            if len(self._tables) >= MOST_TABLES:  # loads and missing gauges need not ever repeat
                self._tables.clear()
            library = self.library
            sd = library.noise_sd[pattern]
            means = load * library.strains[:, pattern] / sd
            spread = load * library.slopes[:, :, pattern] / sd * (library.widths / np.sqrt(12.0))[:, None]
            factor = np.linalg.cholesky(np.eye(len(library.parameters)) + spread @ spread.transpose(0, 2, 1))
            directions = np.linalg.solve(factor, spread)
            log_det = 2.0 * np.log(np.diagonal(factor, axis1=1, axis2=2)).sum(axis=1)
            self._tables[key] = (means, np.square(means).sum(axis=1), directions, log_det)
        return self._tables[key]

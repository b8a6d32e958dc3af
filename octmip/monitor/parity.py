"""Parity: the part of a reading that no state of the library can change, so that the state need not be known.

Scaled by the noise, a reading of state s at load L is  x = L (m + b_s) + noise,  m the library's mean strains and b_s
in the span of a few directions B. With P = I - B B' the residual e = P (x - L m) is P times the noise alone, whatever
the state: |e|^2 is chi-squared with n_gauges - rank(B) degrees of freedom. Damage of the library moves a reading along
B only; a failed gauge or a foreign damage in general does not.

B holds the left singular vectors of all the library's strains (and of the ends of its cells) until the rest is below
`REMAINDER` standard deviations at the largest load: then chi-squared grows by at most its square in the mean.

Source: parity relations of redundant measurements, E. Y. Chow, A. S. Willsky, IEEE Trans. Automatic Control 29 (1984).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.monitor.library import Applied, Library

Floats = NDArray[np.float64]

MOST_PROJECTORS = 256
"""Projections kept, one for each set of gauges at hand."""
REMAINDER = 0.1
"""The most that states may move a residual, in standard deviations of the noise."""


@dataclass(slots=True, eq=False)
class Parity:
    """The projection that takes the library's states out of readings, for any set of gauges at hand.

    It keeps a projector for each such set, so it is not frozen.

    Attributes
    ----------
    library
        the states.
    largest_load
        load factor up to which the remainder holds.
    """

    library: Library
    largest_load: float
    _projectors: dict[bytes, Floats] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.projector(np.ones(len(self.library.gauges), dtype=bool))  # refuses what leaves nothing over

    def projector(self, is_known: NDArray[np.bool_]) -> Floats:
        """Return P (n_gauges, n_gauges) of the gauges at hand, rows and columns of the others 0.

        Raises
        ------
        ProblemError
            the library's states can explain any reading of these gauges.
        """
        key = is_known.tobytes()
        if key not in self._projectors:
            if len(self._projectors) >= MOST_PROJECTORS:
                self._projectors.clear()
            self._projectors[key] = self._made(is_known)
        return self._projectors[key]

    def degrees(self, is_known: NDArray[np.bool_]) -> int:
        """Return the degrees of freedom of the residual of the gauges at hand."""
        return round(float(np.trace(self.projector(is_known))))

    def can_disagree(self, is_known: NDArray[np.bool_]) -> bool:
        """Return whether the gauges at hand are enough that the states leave some direction free."""
        try:
            return self.degrees(is_known) > 0
        except ProblemError:
            return False

    def residuals(self, readings: Floats, load_factor: Applied, is_known: NDArray[np.bool_]) -> Floats:
        """Return e (n, n_gauges) of readings (n, n_gauges) that have the gauges at hand; 0 at the others."""
        library = self.library
        centred = readings - self.library.checked_load(load_factor) * library.strains.mean(axis=0)
        return np.asarray(np.where(is_known, centred, 0.0) / library.noise_sd @ self.projector(is_known))

    def _made(self, is_known: NDArray[np.bool_]) -> Floats:
        library = self.library
        change = library.strains - library.strains.mean(axis=0)
        for k, width in enumerate(library.widths):
            step = library.slopes[:, k] * width / 2
            change = np.vstack([change, change[: library.n_states] + step, change[: library.n_states] - step])
        change = self.largest_load * change[:, is_known] / library.noise_sd[is_known]
        _, _, directions = np.linalg.svd(change, full_matrices=False)
        for rank in range(len(directions) + 1):
            basis = directions[:rank]
            rest = change - change @ basis.T @ basis
            if np.linalg.norm(rest, axis=1).max(initial=0.0) <= REMAINDER:
                break
        if is_known.sum() - rank < 1:
            raise ProblemError(
                f"the library of {library.n_states} states can explain any reading of {int(is_known.sum())} gauges; "
                f"expected more gauges than the {rank} directions in which its states differ; add gauges"
            )
        full = np.zeros((len(is_known), len(is_known)))
        full[np.ix_(is_known, is_known)] = np.eye(int(is_known.sum())) - basis.T @ basis
        return full

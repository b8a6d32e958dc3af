"""A table of strains as a twin: between its states the strains are interpolated.

Damages add up to 0.2 microstrain in 3000 in the published table, so each gauge is interpolated along one parameter
after the other by monotone cubics (pchip), which keep the table's own values and do not overshoot between them; that
gives a table in steps of `STEP`, and between its states strains are linear (0.1 microstrain at most).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from femlib.dataset import MeanStrains
from octmip.twin import Effect

Floats = NDArray[np.float64]

STEP = 0.01
"""Step of the table that is read, damage as a fraction."""


def between(table: Floats, places: Floats) -> Floats:
    """Return the rows (n, n_columns) of a table (n1, n2, n_columns) at places (n, 2), linear along either axis."""
    last = np.array(table.shape[:2]) - 1
    place = np.clip(places, 0.0, last)
    low = np.minimum(place.astype(np.intp), last - 1)
    share = place - low
    (i, j), (a, b) = low.T, (share[:, :1], share[:, 1:])
    near, far = ((1 - b) * table[k, j] + b * table[k, j + 1] for k in (i, i + 1))
    return np.asarray((1 - a) * near + a * far)


@dataclass(frozen=True, slots=True, eq=False)
class TableTwin:
    """The strains of a grid of states, at any state between them and any load.

    Attributes
    ----------
    gauges
        names.
    levels
        of each of two damage parameters, ascending from 0.
    strains
        (n_levels1, n_levels2, n_gauges) microstrain per unit of load factor.
    effects
        what the table lacks.
    gauge_positions
        (n_gauges, 2) [m], where they are known.
    """

    gauges: tuple[str, ...]
    levels: tuple[Floats, Floats]
    strains: Floats
    effects: Mapping[str, Effect] = field(default_factory=dict)
    parameters: tuple[str, ...] = ("mu1", "mu2")
    is_linear_in_load: bool = True
    gauge_positions: Floats | None = None
    _fine: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        fine = self.strains
        for axis, own in enumerate(self.levels):
            steps = np.linspace(0.0, own[-1], round(own[-1] / STEP) + 1)
            fine = PchipInterpolator(own, fine, axis=axis)(steps)
        object.__setattr__(self, "_fine", fine)

    @classmethod
    def of(cls, table: MeanStrains, effects: Mapping[str, Effect] | None = None) -> "TableTwin":
        """Return the twin of a table whose states are a full grid, the second parameter fastest."""
        first, second = (np.unique(table.states_percent[:, k]) / 100.0 for k in range(2))
        strains = table.strain_microstrain.reshape(len(first), len(second), -1) / table.load_factor
        return cls(table.gauges, (first, second), strains, effects or {})

    def predict_states(self, states: Floats, load_factor: float) -> Floats:
        """Return the strains (n_states, n_gauges) of damage fractions (n_states, 2); past the table, its last state."""
        return load_factor * between(self._fine, states / STEP)

    def predict(self, state: Mapping[str, float], load_factor: float) -> Floats:
        """Return the strains (n_gauges,) in microstrain of a state of damage fractions, compressive positive."""
        row = np.array([[state.get(name, 0.0) for name in self.parameters]])
        return np.asarray(self.predict_states(row, load_factor)[0])

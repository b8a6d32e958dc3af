"""A library of tabulated strains as a twin: between its states the strains are interpolated.

Damages add up to 0.2 microstrain in 3000 in the published table, so each gauge is interpolated along both parameters by
monotone cubics (pchip), which keep the table's own values and do not overshoot between them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from femlib.dataset import MeanStrains
from octmip.twin import Effect

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TableTwin:
    """The strains of 25 states, at any state between them and any load.

    Attributes:
        table: strains of a full grid of two damage parameters.
        effects: what the table lacks.
    """

    table: MeanStrains
    effects: Mapping[str, Effect] = field(default_factory=dict)

    parameters = ("mu1", "mu2")
    is_linear_in_load = True

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges."""
        return self.table.gauges

    @cached_property
    def _strains(self) -> RegularGridInterpolator:
        levels = [np.unique(self.table.states_percent[:, k]) / 100.0 for k in range(2)]
        shape = (len(levels[0]), len(levels[1]), -1)
        per_load = self.table.strain_microstrain.reshape(shape) / self.table.load_factor
        return RegularGridInterpolator(levels, per_load, method="pchip")

    def predict_states(self, states: Floats, load_factor: float) -> Floats:
        """Return the strains (n_states, n_gauges) of damage fractions (n_states, 2) within the table."""
        return np.asarray(load_factor * self._strains(states))

    def predict(self, state: Mapping[str, float], load_factor: float) -> Floats:
        """Return the strains (n_gauges,) in microstrain of a state of damage fractions, compressive positive."""
        row = np.array([[state.get(name, 0.0) for name in self.parameters]])
        return np.asarray(self.predict_states(row, load_factor)[0])

"""Gauge strains of damage states at a factor on one load, by a reduced model whose load factor is 1."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from femlib.arrays import FloatArray
from femlib.components import damage_row
from femlib.errors import InputError, is_number
from femlib.rom.model import ReducedModel
from femlib.sensors import checked_strains


@dataclass(frozen=True, slots=True, eq=False)
class ReducedStrains:
    """Gauge strains of damage states in microseconds, with a bound on their error.

    Attributes
    ----------
    model : ReducedModel
        Gauge strains [microstrain] at load factor 1, then what else the model is made exact for.

    Examples
    --------
    >>> import scipy
    >>> from femlib.rom import reduce_structure
    >>> from femlib.structure.example import clamped_strip
    >>> full = clamped_strip()
    >>> load, rows = full.point_load("tip", (0.0, 0.0, 100.0)), scipy.sparse.csr_array(np.eye(1, 60, 56))
    >>> found = ReducedStrains(reduce_structure(full.damaged, load, 1e6 * rows, ["g1"]))
    >>> found.predict({"root": 0.5}, load_factor=2.0).round().tolist()
    [9121.0]
    """

    model: ReducedModel

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges, in the order of the strains."""
        return self.model.outputs

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters: the columns of a state array."""
        return self.model.parameters

    @property
    def provenance(self) -> Mapping[str, str]:
        """Hash and size of the full model and of the load, settings and versions."""
        return self.model.provenance

    @property
    def mesh_error(self) -> float:
        """Estimated relative error of the full model by its mesh; NaN in older files."""
        return float(self.provenance.get("mesh_error", "nan"))

    def predict(self, state: Mapping[str, float], load_factor: float) -> FloatArray:
        """Return the gauge strains (n_gauges,) [microstrain] of a state of named damage fractions.

        Raises
        ------
        InputError
            If the state names an unknown parameter, a damage is outside [0, 1), the load factor is not finite, or a
            strain is beyond linear analysis.
        """
        return np.asarray(self.predict_states(damage_row(state, self.parameters)[None, :], load_factor)[0])

    def predict_states(self, states: FloatArray, load_factor: float) -> FloatArray:
        """Return the gauge strains (n_states, n_gauges) of states (n_states, n_parameters), as `predict`."""
        return checked_strains(checked_load_factor(load_factor) * self.model.solve(states)[:, : len(self.gauges)])

    def error_bound(self, states: ArrayLike, load_factor: float) -> FloatArray:
        """Return bounds (n_states, n_gauges) [microstrain] of the difference from the full model, as `predict`."""
        return abs(checked_load_factor(load_factor)) * self.model.error_bound(states)[:, : len(self.gauges)]

    def save(self, path: str | Path) -> None:
        """Write the model to one .npz file; InputError if it cannot be written."""
        self.model.save(path)

    @classmethod
    def load_file(cls, path: str | Path) -> Self:
        """Read a model that `save` wrote; InputError if the file is no such model."""
        return cls(ReducedModel.load_file(path))


def checked_load_factor(load_factor: float) -> float:
    """Return the load factor as a float; raise InputError if it is not a finite number."""
    if not is_number(load_factor):
        raise InputError(f"load_factor is {load_factor!r}; expected a finite number; 1 is the load itself")
    return float(load_factor)

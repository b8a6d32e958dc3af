"""The wing's reduced model: the results of `Wing` in microseconds, with an error bound."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.components import damage_row
from femlib.errors import InputError, frozen_floats
from femlib.mesh import DOFS_PER_NODE
from femlib.rom import ReducedStrains, ReductionSettings, reduce_structure
from femlib.rom.strains import checked_load_factor
from femlib.wing.model import MICRO, Wing

WORK = "work"
"""Name of the output that stands for the wing's displacement as a whole: load' u, at the largest strain's size."""


@dataclass(frozen=True, slots=True, eq=False)
class ReducedWing(ReducedStrains):
    """A wing's displacements and gauge strains, compressive positive, from its reduced model.

    The methods of `ReducedStrains` have two names: those of a twin, and those of the full wing. After the gauges the
    model has the output `WORK`.
    """

    def __post_init__(self) -> None:
        if not self.model.outputs or self.model.outputs[-1] != WORK or self.model.motion is None:
            raise InputError(
                f"a reduced model of {len(self.model.outputs)} outputs is not that of a wing; expected gauges, then "
                f"{WORK!r}, and displacements; make it with reduce_wing"
            )

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges, in the order of the strains."""
        return self.model.outputs[:-1]

    @property
    def gauge_names(self) -> tuple[str, ...]:
        """Names of the gauges, as `gauges`: under the name that they have in the full wing."""
        return self.gauges

    @property
    def gauge_positions(self) -> FloatArray | None:
        """Places (n_gauges, 2) of the gauges [m] as the full wing's; None if the file is older than they are."""
        return _points(self.provenance.get("gauge_positions"))

    def outline(self) -> FloatArray | None:
        """Return the closed polygon (5, 2) of the planform in (x, y) [m]; None if the file is older."""
        return _points(self.provenance.get("outline"))

    @property
    def model_hash(self) -> str:
        """Fingerprint of the full wing."""
        return self.provenance["model"]

    def solve(self, state: Mapping[str, float], load_factor: float) -> FloatArray:
        """Return the displacements (n_nodes, 6) [m, rad] of a state of named damage fractions, in single precision.

        Raises
        ------
        InputError
            If the state names an unknown parameter, a damage is outside [0, 1), or the load factor is not finite.
        """
        row = damage_row(state, self.parameters)[None, :]
        self.strains_microstrain(row, load_factor)  # refuses what is beyond linear analysis
        moved = checked_load_factor(load_factor) * self.model.displacements(row)[0]
        return np.asarray(moved.reshape(-1, DOFS_PER_NODE))

    strain_microstrain = ReducedStrains.predict
    strains_microstrain = ReducedStrains.predict_states
    error_bound_microstrain = ReducedStrains.error_bound


def reduce_wing(wing: Wing, settings: ReductionSettings | None = None, lift: FloatArray | None = None) -> ReducedWing:
    """Return the reduced model of a wing: its gauges under one load.

    Two regions take seconds, 28 at the default mesh two minutes and a gigabyte of memory; save the result.

    Parameters
    ----------
    wing : Wing
        The full model.
    settings : ReductionSettings, optional
        How fine; the defaults if not given.
    lift : FloatArray, optional
        Nodal forces and moments (n_dofs,) at load factor 1 [N, N m]; the wing's own lift if not given.

    Raises
    ------
    InputError
        If a force is not finite, all are zero, or they are not as many as the degrees of freedom.
    """
    load = wing.lift if lift is None else frozen_floats(lift, "lift", wing.lift.shape)
    if not load.any():
        raise InputError(f"lift is zero in all of {len(load)} entries; expected forces that bend the wing; give some")
    rows = MICRO * wing.strain_rows
    pristine = wing.solve({}, 1.0, lift).ravel()
    work = np.abs(rows @ pristine).max() / (load @ pristine) * load
    digest = hashlib.sha256(load.tobytes()).hexdigest()
    provenance = {
        "model": wing.model_hash,
        "load": digest,
        "gauge_positions": json.dumps(wing.gauge_positions.tolist()),
        "outline": json.dumps(wing.outline().tolist()),
        "unknowns": str(len(wing.structure.supports.free)),
        "octmip": version("octmip"),
        "mesh_error": repr(wing.mesh_error),
    }
    outputs = sparse.csr_array(sparse.vstack([rows, work[None, :]]))
    names = (*wing.gauges.names, WORK)
    return ReducedWing(reduce_structure(wing.structure, load, outputs, names, settings, provenance, True))


def _points(text: str | None) -> FloatArray | None:
    """Return the points (n, 2) that a provenance holds."""
    return None if text is None else frozen_floats(json.loads(text), "points", (-1, 2))

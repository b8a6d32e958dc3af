"""A structure's gauges under one load, in microseconds and with a bound on the error: a twin by its shape."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly import MOST_ERROR
from femlib.errors import InputError
from femlib.rom import ReducedStrains, ReductionSettings, reduce_structure
from femlib.sensors import StrainGauge
from femlib.structure.model import MICRO, MOST_GAUGE_ERROR, Structure


@dataclass(frozen=True, slots=True, eq=False)
class ReducedStructure(ReducedStrains):
    """Gauge strains of a structure, tension positive; what octmip calls a twin, by the methods of `ReducedStrains`.

    Examples
    --------
    >>> from femlib.sensors import StrainGauge
    >>> from femlib.structure.example import clamped_strip
    >>> structure = clamped_strip()
    >>> gauge = StrainGauge("g1", (0.5, 0.5, 0.0), (1, 0, 0), ("strip",))
    >>> twin = reduce(structure, structure.point_load("tip", (0.0, 0.0, 100.0)), [gauge], gauge_limit=0.2)
    >>> twin.parameters, twin.error_bound([[0.5]], load_factor=1.0).round(6).tolist()
    (('root',), [[0.0]])
    """

    @property
    def effects(self) -> Mapping[str, object]:
        """Effects that the model lacks: none are written for a structure of the user's own."""
        return {}

    @property
    def is_linear_in_load(self) -> bool:
        """Whether strain is proportional to the load factor: it is."""
        return True

    @property
    def compressive_positive(self) -> bool:
        """Whether compression is positive: tension is."""
        return False


def reduce(
    structure: Structure,
    load: FloatArray,
    gauges: Sequence[StrainGauge],
    settings: ReductionSettings | None = None,
    limit: float = MOST_ERROR,
    gauge_limit: float = MOST_GAUGE_ERROR,
) -> ReducedStructure:
    """Return the reduced model of a structure's gauges under one load.

    Parameters
    ----------
    structure : Structure
        The full model, with damage regions.
    load : FloatArray
        Nodal forces (n_dofs,) at load factor 1 [N, N m].
    gauges : sequence of StrainGauge
        The gauges.
    settings : ReductionSettings, optional
        How fine; the defaults if not given.
    limit, gauge_limit : float
        Estimated errors by the mesh beyond which it is refused, as by `Structure.strain_microstrain`.

    Raises
    ------
    InputError
        If the structure has no damage region, the load is not finite, or a gauge cannot be placed.
    SolveError
        If the undamaged structure's displacements or gauge strains are estimated to be too far off, or all regions
        damaged by half its displacements.

    Examples
    --------
    >>> from femlib.sensors import StrainGauge
    >>> from femlib.structure.example import clamped_strip
    >>> structure = clamped_strip()
    >>> load = structure.point_load("tip", (0.0, 0.0, 100.0))
    >>> twin = reduce(structure, load, [StrainGauge("g1", (0.5, 0.5, 0.0), (1, 0, 0), ("strip",))], gauge_limit=0.2)
    >>> [twin.predict(state, load_factor=2.0).round(2).tolist() for state in ({}, {"root": 0.5})]
    [[-24.0], [-48.0]]
    """
    if not structure.parameters:
        raise InputError("the structure has no damage region; expected at least one; name element sets in damage")
    rows = MICRO * structure.strain_rows(gauges)
    structure.solve(dict.fromkeys(structure.parameters, 0.5), load, limit)
    error = structure.strain_microstrain({}, load, gauges, limit, gauge_limit).error
    names = [gauge.name for gauge in gauges]
    provenance = {
        "model": structure.model_hash,
        "load": hashlib.sha256(np.asarray(load, dtype=np.float64).tobytes()).hexdigest(),
        "unknowns": str(len(structure.damaged.supports.free)),
        "octmip": version("octmip"),
        "mesh_error": repr(error),
    }
    return ReducedStructure(reduce_structure(structure.damaged, load, rows, names, settings, provenance))

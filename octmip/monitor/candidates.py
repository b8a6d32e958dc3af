"""Candidates: faults and damages outside a library, each with the change of a reading that it would cause."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.monitor.library import Library, default_levels
from octmip.twin import Effect, Twin, predict_states, state_limits_of, state_parameters

Floats = NDArray[np.float64]

GAUGE_SIZES = (-30.0, -10.0, -3.0, -1.0, 1.0, 3.0, 10.0, 30.0)
"""Faults of a gauge, in standard deviations of its noise."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One fault or damage outside the library.

    Attributes
    ----------
    name
        of the thing and its place.
    kind
        "gauge" or the name of an effect.
    signature
        (n_gauges,) change of a reading in microstrain per unit of size, at load factor 1.
    sizes
        that it is expected to have.
    unit
        of the size.
    load_power
        1: proportional to load; 0: the same at every load.

    Examples
    --------
    >>> Candidate("far tip", "bump", np.array([0.0, 10.0]), sizes=(1.0, 2.0), unit="mm", load_power=1).name
    'far tip'
    """

    name: str
    kind: str
    signature: Floats
    sizes: tuple[float, ...]
    unit: str
    load_power: int


def gauge_candidates(library: Library) -> tuple[Candidate, ...]:
    """Return one candidate per gauge: it reads too much or too little, by the same at every load."""
    return tuple(
        Candidate(gauge, "gauge", row, GAUGE_SIZES, "standard deviations", 0)
        for gauge, row in zip(library.gauges, np.diag(library.noise_sd), strict=True)
    )


def effect_candidates(
    twin: Twin, effect: Effect, library: Library, sizes: Sequence[float] | None = None
) -> tuple[Candidate, ...]:
    """Return one candidate per place where an effect of the twin may act.

    Parameters
    ----------
    sizes
        in the effect's unit; None: 1, 2 and 4 times its prior scale.

    Examples
    --------
    >>> from octmip.gap import SimpleEffect, function_twin
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "um/m"}, loads=["force"], linear=True)
    >>> library = library_of(twin, [[]], noise_sd=10.0, load_factor={"force": 1.0})
    >>> warm = SimpleEffect("warm", "K", 10.0, lambda readings, size: readings - 12.0 * size)
    >>> [(one.name, one.sizes) for one in effect_candidates(twin, warm, library)]
    [('warm', (10.0, -10.0, 20.0, -20.0, 40.0, -40.0))]
    """
    load = 1.0 if library.reference is None else library.asked_at[0]
    columns = [twin.gauges.index(gauge) for gauge in library.gauges]
    chosen = tuple(sizes) if sizes is not None else tuple(k * effect.prior_sd for k in (1.0, 2.0, 4.0))
    signs = (1.0,) if effect.is_one_sided else (1.0, -1.0)
    both = tuple(sign * size for size in chosen for sign in signs)
    return tuple(
        Candidate(
            place or effect.name,
            effect.name,
            np.asarray(effect.signature(twin, {}, load, place)[columns]),
            both,
            effect.unit,
            1 if effect.load_power is None else effect.load_power,
        )
        for place in effect.places(twin)
    )


def state_candidates(twin: Twin, library: Library) -> tuple[Candidate, ...]:
    """Return the damages that a twin knows by a state parameter and a library of it leaves out.

    The library's other parameters are 0 in them. Readings are not linear in a damage, so each parameter has one
    candidate for each level, of its own signature.
    """
    names = state_parameters(twin)
    load, factor = library.asked_at
    columns = [twin.gauges.index(gauge) for gauge in library.gauges]
    rows = [(k, level) for k, limit in enumerate(state_limits_of(twin)) for level in default_levels(limit)[1:]]
    rows = [(k, level) for k, level in rows if level > 0.0 and names[k] not in library.parameters]
    states = np.zeros((len(rows) + 1, len(names)))
    for row, (k, level) in enumerate(rows, start=1):
        states[row, k] = level
    strains = predict_states(twin, states, load)[:, columns] / factor
    return tuple(
        Candidate(names[k], "damage", (own - strains[0]) / (100.0 * level), (100.0 * level,), "%", 1)
        for (k, level), own in zip(rows, strains[1:], strict=True)
    )

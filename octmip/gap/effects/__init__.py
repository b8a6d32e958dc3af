"""Effects of the measuring chain on readings: one effect, one row of `chain` or of the tables of `families`."""

from collections.abc import Mapping

from octmip.gap.effects.chain import FORMULAS, ChainEffect
from octmip.gap.effects.families import History, families_of, named_families
from octmip.gap.effects.loads import LOAD_FACTOR_ERROR, errors_of_load
from octmip.twin import MICROSTRAIN, ONE_LOAD, Effect, Twin, loads_of

_OF_STRAINS: tuple[Effect, ...] = (*named_families([MICROSTRAIN], {}), *FORMULAS, LOAD_FACTOR_ERROR)
CHAIN: dict[str, Effect] = {effect.name: effect for effect in _OF_STRAINS}
"""The effects of any measuring chain of strain gauges, by name."""


def chain_of(
    twin: Twin,
    typical: Mapping[str, float] | None = None,
    histories: Mapping[str, History] | None = None,
    extents: Mapping[str, float] | None = None,
) -> dict[str, Effect]:
    """Return the effects of a measuring chain as this twin needs them: an error for each load, families of each unit.

    Parameters
    ----------
    twin
        whose loads, units and instruments count.
    typical
        root mean square of the readings of each unit; without it 1.
    histories
        courses of the campaign's own time, by name.
    extents
        greatest less least amount of each load that was applied; without it no load has an offset.
    """
    loads = loads_of(twin)
    error = float(getattr(getattr(twin, "twin", twin), "signature_error", 0.0))
    named = [one for load in loads for one in errors_of_load(load, (extents or {}).get(load, 0.0), error)]
    of_loads = [LOAD_FACTOR_ERROR] if loads == ONE_LOAD else named
    found: list[Effect] = [*families_of(twin, typical or {}, histories or {}), *FORMULAS, *of_loads]
    return {effect.name: effect for effect in found}


def in_chain(effect: Effect) -> bool:
    """Return whether an effect is one of the measuring chain's."""
    return effect.name in CHAIN or isinstance(effect, ChainEffect)


__all__ = ["CHAIN", "chain_of", "in_chain"]

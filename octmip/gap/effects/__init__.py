"""Effects of the measuring chain on readings: one effect, one line here or in the tables of `families`."""

from collections.abc import Mapping

from octmip.gap.effects.families import Family, History, families_of, named_families
from octmip.gap.effects.load_factor_error import LoadFactorError, error_of_load
from octmip.gap.effects.per_gauge import DEAD_GAUGE, MISALIGNMENT, POSITION_OFFSET, PerGauge
from octmip.gap.effects.two_gauges import Crosstalk, SwappedPair
from octmip.twin import MICROSTRAIN, ONE_LOAD, Effect, Twin, loads_of

OTHERS: tuple[Effect, ...] = (MISALIGNMENT, POSITION_OFFSET, SwappedPair(), DEAD_GAUGE, Crosstalk())
"""What is no family: its formula needs an angle, a place or a second gauge."""
CHAIN: dict[str, Effect] = {
    effect.name: effect for effect in (*named_families([MICROSTRAIN], {}), *OTHERS, LoadFactorError())
}
"""The effects of any measuring chain of strain gauges, by name."""


def chain_of(
    twin: Twin, typical: Mapping[str, float] | None = None, histories: Mapping[str, History] | None = None
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
    """
    loads = loads_of(twin)
    of_loads: list[Effect] = [LoadFactorError()] if loads == ONE_LOAD else [error_of_load(load) for load in loads]
    families = families_of(twin, typical or {}, histories or {})
    return {effect.name: effect for effect in (*families, *OTHERS, *of_loads)}


def in_chain(effect: Effect) -> bool:
    """Return whether an effect is one of the measuring chain's."""
    return effect.name in CHAIN or isinstance(effect, (PerGauge, LoadFactorError, Family))


__all__ = ["CHAIN", "chain_of", "in_chain"]

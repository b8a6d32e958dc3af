"""Effects of the measuring chain on readings: one effect, one line here."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from octmip.gap.effects.common_gain import CommonGain
from octmip.gap.effects.crosstalk import Crosstalk
from octmip.gap.effects.families import Family, families_of
from octmip.gap.effects.load_factor_error import LoadFactorError, error_of_load
from octmip.gap.effects.per_gauge import (
    DEAD_GAUGE,
    GAUGE_BIAS,
    GAUGE_DRIFT,
    GAUGE_GAIN,
    MISALIGNMENT,
    POSITION_OFFSET,
    PerGauge,
    offsets_of,
)
from octmip.gap.effects.swapped_pair import SwappedPair
from octmip.twin import MICROSTRAIN, ONE_LOAD, Effect, Twin, loads_of, units_of

CHAIN: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        GAUGE_GAIN,
        GAUGE_BIAS,
        GAUGE_DRIFT,
        MISALIGNMENT,
        POSITION_OFFSET,
        SwappedPair(),
        DEAD_GAUGE,
        Crosstalk(),
        LoadFactorError(),
        CommonGain(),
    )
}
"""The effects of any measuring chain, by name."""


def chain_of(twin: Twin, typical: Mapping[str, float] | None = None) -> dict[str, Effect]:
    """Return the effects of a measuring chain as this twin needs them.

    An error for each of its loads, and for each unit of its readings but microstrain an offset and a drift in that
    unit.

    Parameters
    ----------
    twin
        whose loads, units and instruments count.
    typical
        root mean square of the readings of each unit; without it 1.
    """
    loads, units = loads_of(twin), dict.fromkeys(units_of(twin))
    kept = dict(CHAIN)
    if loads != ONE_LOAD:
        del kept["load_factor_error"]
        kept |= {effect.name: effect for effect in map(error_of_load, loads)}
    if MICROSTRAIN not in units:
        del kept["gauge_bias"], kept["gauge_drift"]
    for unit in units:
        if unit != MICROSTRAIN:
            own = offsets_of(unit, (typical or {}).get(unit, 1.0), is_only=len(units) == 1)
            kept |= {effect.name: effect for effect in own}
    kept |= {effect.name: effect for effect in families_of(twin, typical or {})}
    return {name: _shared(effect, units_of(twin)) for name, effect in kept.items()}


def _shared(effect: Effect, units: Sequence[str]) -> Effect:
    """Return an effect on readings of one unit as rare as these are: a fault is as probable at each reading."""
    if isinstance(effect, PerGauge) and len(effect.units) == 1:
        return replace(effect, commonness=units.count(effect.units[0]) / len(units))
    if isinstance(effect, Family):
        return replace(effect, commonness=effect.commonness * units.count(effect.reading_unit) / len(units))
    return effect


def in_chain(effect: Effect) -> bool:
    """Return whether an effect is one of the measuring chain's."""
    return effect.name in CHAIN or isinstance(effect, (PerGauge, LoadFactorError, Family))


__all__ = ["CHAIN", "chain_of", "in_chain"]

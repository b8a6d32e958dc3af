"""Effects of the measuring chain on readings: one effect, one line here."""

from octmip.gap.effects.common_gain import CommonGain
from octmip.gap.effects.crosstalk import Crosstalk
from octmip.gap.effects.load_factor_error import LoadFactorError, error_of_load
from octmip.gap.effects.per_gauge import (
    DEAD_GAUGE,
    GAUGE_BIAS,
    GAUGE_DRIFT,
    GAUGE_GAIN,
    MISALIGNMENT,
    POSITION_OFFSET,
)
from octmip.gap.effects.swapped_pair import SwappedPair
from octmip.twin import ONE_LOAD, Effect, Twin, loads_of

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


def chain_of(twin: Twin) -> dict[str, Effect]:
    """Return the effects of a measuring chain as this twin needs them: an error for each of its loads."""
    loads = loads_of(twin)
    if loads == ONE_LOAD:
        return dict(CHAIN)
    kept = {name: effect for name, effect in CHAIN.items() if name != "load_factor_error"}
    return kept | {effect.name: effect for effect in map(error_of_load, loads)}


__all__ = ["CHAIN", "chain_of"]

"""Effects of the measuring chain on readings: one effect, one line here."""

from octmip.gap.effects.common_gain import CommonGain
from octmip.gap.effects.crosstalk import Crosstalk
from octmip.gap.effects.load_factor_error import LoadFactorError
from octmip.gap.effects.per_gauge import (
    DEAD_GAUGE,
    GAUGE_BIAS,
    GAUGE_DRIFT,
    GAUGE_GAIN,
    MISALIGNMENT,
    POSITION_OFFSET,
)
from octmip.gap.effects.swapped_pair import SwappedPair
from octmip.twin import Effect

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

__all__ = ["CHAIN"]

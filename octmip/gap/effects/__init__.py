"""What a measuring chain does to readings: one effect, one file, one line here."""

from octmip.gap.effects.common_gain import CommonGain
from octmip.gap.effects.crosstalk import Crosstalk
from octmip.gap.effects.dead_gauge import DeadGauge
from octmip.gap.effects.gauge_bias import GaugeBias
from octmip.gap.effects.gauge_drift import GaugeDrift
from octmip.gap.effects.gauge_gain import GaugeGain
from octmip.gap.effects.load_factor_error import LoadFactorError
from octmip.gap.effects.misalignment import Misalignment
from octmip.gap.effects.position_offset import PositionOffset
from octmip.gap.effects.swapped_pair import SwappedPair
from octmip.twin import Effect

CHAIN: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        GaugeGain(),
        GaugeBias(),
        GaugeDrift(),
        Misalignment(),
        PositionOffset(),
        SwappedPair(),
        DeadGauge(),
        Crosstalk(),
        LoadFactorError(),
        CommonGain(),
    )
}
"""The effects of any measuring chain, by name."""

__all__ = ["CHAIN"]

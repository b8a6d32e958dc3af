"""All gauges read too much or too little by one factor: excitation voltage, amplifier, gauge factor."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import Load, State, Twin


@dataclass(frozen=True, slots=True)
class CommonGain:
    """reading = (1 + size / 100) strain at every gauge."""

    name: str = "common_gain"
    parameter: str = "error of the gain common to all gauges"
    unit: str = "%"
    prior_mean: float = 0.0
    prior_sd: float = 1.0
    prior_source: str = "amplifiers and gauge factors of one batch are good to about one per cent"
    is_one_sided: bool = False
    separated_by: str = "strain alone cannot tell it from the load factor or a modulus: a shunt calibration does"
    load_power: int | None = None
    words: str = "gain common to all gauges"
    action: str = "recalibrate the amplifier of all gauges"
    says: tuple[str, str] = ("all gauges read {size} too high", "all gauges read {size} too low")
    seen_by: tuple[str, ...] = ("shunt_reading",)

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the one place, the whole structure."""
        return ("",)

    def signature(
        self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size."""
        return 0.01 * twin.predict(state, load_factor)

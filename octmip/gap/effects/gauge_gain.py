"""One gauge reads too much or too little by a constant factor: gauge factor, lead wires, bridge completion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import State, Twin


@dataclass(frozen=True, slots=True)
class GaugeGain:
    """reading_g = (1 + size / 100) strain_g."""

    name: str = "gauge_gain"
    parameter: str = "error of the gain of one gauge"
    unit: str = "%"
    prior_mean: float = 0.0
    prior_sd: float = 2.0
    prior_source: str = "gauge factors are given to 0.5 to 1 %, lead wires and bonding add as much again"
    is_one_sided: bool = False
    separated_by: str = (
        "a misalignment or an offset of the same gauge gives the same reading in one state; "
        "a shunt calibration tells the gain"
    )
    load_power: int | None = None

    def variants(self, twin: Twin) -> tuple[str, ...]:
        """Return the gauges."""
        return twin.gauges

    def signature(
        self, twin: Twin, state: State, load_factor: float, variant: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) in microstrain per unit of size."""
        change = np.zeros(len(twin.gauges))
        place = twin.gauges.index(variant)
        change[place] = 0.01 * twin.predict(state, load_factor)[place]
        return change

"""The zero of one gauge wanders with time: temperature of the bridge, creep of the adhesive, moisture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import State, Twin


@dataclass(frozen=True, slots=True)
class GaugeDrift:
    """reading_g = strain_g + size * time / 3600 s, from the start of the campaign."""

    name: str = "gauge_drift"
    parameter: str = "drift of one gauge"
    unit: str = "microstrain/h"
    prior_mean: float = 0.0
    prior_sd: float = 60.0
    prior_source: str = "unprotected gauges wander by some ten microstrain in an hour"
    is_one_sided: bool = False
    separated_by: str = (
        "the same load at the start and at the end of the campaign; "
        "with loads in ascending order a drift looks like a gain"
    )
    load_power: int | None = 0
    uses_time: bool = True

    def variants(self, twin: Twin) -> tuple[str, ...]:
        """Return the gauges."""
        return twin.gauges

    def signature(
        self, twin: Twin, state: State, load_factor: float, variant: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) in microstrain per unit of size."""
        change = np.zeros(len(twin.gauges))
        change[twin.gauges.index(variant)] = time / 3600.0
        return change

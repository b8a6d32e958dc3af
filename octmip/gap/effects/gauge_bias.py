"""One gauge reads a constant offset at every load: a bridge that was not balanced, a residual stress under it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import State, Twin


@dataclass(frozen=True, slots=True)
class GaugeBias:
    """reading_g = strain_g + size."""

    name: str = "gauge_bias"
    parameter: str = "offset of one gauge"
    unit: str = "microstrain"
    prior_mean: float = 0.0
    prior_sd: float = 30.0
    prior_source: str = "bridges are balanced to some ten microstrain"
    is_one_sided: bool = False
    separated_by: str = "a reading at zero load shows it alone"
    load_power: int | None = 0

    def variants(self, twin: Twin) -> tuple[str, ...]:
        """Return the gauges."""
        return twin.gauges

    def signature(
        self, twin: Twin, state: State, load_factor: float, variant: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) in microstrain per unit of size."""
        change = np.zeros(len(twin.gauges))
        change[twin.gauges.index(variant)] = 1.0
        return change

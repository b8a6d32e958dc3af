"""One gauge is dead: it reads zero (and noise) whatever the strain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import State, Twin


@dataclass(frozen=True, slots=True)
class DeadGauge:
    """reading_g = (1 - size) strain_g with size 1."""

    name: str = "dead_gauge"
    parameter: str = "part of the signal that one gauge has lost"
    unit: str = "-"
    prior_mean: float = 1.0
    prior_sd: float = 0.02
    prior_source: str = "a broken lead leaves nothing"
    is_one_sided: bool = True
    separated_by: str = "the reading does not move with the load"
    load_power: int | None = None
    acts_on_readings: bool = True

    def variants(self, twin: Twin) -> tuple[str, ...]:
        """Return the gauges."""
        return twin.gauges

    def signature(
        self, twin: Twin, state: State, load_factor: float, variant: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) in microstrain per unit of size."""
        change = np.zeros(len(twin.gauges))
        place = twin.gauges.index(variant)
        change[place] = -twin.predict(state, load_factor)[place]
        return change

"""One gauge sits beside its place along the span and reads the strain there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import State, Twin


@dataclass(frozen=True, slots=True)
class PositionOffset:
    """reading_g = strain_g + size * d(strain)/dy; the slope from the neighbouring gauges of the same row."""

    name: str = "position_offset"
    parameter: str = "offset of one gauge outboard"
    unit: str = "mm"
    prior_mean: float = 0.0
    prior_sd: float = 3.0
    prior_source: str = "gauges are placed to some millimetres"
    is_one_sided: bool = False
    separated_by: str = "in one state it equals a gain of the gauge; measuring its place on the structure tells"
    load_power: int | None = None

    def variants(self, twin: Twin) -> tuple[str, ...]:
        """Return the gauges whose places the twin tells."""
        return twin.gauges if getattr(twin, "gauge_positions", None) is not None else ()

    def signature(
        self, twin: Twin, state: State, load_factor: float, variant: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) in microstrain per unit of size."""
        places = np.asarray(twin.gauge_positions)  # type: ignore[attr-defined]
        place = twin.gauges.index(variant)
        change = np.zeros(len(twin.gauges))
        change[place] = 1e-3 * spanwise_slope(places, twin.predict(state, load_factor), place)
        return change


def spanwise_slope(places: NDArray[np.float64], strain: NDArray[np.float64], place: int) -> float:
    """Return d(strain)/dy [microstrain/m] at one gauge: the best plane through it and its four nearest neighbours."""
    near = np.argsort(np.linalg.norm(places - places[place], axis=1), kind="stable")[1:5]
    offset = (places[near] - places[place])[:, :2]
    weight = 1.0 / np.linalg.norm(offset, axis=1)
    slope = np.linalg.lstsq(offset * weight[:, None], (strain[near] - strain[place]) * weight, rcond=None)[0]
    return float(slope[1])

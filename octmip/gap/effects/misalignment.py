"""One gauge is turned against its direction and feels the transverse contraction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import State, Twin


@dataclass(frozen=True, slots=True)
class Misalignment:
    """reading_g = (1 - (1 + nu) s) strain_g with s = sin^2(angle) = size / 100, shear left out, nu = 0.3."""

    name: str = "misalignment"
    parameter: str = "sin^2 of the angle by which one gauge is turned (1 % is 5.7 degrees)"
    unit: str = "%"
    prior_mean: float = 0.0
    prior_sd: float = 1.0
    prior_source: str = "gauges are laid to a few degrees; transverse sensitivity is of the same order"
    is_one_sided: bool = True
    separated_by: str = (
        "it only lowers a reading, a gain goes both ways; a shunt calibration sees a gain and not an angle"
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
        change[place] = -0.01 * 1.3 * twin.predict(state, load_factor)[place]
        return change

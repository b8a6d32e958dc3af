"""The load is not what was noted: a load cell, a mass or an accelerometer off by a factor."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.twin import State, Twin


@dataclass(frozen=True, slots=True)
class LoadFactorError:
    """The asset feels (1 + size / 100) L."""

    name: str = "load_factor_error"
    parameter: str = "error of the load factor"
    unit: str = "%"
    prior_mean: float = 0.0
    prior_sd: float = 1.5
    prior_source: str = "load cells and accelerometers are good to about one per cent"
    is_one_sided: bool = False
    separated_by: str = (
        "strain alone cannot tell it from a common gain or a modulus: a second load cell or a known mass does"
    )
    load_power: int | None = None
    words: str = "error of the load factor"
    action: str = "correct the load factor"
    says: tuple[str, str] = ("the load was {size} higher than noted", "the load was {size} lower than noted")
    seen_by: tuple[str, ...] = ("applied_load",)

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the one place, the whole structure."""
        return ("",)

    def signature(
        self, twin: Twin, state: State, load_factor: float, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) in microstrain per unit of size."""
        step = 0.01
        return (twin.predict(state, load_factor * (1.0 + step)) - twin.predict(state, load_factor)) * (0.01 / step)

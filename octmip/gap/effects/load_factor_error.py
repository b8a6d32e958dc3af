"""A load is not what was noted: a load cell, a mass or an accelerometer off by a factor."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.twin import Load, Loads, State, Twin

STEP = 0.01
"""Step of the load, one unit of size."""


@dataclass(frozen=True, slots=True)
class LoadFactorError:
    """The asset feels (1 + size / 100) L.

    Attributes
    ----------
    load
        name of the load that is wrong, of a twin with several.

    The others are those of `octmip.twin.Effect`.
    """

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
    load: str = ""

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the one place, the whole structure."""
        return ("",)

    def signature(
        self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size.

        A twin that refuses the higher load, as a table does beyond its rows, is asked for the lower one.
        """
        here = twin.predict(state, load_factor)
        try:
            return twin.predict(state, self._times(load_factor, 1.0 + STEP)) - here
        except TwinError:
            return here - twin.predict(state, self._times(load_factor, 1.0 - STEP))

    def _times(self, load: Load, factor: float) -> Load:
        """Return the load with the one that is wrong multiplied."""
        if not isinstance(load, Loads):
            return load * factor
        pairs = [value * factor if name == self.load else value for name, value in load.items()]
        return Loads(load.names, tuple(pairs))


def error_of_load(load: str) -> LoadFactorError:
    """Return the error of a load of this name."""
    called = load.replace("_", " ")
    return LoadFactorError(
        name=f"{load}_error",
        parameter=f"error of the {called}",
        prior_source="instruments of a test are good to about one per cent",
        separated_by=f"a second instrument for the {called} shows it",
        words=f"error of the {called}",
        action=f"correct the {called}",
        says=(f"the {called} was {{size}} higher than noted", f"the {called} was {{size}} lower than noted"),
        load=load,
    )

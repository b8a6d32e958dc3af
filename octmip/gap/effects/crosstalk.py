"""Part of a neighbouring channel's signal leaks into a gauge's reading."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.effects.pairs import alike_pairs, pair_of
from octmip.twin import Load, State, Twin


@dataclass(frozen=True, slots=True)
class Crosstalk:
    """reading_a = strain_a + size / 100 strain_b for channels a, b next to each other."""

    name: str = "crosstalk"
    parameter: str = "part of the neighbouring channel's signal in one reading"
    unit: str = "%"
    prior_mean: float = 0.0
    prior_sd: float = 1.0
    prior_source: str = "multiplexers and common grounds leak up to one per cent"
    is_one_sided: bool = False
    separated_by: str = (
        "in one state it equals a gain of the gauge; "
        "states that change the neighbour's strain alone, or a shunt on the neighbour, separate them"
    )
    load_power: int | None = None
    words: str = "crosstalk between neighbouring channels"
    words_at: str = "crosstalk from gauge {second} into gauge {first}"
    action: str = "separate the channels of gauges {second} and {first}"
    says: tuple[str, str] = (
        "{size} of the signal of gauge {second} leaks into gauge {first}",
        "{size} of the signal of gauge {second} leaks into gauge {first} with its sign reversed",
    )
    seen_by: tuple[str, ...] = ("shunt_reading",)

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the ordered pairs of neighbouring channels, reading first."""
        pairs = alike_pairs(twin, zip(twin.gauges, twin.gauges[1:], strict=False))
        return tuple(f"{a}<{b}" for a, b in [*pairs, *((b, a) for a, b in pairs)])

    def gauges_of(self, twin: Twin, place: str) -> tuple[str, ...]:
        """Return the two gauges of a place."""
        return tuple(twin.gauges[k] for k in pair_of(twin, place, "<"))

    def signature(
        self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size."""
        change = np.zeros(len(twin.gauges))
        reading, source = pair_of(twin, place, "<")
        change[reading] = 0.01 * twin.predict(state, load_factor)[source]
        return change

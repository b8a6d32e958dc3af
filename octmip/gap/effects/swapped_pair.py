"""The wires of two gauges are swapped: each shows the other's strain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.effects.pairs import alike_pairs, pair_of
from octmip.twin import Load, State, Twin


@dataclass(frozen=True, slots=True)
class SwappedPair:
    """Readings a and b exchanged with size 1."""

    name: str = "swapped_pair"
    parameter: str = "1 when the two are exchanged"
    unit: str = "-"
    prior_mean: float = 1.0
    prior_sd: float = 0.02
    prior_source: str = "two channels are exchanged or they are not"
    is_one_sided: bool = True
    separated_by: str = "tapping or heating one gauge shows which channel answers"
    load_power: int | None = None
    words: str = "exchanged wires of two gauges"
    words_at: str = "exchanged wires of gauges {first} and {second}"
    action: str = "exchange the wires of gauges {first} and {second}"
    says: tuple[str, str] = ("each shows the strain of the other", "each shows the strain of the other")
    seen_by: tuple[str, ...] = ("channel_order",)
    acts_on_readings: bool = True

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the pairs of gauges."""
        every = ((a, b) for k, a in enumerate(twin.gauges) for b in twin.gauges[k + 1 :])
        return tuple(f"{a}/{b}" for a, b in alike_pairs(twin, every))

    def gauges_of(self, twin: Twin, place: str) -> tuple[str, ...]:
        """Return the two gauges of a place."""
        return tuple(twin.gauges[k] for k in pair_of(twin, place, "/"))

    def signature(
        self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size."""
        change = np.zeros(len(twin.gauges))
        first, second = pair_of(twin, place, "/")
        strain = twin.predict(state, load_factor)
        change[first] = strain[second] - strain[first]
        change[second] = -change[first]
        return change

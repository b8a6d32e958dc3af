"""Normal numbers for gauges, drawn by name: a gauge reads the same in every set and order of gauges.

The 20 gauges of the study lie outside the damage regions of every wing here and of the published table. A table of a
seed draws them together, all 20 whichever it holds, so that the seed stands for the readings of the published figures;
any other gauge has a generator of its own, seeded by the seed and the bytes of its name.
"""

from collections.abc import Sequence

import numpy as np

from femlib.arrays import FloatArray

N_PUBLISHED_GAUGES = 24
PUBLISHED_INSIDE_REGIONS = ("g17", "g18", "g23", "g24")
"""Gauges of the published table that lie in a damage region and are left out. Deduced from the table's increments."""
STUDY_GAUGES = tuple(
    name for k in range(1, N_PUBLISHED_GAUGES + 1) if (name := f"g{k:02d}") not in PUBLISHED_INSIDE_REGIONS
)
"""The 20 gauges of the study."""


class GaugeDraws:
    """Generators of some gauges, and one for what they share.

    Parameters
    ----------
    seed : sequence of int
        Seed words, 0 or more, that are the same for all gauges.
    gauges : sequence of str
        Names (n_gauges,).
    """

    def __init__(self, seed: Sequence[int], gauges: Sequence[str]) -> None:
        self.shared = np.random.default_rng(list(seed))
        # The bytes themselves and no hash of them: two names never share a generator.
        self._own = [np.random.default_rng([*seed, *name.encode()]) for name in gauges]

    def own(self, standard_deviation: float, shape: tuple[int, ...] = ()) -> FloatArray:
        """Return numbers (*shape, n_gauges) that are independent of each other."""
        numbers = np.empty((*shape, len(self._own)))
        for k, rng in enumerate(self._own):
            numbers[..., k] = rng.normal(0.0, standard_deviation, shape)
        return numbers


def table_noise(
    gauges: Sequence[str], n_rows: int, standard_deviation: float, seed: int, rng: np.random.Generator
) -> FloatArray:
    """Return the noise (n_rows, n_gauges) of a table of a seed; `rng`, made of it, draws the study's gauges."""
    study = dict(zip(STUDY_GAUGES, rng.normal(0.0, standard_deviation, (n_rows, len(STUDY_GAUGES))).T, strict=True))
    others = [name for name in gauges if name not in study]
    drawn = study | dict(zip(others, GaugeDraws([seed], others).own(standard_deviation, (n_rows,)).T, strict=True))
    return np.stack([drawn[name] for name in gauges], axis=1)

"""Histories of the wing: damage over time, and gauges that fail."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEPS = 100
"""Steps in which damage goes from 0 to 80 % in the paper's mission."""
MOST_STEPS = 110
"""Steps after which every aircraft has arrived."""
KINDS = ("paper", "own rate", "sudden", "dead gauge")


@dataclass(frozen=True, slots=True, eq=False)
class Histories:
    """The histories of n aircraft.

    Attributes
    ----------
    kind
        one of KINDS.
    damage
        (n, MOST_STEPS, 2) fractions of mu1 and mu2 by steps at 3 g; at 2 g they age more slowly (aircraft.WEAR).
    dead_gauge
        (n,) index of a gauge that reads nothing but 0 microstrain, -1: none; dead_from: (n,) step.
    """

    kind: str
    damage: Floats
    dead_gauge: NDArray[np.int64]
    dead_from: NDArray[np.int64]

    @property
    def rates(self) -> Floats:
        """Steady growth (n, 2) of mu1 and mu2 in a step at 3 g, over the first ten."""
        return np.asarray((self.damage[:, 10] - self.damage[:, 0]) / 10.0)

    @property
    def n(self) -> int:
        """Number of aircraft."""
        return len(self.damage)


def draw(kind: str, n: int, rng: np.random.Generator, gauges_read: tuple[int, ...]) -> Histories:
    """Return n histories of a kind; dead gauges are among those that the trees read."""
    time = np.minimum(np.arange(MOST_STEPS) / (STEPS - 1), 1.0)[None, :, None]
    end = np.full((n, 1, 2), 0.8)
    if kind in ("own rate", "sudden"):
        end = rng.uniform(0.0, 0.8, (n, 1, 2)) * (0.25 if kind == "sudden" else 1.0)
    damage = end * time
    if kind == "sudden":
        begin, region = rng.integers(5, 75, n), rng.integers(2, size=n)
        size = rng.uniform(0.2, 0.8, n)
        is_after = np.arange(MOST_STEPS) >= begin[:, None]
        damage[np.arange(n), :, region] = np.maximum(damage[np.arange(n), :, region], is_after * size[:, None])
    nothing, never = np.full(n, -1), np.full(n, MOST_STEPS)
    is_dead = kind == "dead gauge"
    return Histories(
        kind,
        damage,
        rng.choice(gauges_read, n) if is_dead else nothing,
        rng.integers(5, 75, n) if is_dead else never,
    )

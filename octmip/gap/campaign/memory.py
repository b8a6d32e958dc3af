"""How long readings remember, as a hypothesis with a few sizes.

Repeats leave a posterior over the memory of what single gauges have (`NoisePart.serial`). Where the variance of a mean
differs between its points by more than a factor, its mean is no more than a guess: the posterior is cut into sizes of
that variance, and the evidence of the means weighs them (`octmip.gap.inference.search`). Readings that step up and down
some ten times in a campaign look nearly white in a load, and move the means of others by several standard deviations.
"""

from dataclasses import dataclass

import numpy as np

from octmip.gap.campaign.noise import Noise
from octmip.gap.campaign.spectrum import given, inflation_of
from octmip.gap.campaign.wandering import with_memory

WIDTH = 1.6
"""Ratio of the variances of a mean from one size to the next."""
LEAST = 0.01
"""Probability of a size after the repeats, below which it is left out."""


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """One size: the noise of the readings if they remember so long, and its probability after the repeats."""

    noise: Noise
    share: float


def memories_of(noise: Noise, n: int) -> tuple[Memory, ...]:
    """Return the sizes of the variance of a mean of n readings that repeats leave open, the most probable first."""
    serial = noise.parts[0].serial
    variance = serial.white + serial.remembering * inflation_of(serial.rho, n)
    order = np.argsort(variance)
    middle = variance[order][int(np.searchsorted(np.cumsum(serial.weight[order]), 0.5))]
    number = np.round(np.log(variance / middle) / np.log(WIDTH))
    shares = {size: float(serial.weight[number == size].sum()) for size in np.unique(number).tolist()}
    kept = {size: share for size, share in shares.items() if share > LEAST}
    if len(kept) < 2:
        return (Memory(noise, 1.0),)
    found = [Memory(with_memory(noise, given(serial, number == size)), share) for size, share in kept.items()]
    return tuple(sorted(found, key=lambda one: -one.share))

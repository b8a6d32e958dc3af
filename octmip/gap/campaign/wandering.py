"""How far the readings wander from cell to cell, and how long they remember, as a hypothesis with a few sizes.

A random walk of all gauges that is too slow to stand out of the repeats of one cell still moves the means of later
cells by more than their scatter. Readings that step up and down some ten times in a campaign look nearly white within a
cell, and leave the variance of a mean open by a factor. So the repeats do not decide: they leave a posterior over the
walk and the memory, which is cut into sizes: of the variance of one step of a walk, and without one of the variance of
a mean. Each is a noise of its own; the evidence of the means weighs them (`octmip.gap.inference.search`).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.averages import AveragedCell
from octmip.gap.campaign.noise import Noise, least_moment
from octmip.gap.campaign.spectrum import STEPS, Serial, inflation_of

WIDTH = 3
"""Points of the grid of steps in one size: they differ by a factor of 3 in variance."""
RATIO = 1.6
"""Ratio of the variances of a mean from one size of the memory to the next."""
NEGLIGIBLE = 0.05
"""Variance that a walk adds to the last mean, over that of its scatter, below which it is none."""
LEAST_WALK, LEAST_MEMORY = 1e-6, 0.01
"""Probability of a size after the repeats, below which it is left out."""
SHARED_BY = 2.0
"""Gauges, counted by their variance (sum squared over sum of squares), beyond which a pattern is shared."""


def sizes(noise: Noise, averages: Sequence[AveragedCell]) -> tuple[tuple[Noise, float], ...]:
    """Return the noise for every size that the repeats leave open, each with its log probability.

    The most probable comes first.
    """
    serial = noise.parts[0].serial
    number = _numbers(serial, averages)
    found = []
    for k in np.unique(number):
        here, still = number == k, serial.walk == 0.0
        share = float(serial.weight[here].sum())
        if share > (LEAST_WALK if k > 0 else LEAST_MEMORY):
            own = serial.given(here & still if k <= 0 and (here & still).any() else here)
            found.append((noise.with_own(own), float(np.log(share))))
    return tuple(sorted(found, key=lambda pair: -pair[1]))


def _numbers(serial: Serial, averages: Sequence[AveragedCell]) -> NDArray[np.int64]:
    """Return the size of each point of the posterior (n_points,): 1 and more of a walk that shows, else of a mean."""
    ratio = serial.walk / np.maximum(serial.white, 1e-300)
    walk = np.where(serial.walk > 0.0, np.searchsorted(STEPS[::WIDTH], ratio * (1.0 + 1e-9), side="right"), 0)
    shows = [k for k in np.unique(walk[walk > 0]) if _shows(serial.given(walk == k), averages)]
    typical = int(np.median([len(part.rows) for part in averages]))
    variance = serial.white + serial.remembering * inflation_of(serial.rho, typical)
    order = np.argsort(variance)
    middle = variance[order][int(np.searchsorted(np.cumsum(serial.weight[order]), 0.5))]
    memory = np.round(np.log(variance / middle) / np.log(RATIO)).astype(np.int64)
    return np.where(np.isin(walk, shows), walk, memory - memory.max())


def moves_together(noise: Noise, averages: Sequence[AveragedCell]) -> float:
    """Return the probability that a pattern that gauges share wanders so far that means move by more than they scatter.

    A supply, lead wires or a temperature does that: no noise of the gauges, and no effect with a size.
    """
    found = 0.0
    for part in noise.parts[1:]:
        spread = np.diag(part.covariance)
        is_shared = float(spread.sum()) ** 2 > SHARED_BY * float(np.sum(spread**2))
        if is_shared and _shows(part.serial, averages, 1.0):
            found = max(found, part.serial.walk_probability)
    return found


def _shows(serial: Serial, averages: Sequence[AveragedCell], least: float = NEGLIGIBLE) -> bool:
    """Return whether a walk adds so much to the variance of the last mean, over that of its scatter."""
    last = max(averages, key=lambda average: float(average.moments.mean()))
    added = serial.step_variance * least_moment(last.moments, last.moments)
    return added > least * serial.of_mean(len(last.rows))

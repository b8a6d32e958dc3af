"""How far the readings wander from cell to cell, as a hypothesis with a few sizes.

A random walk of all gauges that is too slow to stand out of the repeats of one cell still moves the means of later
cells by more than their scatter. So the repeats do not decide: they leave a posterior over the variance of one step,
which is cut into sizes. Each is a noise of its own; the evidence of the means over campaign and commissioning run
weighs them (`octmip.gap.inference.search`). Sizes that move no mean by what could be seen are one with "nothing
wanders".
"""

from collections.abc import Sequence

import numpy as np

from octmip.gap.campaign.averages import AveragedCell
from octmip.gap.campaign.noise import Noise, least_moment
from octmip.gap.campaign.spectrum import STEPS, Serial

WIDTH = 3
"""Points of the grid of steps in one size: they differ by a factor of 3 in variance."""
NEGLIGIBLE = 0.05
"""Variance that a walk adds to the last mean, over that of its scatter, below which it is none."""
LEAST = 1e-6
"""Probability of a size after the repeats, below which it is left out."""
SHARED_BY = 2.0
"""Gauges, counted by their variance (sum squared over sum of squares), beyond which a pattern is shared."""


def sizes(noise: Noise, averages: Sequence[AveragedCell]) -> tuple[tuple[Noise, float], ...]:
    """Return the noise for every size of the walk that the repeats leave open, each with its log probability.

    The most probable comes first.
    """
    serial = noise.parts[0].serial
    ratio = serial.walk / np.maximum(serial.white, 1e-300)
    size = np.where(serial.walk > 0.0, np.searchsorted(STEPS[::WIDTH], ratio * (1.0 + 1e-9), side="right"), 0)
    size = np.where(np.isin(size, [k for k in set(size) if _shows(serial.given(size == k), averages)]), size, 0)
    found = []
    for k in np.unique(size):
        share = float(serial.weight[size == k].sum())
        of_size = (size == k) & ((serial.walk == 0.0) | (k > 0))
        if share > LEAST:
            own = serial.given(of_size if of_size.any() else size == k)
            found.append((noise.with_own(own), float(np.log(share))))
    return tuple(sorted(found, key=lambda pair: -pair[1]))


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

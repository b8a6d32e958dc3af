"""How far the readings wander from cell to cell, as a hypothesis with a few sizes.

A random walk of all gauges that is too slow to stand out of the repeats of one cell still moves the means of later
cells by more than their scatter. So the repeats do not decide: they leave a posterior over the variance of one step
(`NoisePart.open_serial`), which is cut into sizes. Each is a **wander** with a noise of its own; the evidence of the
means over campaign and commissioning run weighs them (`octmip.gap.inference.search`). Sizes that move no mean by what
could be seen are one with "nothing wanders".
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.averages import AveragedCell
from octmip.gap.campaign.noise import Noise, NoisePart, least_moment
from octmip.gap.campaign.spectrum import SINGLE, STEPS, Serial, given

Floats = NDArray[np.float64]

WIDTH = 3
"""Points of the grid of steps in one size: they differ by a factor of 3 in variance."""
NEGLIGIBLE = 0.05
"""Variance that a walk adds to the last mean, over that of its scatter, below which it is none."""
LEAST = 1e-6
"""Probability of a size after the repeats, below which it is left out."""
WALKS = 0.05
"""Probability that readings wander, before any.

At .15 a faint pattern that no library holds was taken for a walk (docs/gap/noise.md); at .05 one of five sound wings
with a mild walk beside a calm run was accused."""
ALIKE = 0.8
"""Probability that campaign and commissioning run wander alike; else each as far as it does."""
SHARED_BY = 2.0
"""Gauges, counted by their variance (sum squared over sum of squares), beyond which a pattern is shared."""
RANDOM_WALK = "random_walk"
"""Name of the finding."""
CORRELATED = "correlated_noise"
"""Name of the finding that readings remember each other."""
CERTAIN = 0.99
"""Probability of a memory from which it is a finding."""

EDGES = STEPS[::WIDTH]
"""Smallest variance of a step over that of a white reading of every size."""
PRIOR = np.array([1.0 - WALKS, *(WALKS * np.diff([*range(0, len(STEPS), WIDTH), len(STEPS)]) / len(STEPS))])
"""(1 + n_sizes,) probability of no walk and of every size before any reading."""


@dataclass(frozen=True, slots=True, eq=False)
class Wander:
    """One size of the walk, none included.

    Attributes
    ----------
    noise
        of the readings if they wander so far.
    share
        probability after the repeats.
    sizes
        which of the sizes of `PRIOR` it holds.
    """

    noise: Noise
    share: float
    sizes: tuple[int, ...]

    @property
    def log_likelihood(self) -> float:
        """What the repeats say of it: the log of its probability after them over that before."""
        return float(np.log(self.share / PRIOR[list(self.sizes)].sum()))


def wanders_of(noise: Noise, averages: Sequence[AveragedCell]) -> tuple[Wander, ...]:
    """Return the sizes of the walk of all gauges that the repeats leave open, the most probable first."""
    serial = noise.parts[0].open_serial
    if serial is None:
        return (Wander(noise, 1.0, tuple(range(len(PRIOR)))),)
    number = _numbers(serial)
    there = sorted(set(number.tolist()))
    seen = [size for size in there if size > 0 and _shows(given(serial, number == size), averages)]
    unseen = tuple(size for size in there if size not in seen)
    found = [_wander(noise, serial, number, (size,)) for size in seen]
    if unseen:
        found.append(_wander(noise, serial, number, unseen))
    return tuple(sorted((one for one in found if one.share > LEAST), key=lambda one: -one.share))


def transition(one: Wander, other: Wander) -> float:
    """Return the probability that a run wanders as `other` says where the campaign wanders as `one` says."""
    alike = PRIOR[[size for size in one.sizes if size in other.sizes]].sum() / PRIOR[list(one.sizes)].sum()
    return float(ALIKE * alike + (1.0 - ALIKE) * PRIOR[list(other.sizes)].sum())


def moves_together(noise: Noise, averages: Sequence[AveragedCell]) -> float:
    """Return the probability that a pattern that gauges share wanders so far that means move by more than they scatter.

    A supply, lead wires or a temperature does that: no noise of the gauges, and no effect with a size.
    """
    last = max(averages, key=lambda average: float(average.moments.mean()))
    found = 0.0
    for part in noise.parts[1:]:
        spread = np.diag(part.covariance)
        is_shared = float(spread.sum()) ** 2 > SHARED_BY * float(np.sum(spread**2))
        moved = part.serial.step_variance * least_moment(last.moments, last.moments)
        if is_shared and moved > part.serial.of_mean(len(last.rows)):
            found = max(found, part.serial.walk_probability)
    return found


def _numbers(serial: Serial) -> NDArray[np.int64]:
    """Return which size of `PRIOR` each point of the posterior has (n_points,)."""
    ratio = serial.walk / np.maximum(serial.white, 1e-300)
    return np.where(serial.walk > 0.0, np.searchsorted(EDGES, ratio * (1.0 + 1e-9), side="right"), 0)


def _shows(serial: Serial, averages: Sequence[AveragedCell]) -> bool:
    """Return whether a walk moves the mean that it moves most by enough beside its scatter."""
    last = max(averages, key=lambda average: float(average.moments.mean()))
    added = serial.step_variance * least_moment(last.moments, last.moments)
    return added > NEGLIGIBLE * serial.of_mean(len(last.rows))


def _wander(noise: Noise, serial: Serial, number: NDArray[np.int64], sizes: tuple[int, ...]) -> Wander:
    """Return some sizes as one: nothing wanders, where that is among them."""
    still = sizes if 0 not in sizes else (0,)
    weight = np.where(number > 0, serial.weight * WALKS / SINGLE[2], serial.weight * (1.0 - WALKS) / (1.0 - SINGLE[2]))
    share = float(weight[np.isin(number, sizes)].sum() / weight.sum())
    return Wander(with_memory(noise, given(serial, np.isin(number, still))), share, sizes)


def with_memory(noise: Noise, serial: Serial) -> Noise:
    """Return the noise with this memory of what single gauges have."""
    own = noise.parts[0]
    covariance = own.covariance * (serial.variance / own.serial.variance)
    part = NoisePart(covariance, serial, own.excess)
    others = [name for name in noise.findings if name != RANDOM_WALK]
    remembers = CORRELATED not in others and float(serial.weight @ (serial.remembering > 0.0)) > CERTAIN
    wanders = serial.step_variance > 0.0 or any(part.serial.walk_probability > 0.5 for part in noise.parts[1:])
    return replace(
        noise,
        covariance=noise.covariance - own.covariance + covariance,
        parts=(part, *noise.parts[1:]),
        findings=(*others, *[CORRELATED] * remembers, *[RANDOM_WALK] * wanders),
    )

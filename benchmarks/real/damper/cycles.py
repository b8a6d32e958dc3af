"""A test's recording reduced to half cycles and cells by a stated rule.

A half cycle runs from one reversal of the displacement to the next. Those with at least `WHOLE` of the test's longest
stroke are kept (the ramps at both ends of a test are not), if the one before it is in the recording. Its duration is
cut into `BINS` equal bins; the mean over the kept half cycles of one direction is the cell's reading, their scatter the
noise. A model is evaluated at the samples and averaged like the readings, so the bins blur nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.signal import find_peaks

from benchmarks.real.damper.features import Shown
from benchmarks.real.damper.series import Recording
from femlib.arrays import FloatArray

WHOLE = 0.8
BINS = 30
TURN = 0.3
"""Depth of a reversal over the half range of the displacement, from which it is one."""
SLIP = (0.5, 0.95)
"""Part of a half cycle's duration in which the drum slips for certain: the friction level is read there."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The samples of the kept half cycles of several tests, signs as recorded; all arrays (n_samples,).

    Attributes
    ----------
    test, half, bin
        index of the test, direction of motion (+1, -1), bin of the half cycle.
    stroke, since, phase
        displacement [in] and time [s] since the reversal, and the stroke over the test's half range.
    velocity, acceleration, position
        [in/s], [in/s2], displacement from the middle [in].
    force
        [kip].
    before, now
        tension [lb] at the tight end in the direction before the reversal, and in this one.
    """

    test: FloatArray
    half: FloatArray
    bin: FloatArray
    stroke: FloatArray
    since: FloatArray
    phase: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    position: FloatArray
    force: FloatArray
    before: FloatArray
    now: FloatArray

    def of(self, tests: Sequence[int]) -> "Samples":
        """Return the samples of some tests."""
        use = np.isin(self.test, list(tests))
        return Samples(*(getattr(self, name)[use] for name in FIELDS))

    @property
    def cell(self) -> FloatArray:
        """Index of each sample's cell, without gaps."""
        key = (2 * self.test + (self.half > 0)) * BINS + self.bin
        return np.asarray(np.unique(key, return_inverse=True)[1])


FIELDS = tuple(Samples.__dataclass_fields__)


def halves(test: Recording) -> list[tuple[int, int, float]]:
    """Return (first sample, last sample, direction) of the kept half cycles."""
    x = test.displacement
    depth = TURN * np.ptp(x) / 2.0
    tops, bottoms = find_peaks(x, prominence=depth)[0], find_peaks(-x, prominence=depth)[0]
    turns = sorted([(int(k), -1.0) for k in tops] + [(int(k), 1.0) for k in bottoms])
    pairs = [(i, j, sign) for (i, sign), (j, other) in pairwise(turns) if other != sign]
    longest = max((abs(x[j] - x[i]) for i, j, _ in pairs), default=0.0)
    return [(i, j, sign) for i, j, sign in pairs if abs(x[j] - x[i]) >= WHOLE * longest and j - i >= 8]


def slip(test: Recording, sign: float) -> FloatArray:
    """Return the samples' indices in which the drum slips for certain in a direction."""
    part = [np.arange(i, j)[int(SLIP[0] * (j - i)) : int(SLIP[1] * (j - i))] for i, j, s in halves(test) if s == sign]
    return np.concatenate(part) if part else np.zeros(0, dtype=np.int64)


def levels(test: Recording, found: Shown, is_wrong: bool, gain: float) -> dict[float, float]:
    """Return the tension [lb] at the tight end in each direction, as read, or from the force where that is wrong."""
    told: dict[float, float] = {}
    for sign in (1.0, -1.0):
        use = slip(test, sign)
        end = int(sign * found.sign > 0)
        reading = test.tension[end, use]
        if is_wrong or not np.isfinite(reading).any():
            told[sign] = float(abs(np.median(test.force[use]))) / gain if len(use) else np.nan
        else:
            told[sign] = float(np.nanmedian(reading))
    return told


def gain_of(tests: Sequence[Recording], found: Shown, wrong: Sequence[bool]) -> float:
    """Return the median over sound tests and directions of force over tension in slip [kip/lb]."""
    shares = []
    for test, is_wrong in zip(tests, wrong, strict=True):
        told = levels(test, found, False, 1.0) if not is_wrong else {}
        shares += [
            abs(float(np.median(test.force[slip(test, sign)]))) / level for sign, level in told.items() if level > 0
        ]
    return float(np.median(shares)) if shares else 1e-3


def samples_of(tests: Sequence[Recording], found: Shown, wrong: Sequence[bool]) -> Samples:
    """Return the samples of the kept half cycles; tests without two reversals have none."""
    gain = gain_of(tests, found, wrong)
    blocks = []
    for k, test in enumerate(tests):
        level = levels(test, found, wrong[k], gain)
        if all(np.isfinite(one) and one > 0.0 for one in level.values()):
            blocks += [half_cycle(test, k, i, j, sign, level) for i, j, sign in halves(test)]
    return Samples(*np.concatenate(blocks, axis=1)) if blocks else Samples(*np.zeros((len(FIELDS), 0)))


def half_cycle(test: Recording, k: int, i: int, j: int, sign: float, level: dict[float, float]) -> FloatArray:
    """Return the rows of `Samples` of one half cycle, (n_fields, j - i)."""
    one = np.ones(j - i)
    part = slice(i, j)
    stroke = np.abs(test.displacement[part] - test.displacement[i])
    half_range = np.ptp(test.displacement) / 2.0
    acceleration = np.gradient(test.velocity, test.step)[part]
    middle = (test.displacement.max() + test.displacement.min()) / 2.0
    return np.array([
        k * one, sign * one, np.minimum(np.arange(j - i) * BINS // (j - i), BINS - 1), stroke,
        test.time[part] - test.time[i], stroke / half_range, test.velocity[part], acceleration,
        test.displacement[part] - middle, test.force[part], level[-sign] * one, level[sign] * one,
    ])  # fmt: skip

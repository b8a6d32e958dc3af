"""The force balance of the drum: the force must be the lever times the difference of the two tensions.

    force(t) = k_b T_b(t) - k_a T_a(t) + c                                                     (1)

holds for any law of friction: it is the moment balance of the drum. The two ends act on one drum, so k_a and k_b are
nearly equal. Of each test, (1) is fitted by least squares; what it gives is judged in `accused`.

The tension channels may be slower than the force (a filter): the force is smoothed by what fits the tests of a series
best (median over tests, so that a few wrong ones do not move it), and delayed by what fits the test best.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.damper.series import Recording
from femlib.arrays import FloatArray

DELAYS = np.arange(-12, 25) / 128
"""Delays of the tension channels that are tried [s]."""
WIDTHS = (0.0, 0.03, 0.06, 0.1, 0.14)
"""Widths of the running mean on the force that are tried [s]."""
LEAST = 16
"""Samples that a fit needs."""


@dataclass(frozen=True, slots=True)
class Channel:
    """How a series' tension channels follow the force: delay and running mean [s]."""

    delay: float
    width: float


@dataclass(frozen=True, slots=True)
class Balance:
    """What (1) gives of one test: gains [kip/1000 lb], zero [kip], the share of the force's square that it leaves."""

    gain_a: float
    gain_b: float
    zero: float
    unexplained: float


def followed(test: Recording, width: float, delays: FloatArray) -> FloatArray:
    """Return the force (n_delays, n_samples) as slow channels would see it."""
    n = round(width / test.step) // 2
    force = np.convolve(np.pad(test.force, n, "edge"), np.ones(2 * n + 1) / (2 * n + 1), "valid")
    return np.array([np.interp(test.time - delay, test.time, force) for delay in delays])


def balances(test: Recording, width: float, delays: FloatArray) -> FloatArray:
    """Return (n_delays, 4): gains of both ends, zero, unexplained share.

    An end that was not recorded has gain NaN, and the time in which it is tight is left out; the zero is then NaN, for
    one side does not show it.
    """
    there = [end for end in (0, 1) if np.isfinite(test.tension[end]).mean() > 0.5]
    found = np.full((len(delays), 4), np.nan)
    use = np.isfinite(test.tension[there]).all(axis=0) & bool(there)
    if len(there) == 1:
        use &= tight_side(test, there[0])
    if use.sum() < LEAST:
        return found
    signs = np.array([-1.0, 1.0])[there]
    columns = np.vstack([signs[:, None] * test.tension[there][:, use] / 1e3, np.ones(int(use.sum()))])
    force = followed(test, width, delays)[:, use]
    sizes = force @ np.linalg.pinv(columns, rcond=1e-8)
    rest = force - sizes @ columns
    found[:, there] = sizes[:, :-1]
    found[:, 2] = sizes[:, -1] if len(there) == 2 else np.nan
    found[:, 3] = np.mean(rest**2, axis=1) / np.maximum(np.mean(force**2, axis=1), 1e-30)
    return found


def tight_side(test: Recording, end: int) -> NDArray[np.bool_]:
    """Return at which samples an end is the tight one: the force is on the side with which its tension grows."""
    reading = np.where(np.isfinite(test.tension[end]), test.tension[end], 0.0)
    middle = (np.quantile(test.force, 0.95) + np.quantile(test.force, 0.05)) / 2.0
    grows = np.cov(reading, test.force)[0, 1] >= 0.0
    return np.asarray((test.force > middle) == grows)


def balance_of(test: Recording, channel: Channel) -> Balance:
    """Return the fit of (1) to one test."""
    return Balance(*balances(test, channel.width, np.array([channel.delay]))[0].tolist())


def channel_width(tests: Sequence[Recording]) -> float:
    """Return the running mean [s] that leaves least of the force by the median of tests, each at its own delay."""
    best, found = np.inf, 0.0
    for width in WIDTHS:
        left = np.array([balances(test, width, DELAYS[::2])[:, 3].min() for test in tests])
        if np.isfinite(left).any() and np.nanmedian(left) < best:
            best, found = float(np.nanmedian(left)), width
    return found

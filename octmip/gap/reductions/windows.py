"""Means, spreads and rms of steps in stretches of time: one row of readings for a series.

A stretch is a pair (begin, end) [s], both included. The mean tells a steady level. The spread is the standard deviation
about the mean. The rms of steps, from one sample to the next, tells what is fast and does not see a slow wandering.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from octmip.errors import DataError
from octmip.gap.reductions.series import Floats, series_of

Stretch = tuple[float, float]


def window_means(time: ArrayLike, signal: ArrayLike, stretches: Sequence[Stretch]) -> Floats:
    """Return the mean of a signal in each stretch (n_stretches,)."""
    return np.array([part.mean() for part in _parts(time, signal, stretches)])


def window_spreads(time: ArrayLike, signal: ArrayLike, stretches: Sequence[Stretch]) -> Floats:
    """Return the standard deviation of a signal in each stretch (n_stretches,)."""
    return np.array([part.std(ddof=1) for part in _parts(time, signal, stretches)])


def window_steps(time: ArrayLike, signal: ArrayLike, stretches: Sequence[Stretch]) -> Floats:
    """Return the rms of the steps from sample to sample in each stretch (n_stretches,)."""
    return np.array([np.sqrt(np.mean(np.diff(part) ** 2)) for part in _parts(time, signal, stretches)])


def _parts(time: ArrayLike, signal: ArrayLike, stretches: Sequence[Stretch]) -> list[Floats]:
    t, y = series_of(time, signal)
    parts = [y[(t >= begin) & (t <= end)] for begin, end in stretches]
    for (begin, end), part in zip(stretches, parts, strict=True):
        if len(part) < 2:
            raise DataError(
                f"the stretch {begin:g} to {end:g} s holds {len(part)} samples of a series from {t[0]:g} to "
                f"{t[-1]:g} s; expected two or more; give other ends"
            )
    return parts

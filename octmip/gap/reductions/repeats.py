"""A rule that repeats: a row is one cycle, a reading the mean of the signal over one of n equal parts of the cycle.

The scatter of the rows is the noise of the readings, so a cycle should be longer than what correlates them.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError
from octmip.gap.reductions.windows import series_of

Floats = NDArray[np.float64]


def phase_means(time: ArrayLike, signal: ArrayLike, period: float, parts: int, start: float = 0.0) -> Floats:
    """Return the mean of a signal over each part of each whole cycle (n_cycles, parts).

    Parameters
    ----------
    time, signal
        (n,) samples, evenly spaced or not [s, any unit].
    period
        of the cycle [s].
    parts
        into which a cycle is cut; the first begins at `start`.
    start
        of the first cycle [s].

    Raises
    ------
    DataError
        no whole cycle, or a part of one without a sample.
    """
    t, y = series_of(time, signal)
    if not (period > 0.0 and parts > 0):
        raise DataError(f"the period is {period} and the parts are {parts}; expected both above 0")
    count = int(np.floor((t[-1] - start) / period + np.median(np.diff(t)) / period + 1e-6))
    part = np.floor((t - start) / period * parts + 1e-9).astype(int)
    used = (part >= 0) & (part < count * parts)
    number = np.bincount(part[used], minlength=max(count, 0) * parts)
    if count < 1 or (number == 0).any():
        raise DataError(
            f"the series of {len(t)} samples over {t[-1] - t[0]:g} s fills {count} cycles of {period:g} s in {parts} "
            f"parts with {int((number == 0).sum())} parts empty; expected a sample in each; take fewer parts"
        )
    return np.asarray(np.bincount(part[used], weights=y[used]) / number).reshape(count, parts)

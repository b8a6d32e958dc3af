"""The check that every rule begins with."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError

Floats = NDArray[np.float64]
EVEN = 1e-3
"""Share of a step by which the steps of an evenly spaced series may differ."""


def series_of(time: ArrayLike, signal: ArrayLike) -> tuple[Floats, Floats]:
    """Return times and signal as arrays (n,).

    Raises
    ------
    DataError
        other shapes, numbers that are not finite, times that do not rise.
    """
    t, y = np.asarray(time, dtype=np.float64), np.asarray(signal, dtype=np.float64)
    if t.shape != y.shape or t.ndim != 1 or len(t) < 2:
        raise DataError(
            f"a series has times of shape {t.shape} and a signal of {y.shape}; expected the same length, n >= 2"
        )
    if not (np.isfinite(t).all() and np.isfinite(y).all() and (np.diff(t) > 0.0).all()):
        raise DataError("a series holds numbers that are not finite, or times that do not rise; leave such samples out")
    return t, y


def even_series_of(time: ArrayLike, signal: ArrayLike) -> tuple[Floats, Floats, float]:
    """Return times, signal and sampling rate [1/s] of an evenly spaced series.

    Raises
    ------
    DataError
        as `series_of`, and steps that differ.
    """
    t, y = series_of(time, signal)
    steps = np.diff(t)
    if np.ptp(steps) > EVEN * float(np.median(steps)):
        raise DataError(
            f"the steps of the series differ, {steps.min():g} to {steps.max():g} s; expected evenly spaced samples; "
            "resample it to one rate"
        )
    return t, y, 1.0 / float(np.mean(steps))

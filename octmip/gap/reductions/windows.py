"""Means, spreads, rms of steps and powers in bands: one row of readings for a series.

A stretch is a pair (begin, end) [s], both included. The mean tells a steady level. The spread is the standard deviation
about the mean. The rms of steps, from one sample to the next, tells what is fast and does not see a slow wandering.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import welch

from octmip.errors import DataError

Floats = NDArray[np.float64]
Stretch = tuple[float, float]

EVEN = 1e-3
"""Share of a step by which the steps of an evenly spaced series may differ."""
FEWEST_LINES = 2
"""Lines of the spectrum that a band has to hold."""


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


def band_powers(
    time: ArrayLike, signal: ArrayLike, bands: Sequence[tuple[float, float]], window: float | None = None
) -> Floats:
    """Return the mean square of a signal in each band of frequency (n_bands,), in the signal's unit squared.

    The spectrum is Welch's (1967, IEEE Trans. Audio and Electroacoustics 15) over half-overlapping windows; bands that
    cover 0 to half the sampling rate sum to the variance, but for the mean that each window loses.

    Parameters
    ----------
    time, signal
        (n,) samples, evenly spaced [s, any unit].
    bands
        (low, high) of each band [Hz]; the lower end belongs to it.
    window
        length of a window [s]; None: an eighth of the series.

    Raises
    ------
    DataError
        uneven samples, or a band that holds fewer than two lines of the spectrum.
    """
    _, y, rate = even_series_of(time, signal)
    length = min(len(y), max(16, round(window * rate) if window else len(y) // 8))
    frequency, density = welch(y, rate, nperseg=length)
    step = float(frequency[1])
    found = []
    for low, high in bands:
        inside = (frequency >= low) & (frequency < high)
        if int(inside.sum()) < FEWEST_LINES:
            raise DataError(
                f"the band {low:g} to {high:g} Hz holds {int(inside.sum())} lines of a spectrum with a line each "
                f"{step:.3g} Hz up to {rate / 2:g} Hz; expected two or more; give a wider band or longer windows"
            )
        found.append(float(density[inside].sum()) * step)
    return np.array(found)

"""Rules that repeat: each repeat within a series is a row of readings.

* ``phase_means``: a row is one cycle, a reading the mean of the signal over one of n equal parts of the cycle.
* ``modes``: a row is one block, the readings are frequency and damping ratio of peaks of the spectrum.

The scatter of the rows is the noise of the readings, so blocks should be longer than what correlates them: a cycle is,
as a rule, and a block of some hundred periods of a lightly damped mode.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import find_peaks, peak_widths, welch

from octmip.errors import DataError
from octmip.gap.reductions.windows import even_series_of, series_of

Floats = NDArray[np.float64]

HALF_POWER = 0.5
"""Share of a peak's power at which its width is measured."""


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


def modes(time: ArrayLike, signal: ArrayLike, n_modes: int, blocks: int, windows: int = 8) -> Floats:
    """Return frequencies [Hz] and damping ratios [-] of the highest peaks in each block (blocks, 2 n_modes).

    The spectrum of a block is Welch's over so many overlapping windows (Welch (1967), IEEE Trans. Audio and
    Electroacoustics 15). Its `n_modes` most prominent peaks in decibels, in ascending order, are the modes; a parabola
    through the logarithms of a peak's three highest lines refines the frequency, and the damping ratio is half the
    relative width at half power, so it is never less than the window's own width: lightly damped modes need long
    windows.

    Raises
    ------
    DataError
        samples that are not evenly spaced, blocks too short, or fewer peaks than modes.
    """
    _, y, rate = even_series_of(time, signal)
    return np.array([_modes(part, rate, n_modes, windows) for part in np.array_split(y, max(blocks, 1))])


def _modes(y: Floats, rate: float, n_modes: int, windows: int) -> Floats:
    length = int(2 * len(y) / (windows + 1))
    if length < 16:
        raise DataError(f"a block of {len(y)} samples is too short for {windows} windows; take fewer blocks or windows")
    frequency, power = welch(y - y.mean(), rate, nperseg=length)
    peaks, found = find_peaks(10.0 * np.log10(np.maximum(power, 1e-300)), prominence=3.0)
    if len(peaks) < n_modes:
        raise DataError(
            f"the spectrum has {len(peaks)} peaks; expected {n_modes} modes; give longer blocks or fewer modes"
        )
    best = np.sort(peaks[np.argsort(-found["prominences"], kind="stable")[:n_modes]])
    whole = (power[best], np.zeros_like(best), np.full_like(best, len(power) - 1))  # widths at half of the peak itself
    width = peak_widths(power, best, HALF_POWER, prominence_data=whole)[0]
    logs = np.log(np.maximum(power[best + np.array([[-1], [0], [1]])], 1e-300))
    bend = logs[0] - 2.0 * logs[1] + logs[2]
    shift = np.where(bend < 0.0, 0.5 * (logs[0] - logs[2]) / np.where(bend < 0.0, bend, -1.0), 0.0)
    own = frequency[1] * (best + shift)
    return np.concatenate([own, 0.5 * width * frequency[1] / own])

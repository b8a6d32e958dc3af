"""Rules that repeat: each repeat within a series is a row of readings.

* ``phase_means``: a row is one cycle, a reading the mean of the signal over one of n equal parts of the cycle.
* ``amplitudes``: a row is one block, a reading the amplitude at one frequency, by least squares beside a mean.
* ``modes``: a row is one block, the readings are frequency and damping ratio of peaks of the spectrum.

The scatter of the rows is the noise of the readings, so blocks should be longer than what correlates them: a cycle is,
as a rule, and a block of some hundred periods of a lightly damped mode.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import find_peaks, welch

from octmip.errors import DataError
from octmip.gap.reductions.series import series_of

Floats = NDArray[np.float64]

RANDOM_OVERLAP = 0.5
"""Share by which the windows of a spectrum overlap."""
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


def amplitudes(time: ArrayLike, signal: ArrayLike, frequencies: Sequence[float], blocks: int) -> Floats:
    """Return the amplitude of a signal at given frequencies [Hz] in each block of it (blocks, n_frequencies).

    Raises
    ------
    DataError
        a block shorter than a period of the lowest frequency, or a frequency beyond half the sampling rate.
    """
    t, y = series_of(time, signal)
    length, rate = (t[-1] - t[0]) / max(blocks, 1), 1.0 / float(np.median(np.diff(t)))
    wrong = [f for f in frequencies if f * length < 1.0 or f > 0.5 * rate]
    if blocks < 1 or wrong or not frequencies:
        raise DataError(
            f"{blocks} blocks of {length:g} s at {rate:g} samples/s cannot show {wrong[:1] or 'no frequency'} Hz; "
            f"expected {1 / length:.3g} to {0.5 * rate:.3g} Hz; take fewer blocks or another frequency"
        )
    parts = np.array_split(np.arange(len(t)), blocks)
    return np.array([_amplitudes(t[part], y[part], frequencies) for part in parts])


def _amplitudes(t: Floats, y: Floats, frequencies: Sequence[float]) -> Floats:
    angles = 2.0 * np.pi * np.outer(t, frequencies)
    columns = np.column_stack([np.cos(angles), np.sin(angles), np.ones(len(t))])
    found = np.linalg.lstsq(columns, y, rcond=None)[0]
    n = len(frequencies)
    return np.asarray(np.hypot(found[:n], found[n : 2 * n]))


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
    t, y = series_of(time, signal)
    steps = np.diff(t)
    if np.ptp(steps) > 1e-3 * float(np.median(steps)):
        raise DataError("modes need evenly spaced samples; resample the series to one rate")
    rate = 1.0 / float(np.mean(steps))
    return np.array([_modes(part, rate, n_modes, windows) for part in np.array_split(y, max(blocks, 1))])


def _modes(y: Floats, rate: float, n_modes: int, windows: int) -> Floats:
    length = int(2 * len(y) / (windows + 1))
    if length < 16:
        raise DataError(f"a block of {len(y)} samples is too short for {windows} windows; take fewer blocks or windows")
    frequency, power = welch(y - y.mean(), rate, nperseg=length, noverlap=int(RANDOM_OVERLAP * length))
    level = 10.0 * np.log10(np.maximum(power, 1e-300))
    peaks, found = find_peaks(level, prominence=3.0)
    if len(peaks) < n_modes:
        raise DataError(
            f"the spectrum has {len(peaks)} peaks; expected {n_modes} modes; give longer blocks or fewer modes"
        )
    best = np.sort(peaks[np.argsort(-found["prominences"], kind="stable")[:n_modes]])
    pairs = [_peak(frequency, power, int(k)) for k in best]
    return np.array([*(f for f, _ in pairs), *(damping for _, damping in pairs)])


def _peak(frequency: Floats, power: Floats, k: int) -> tuple[float, float]:
    """Return frequency and damping ratio of the peak at line k."""
    logs = np.log(np.maximum(power[k - 1 : k + 2], 1e-300))
    bend = logs[0] - 2.0 * logs[1] + logs[2]
    shift = 0.5 * (logs[0] - logs[2]) / bend if bend < 0.0 else 0.0
    own = float(frequency[k] + shift * (frequency[1] - frequency[0]))
    low, high = _crossing(frequency, power, k, -1), _crossing(frequency, power, k, 1)
    return own, max(0.0, (high - low) / (2.0 * own))


def _crossing(frequency: Floats, power: Floats, k: int, way: int) -> float:
    """Return where the power falls to half of the peak's, up or down in frequency."""
    least, here = HALF_POWER * power[k], k
    while 0 < here < len(power) - 1 and power[here] > least:
        here += way
    inner, outer = power[here - way], power[here]
    share = (inner - least) / (inner - outer) if inner > outer else 1.0
    return float(frequency[here - way] + way * min(1.0, share) * (frequency[1] - frequency[0]))

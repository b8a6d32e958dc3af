"""Peaks and levels of a channel: what a block of time shows of a vibration, with spread and covariance.

A window is cut into blocks of equal length, because the largest of more samples is larger. Each block gives one value:
its largest or smallest sample, or the level in a band of frequencies, the root of the power between them,

    level^2 = integral of S(f) df from low to high

with the density S of `scipy.signal.welch`. How the blocks differ is the covariance of their mean. Price: a level is
1 / (8 B T) of it too low in a block of T seconds and a band of B Hz.

Source: Bendat & Piersol (2010), section 8.5.1.
"""

from collections.abc import Sequence

import numpy as np
import scipy.integrate
import scipy.signal

from octmip.errors import DataError
from octmip.input.messages import shown
from octmip.recordings.modes import stretches
from octmip.recordings.recording import Channel, Floats
from octmip.recordings.windows import Window

How = str | tuple[float, float]
"""Which value: "max", "min", or a band [Hz]."""
LINES = 16
"""Lines of the spectrum in a band."""


def how_of(text: str) -> How:
    """Return which value a text names: max, min, or LOW:HIGH [Hz].

    Raises
    ------
    DataError
        it is none.

    Examples
    --------
    >>> how_of("10:20")
    (10.0, 20.0)
    """
    low, _, high = text.partition(":")
    try:
        return text if text in ("max", "min") else (float(low), float(high))
    except ValueError as error:
        raise DataError(f"level {shown(text)}; expected max, min, or LOW:HIGH in Hz; write it so") from error


def levels_of(channel: Channel, how: How, edges: Floats) -> Floats:
    """Return the peak or level (n_blocks,) of a channel in each block between edges (n_blocks + 1,) [s].

    It is in the channel's unit, NaN of a block with a gap or an invalid sample.

    Raises
    ------
    DataError
        a band that the channel's rate or the length of a block does not bear, or fewer than half of the blocks whole.

    Examples
    --------
    >>> time = np.arange(0.0, 80.0, 0.01)
    >>> wave = Channel("a", "g", time, 2.0 * np.sin(2.0 * np.pi * 15.0 * time))
    >>> edges = np.array([0.0, 40.0, 80.0])
    >>> levels_of(wave, (10.0, 20.0), edges).round(3).tolist(), levels_of(wave, "max", edges).round(3).tolist()
    ([1.414, 1.414], [2.0, 2.0])
    """
    length = float(edges[1] - edges[0])
    if isinstance(how, tuple):
        low, high = how
        if not low < high:
            raise DataError(f"a band from {low:g} to {high:g} Hz; expected its lower end first; swap them")
        if not (low >= 0.0 and high <= 0.5 / channel.step and length * (high - low) >= LINES):
            raise DataError(
                f"a band from {low:g} to {high:g} Hz in blocks of {length:.4g} s of channel {channel.name}; expected "
                f"one below {0.5 / channel.step:.4g} Hz and {LINES / length:.3g} Hz wide at least; name another, or "
                "longer windows"
            )
    found = [_level(part[:, 0], rate, how) if len(part) else np.nan for part, rate in stretches([channel], edges)]
    n_whole = int(np.isfinite(found).sum())
    if n_whole < max(2, len(found) / 2):
        raise DataError(
            f"{n_whole} of {len(found)} blocks of {length:.4g} s of channel {channel.name} have no gap and no invalid "
            "sample; expected half of them; give other windows"
        )
    return np.array(found)


def _level(samples: Floats, rate: float, how: How) -> float:
    if isinstance(how, str):
        return float(samples.max() if how == "max" else samples.min())
    low, high = how
    size = min(len(samples), int(np.ceil(LINES * rate / (high - low))))
    frequencies, density = scipy.signal.welch(samples, rate, nperseg=size)
    inside = np.concatenate([[low], frequencies[(frequencies > low) & (frequencies < high)], [high]])
    return float(np.sqrt(scipy.integrate.trapezoid(np.interp(inside, frequencies, density), inside)))


def equal_blocks(window: Window, length: float) -> Floats:
    """Return the edges of as many blocks of one length [s] as a window holds."""
    return np.asarray(window.start + length * np.arange(int((window.end - window.start) / length * (1 + 1e-9)) + 1))


def words_of(levels: Sequence[tuple[str, How]]) -> str:
    """Return what a note says of readings that are levels."""
    named = (f"{name} {how}" if isinstance(how, str) else f"{name} {how[0]:g} to {how[1]:g} Hz" for name, how in levels)
    return ", ".join(named)

"""Power of a signal in bands of frequency: one row of readings for a series."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import welch

from octmip.errors import DataError
from octmip.gap.reductions.series import Floats, even_series_of

FEWEST_LINES = 2
"""Lines of the spectrum that a band has to hold."""


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

"""Frequencies and dampings of a free decay, with their covariance.

    y(t) = sum_j e^(-d_j t) (a_j cos w_j t + b_j sin w_j t) + sum_h (p_h cos w_h t + q_h sin w_h t) + zero(t) + noise

d_j and w_j = 2 pi f_j are found by least squares; amplitudes, hum and zero are projected out. Source: Golub and Pereyra
(1973), SIAM J. Numer. Anal. 10 (variable projection). The zero is a polynomial. A mode that beats with another, which
is not asked for, needs a stretch longer than the beat: the covariance does not know of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

Floats = NDArray[np.float64]

LINES = 1 << 17
"""Points of the padded spectrum in which a peak is looked for."""
FIRST_DAMPING = 1.0
"""Start of the search for a decay [1/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Decay:
    """Modes of one free decay.

    Attributes
    ----------
    frequencies
        (n_modes,) [Hz].
    dampings
        (n_modes,) decay of the amplitude [1/s].
    amplitudes
        (n_modes,) at the first sample, in the signal's unit.
    covariance
        (2 n_modes, 2 n_modes) of frequencies, then dampings, grown by how alike neighbouring residuals are.
    residual
        standard deviation of what is left, in the signal's unit.
    """

    frequencies: Floats
    dampings: Floats
    amplitudes: Floats
    covariance: Floats
    residual: float

    @property
    def frequency_sd(self) -> Floats:
        """Standard deviation of each frequency [Hz]."""
        return np.sqrt(np.diag(self.covariance)[: len(self.frequencies)])


def decay_of(
    time: ArrayLike,
    signal: ArrayLike,
    bands: Sequence[tuple[float, float]],
    hum: Sequence[float] = (),
    zero_degree: int = 1,
) -> Decay:
    """Return the modes of a free decay, one in each band.

    Parameters
    ----------
    time, signal
        (n,) samples, evenly spaced [s, any unit].
    bands
        (low, high) within which the highest peak of the spectrum is a mode [Hz].
    hum
        frequencies that belong to the measuring chain [Hz].
    zero_degree
        of the polynomial that the zero of the chain follows.
    """
    t, y = np.asarray(time, dtype=np.float64), np.asarray(signal, dtype=np.float64)
    rate = (len(t) - 1) / float(t[-1] - t[0])
    unknowns = 4 * len(bands) + 2 * len(hum) + zero_degree + 1
    at, n = t - t[0], len(bands)
    chain = [(at / at[-1]) ** power for power in range(zero_degree + 1)]
    chain += [wave(2.0 * np.pi * f * at) for f in hum for wave in (np.cos, np.sin)]
    basis = np.linalg.qr(np.column_stack(chain))[0]
    rest = y - basis @ (basis.T @ y)

    def columns(sought: Floats) -> Floats:
        angle, decay = 2.0 * np.pi * np.outer(at, sought[:n]), np.exp(-np.outer(at, sought[n:]))
        waves = np.concatenate([decay * np.cos(angle), decay * np.sin(angle)], axis=1)
        return np.asarray(waves - basis @ (basis.T @ waves))

    def left(sought: Floats) -> Floats:
        q = np.linalg.qr(columns(sought))[0]
        return np.asarray(rest - q @ (q.T @ rest))

    start = np.array([*(_peak(rest, rate, low, high) for low, high in bands), *[FIRST_DAMPING] * n])
    found = least_squares(left, start, x_scale=np.repeat([0.1, 1.0], n))
    jacobian = np.asarray(found.jac)
    variance = float(found.fun @ found.fun) / max(1, len(y) - unknowns)
    covariance = _grown(found.fun) * variance * np.linalg.pinv(jacobian.T @ jacobian)
    a = np.linalg.lstsq(columns(found.x), rest, rcond=None)[0]
    return Decay(found.x[:n], found.x[n:], np.hypot(a[:n], a[n:]), covariance, float(variance**0.5))


def _peak(y: Floats, rate: float, low: float, high: float) -> float:
    """Return the frequency of the highest line of the windowed, padded spectrum within a band [Hz]."""
    n = max(LINES, len(y))
    frequency, power = np.fft.rfftfreq(n, 1.0 / rate), np.abs(np.fft.rfft(y * np.hanning(len(y)), n))
    inside = np.flatnonzero((frequency >= low) & (frequency <= high))
    return float(frequency[inside[int(power[inside].argmax())]])


def _grown(left: Floats) -> float:
    """Return by how much the variance of a fit grows for residuals that are alike from sample to sample (AR(1))."""
    alike = float(left[1:] @ left[:-1]) / max(float(left @ left), 1e-300)
    alike = min(max(alike, 0.0), 0.99)
    return (1.0 + alike) / (1.0 - alike)

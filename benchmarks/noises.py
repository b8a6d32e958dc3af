"""Noise of a whole campaign by kind, each of variance 1000 microstrain squared or near it."""

from collections.abc import Callable

import numpy as np

from femlib.arrays import FloatArray

VARIANCE = 1000.0
"""[microstrain^2]"""
OUTLIERS = 0.02
"""Share of readings that lie off, always to the same side."""
DWELL = 40.0
"""Readings between steps up and down, in the mean."""

Scatter = Callable[[np.random.Generator, FloatArray, int], FloatArray]
"""From the load factors of the readings (n,) and a number of gauges to noise (n, n_gauges)."""


def white(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    """Return white noise."""
    return np.asarray(np.sqrt(VARIANCE) * rng.standard_normal((len(loads), n)))


def serial(rho: float) -> Scatter:
    """Return AR(1) noise in time, of each gauge by itself."""

    def draw(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
        noise = white(rng, loads, n)
        for k in range(1, len(noise)):
            noise[k] = rho * noise[k - 1] + np.sqrt(1.0 - rho**2) * noise[k]
        return noise

    return draw


def walk(step: float) -> Scatter:
    """Return white noise with a random walk of each gauge, of this standard deviation of a step [microstrain]."""

    def draw(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
        return white(rng, loads, n) + np.cumsum(step * rng.standard_normal((len(loads), n)), axis=0)

    return draw


def outliers(far: float) -> Scatter:
    """Return white noise of which `OUTLIERS` lie so far off [microstrain], always to the same side."""

    def draw(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
        return white(rng, loads, n) + far * (rng.random((len(loads), n)) < OUTLIERS)

    return draw


def steps(height: float) -> Scatter:
    """Return white noise with steps of this height up and down [microstrain], of each gauge by itself."""

    def draw(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
        turns = rng.random((len(loads), n)) < 1.0 / DWELL
        return white(rng, loads, n) + height * (-1.0) ** (np.cumsum(turns, axis=0) + rng.integers(2, size=n))

    return draw


def heavy(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    """Return white noise with the tails of Student's t with 5 degrees of freedom."""
    return np.asarray(rng.standard_t(5, (len(loads), n)) * np.sqrt(VARIANCE * 3 / 5))


def heteroscedastic(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    """Return white noise whose variance grows with the load."""
    return np.asarray(white(rng, loads, n) * np.sqrt(0.5 + loads / 3.0)[:, None])

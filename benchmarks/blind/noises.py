"""Noise of a whole campaign: ten kinds beside white noise, each of variance 1000 microstrain squared or near it."""

from collections.abc import Callable, Mapping

import numpy as np

from femlib.arrays import FloatArray

VARIANCE = 1000.0
WALK = 0.7
"""Standard deviation of a random walk's step from reading to reading [microstrain]."""
SHARED = 0.5
"""Share of the variance that all gauges have in common."""
OUTLIERS, FAR = 0.02, 300.0
"""Share of readings that lie off, always to the same side, and how far [microstrain]."""
JUMP, DWELL = 15.0, 40.0
"""Height of steps up and down [microstrain], and readings between them."""

Scatter = Callable[[np.random.Generator, FloatArray, int], FloatArray]
"""From the load factors of the readings (n,) and a number of gauges to noise (n, n_gauges)."""


def _white(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    return np.asarray(np.sqrt(VARIANCE) * rng.standard_normal((len(loads), n)))


def _serial(rho: float) -> Scatter:
    def draw(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
        noise = _white(rng, loads, n)
        for k in range(1, len(noise)):
            noise[k] = rho * noise[k - 1] + np.sqrt(1.0 - rho**2) * noise[k]
        return noise

    return draw


def _common_mode(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    shared = np.sqrt(SHARED) * _white(rng, loads, 1)
    return np.asarray(np.sqrt(1.0 - SHARED) * _white(rng, loads, n) + shared)


def _random_walk(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    return _white(rng, loads, n) + np.cumsum(WALK * rng.standard_normal((len(loads), n)), axis=0)


def _outliers(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    return _white(rng, loads, n) + FAR * (rng.random((len(loads), n)) < OUTLIERS)


def _steps(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    turns = rng.random((len(loads), n)) < 1.0 / DWELL
    return _white(rng, loads, n) + JUMP * (-1.0) ** (np.cumsum(turns, axis=0) + rng.integers(2, size=n))


def _heavy(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    return np.asarray(rng.standard_t(5, (len(loads), n)) * np.sqrt(VARIANCE * 3 / 5))


def _heteroscedastic(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    return np.asarray(_white(rng, loads, n) * np.sqrt(0.5 + loads / 3.0)[:, None])


NOISES: Mapping[str, Scatter] = {
    "white": _white,
    "AR(1) 0.3": _serial(0.3),
    "AR(1) 0.5": _serial(0.5),
    "AR(1) 0.7": _serial(0.7),
    "AR(1) 0.85": _serial(0.85),
    "common mode": _common_mode,
    "random walk": _random_walk,
    "one-sided outliers": _outliers,
    "steps": _steps,
    "heavy": _heavy,
    "heteroscedastic": _heteroscedastic,
    "quantised": _white,
}
"""By name; "quantised" is white noise that the recorder rounds."""
GROWN: Mapping[str, float] = {f"AR(1) {rho:g}": (1.0 + rho) / (1.0 - rho) for rho in (0.3, 0.5, 0.7, 0.85)}
"""Variance of a mean of many readings over that of white noise, where it is not one."""

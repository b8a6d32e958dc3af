"""Noise of the sealed cases: ten kinds beside white noise, each of variance 1000 microstrain squared or near it."""

from collections.abc import Mapping

import numpy as np

from benchmarks.noises import Scatter, heavy, heteroscedastic, outliers, serial, steps, walk, white
from femlib.arrays import FloatArray

WALK = 0.7
"""Standard deviation of a random walk's step from reading to reading [microstrain]."""
SHARED = 0.5
"""Share of the variance that all gauges have in common."""
FAR = 300.0
"""How far outliers lie off [microstrain]."""
JUMP = 15.0
"""Height of steps up and down [microstrain]."""


def _common_mode(rng: np.random.Generator, loads: FloatArray, n: int) -> FloatArray:
    shared = np.sqrt(SHARED) * white(rng, loads, 1)
    return np.asarray(np.sqrt(1.0 - SHARED) * white(rng, loads, n) + shared)


NOISES: Mapping[str, Scatter] = {
    "white": white,
    "AR(1) 0.3": serial(0.3),
    "AR(1) 0.5": serial(0.5),
    "AR(1) 0.7": serial(0.7),
    "AR(1) 0.85": serial(0.85),
    "common mode": _common_mode,
    "random walk": walk(WALK),
    "one-sided outliers": outliers(FAR),
    "steps": steps(JUMP),
    "heavy": heavy,
    "heteroscedastic": heteroscedastic,
    "quantised": white,
}
"""By name; "quantised" is white noise that the recorder rounds."""
GROWN: Mapping[str, float] = {f"AR(1) {rho:g}": (1.0 + rho) / (1.0 - rho) for rho in (0.3, 0.5, 0.7, 0.85)}
"""Variance of a mean of many readings over that of white noise, where it is not one."""

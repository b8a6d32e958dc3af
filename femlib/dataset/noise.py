"""Noise of strain readings: white, coloured, biased; several models add up.

Readings come in runs: the samples of one state under one load, taken one after the other. White noise is
independent in every number. Coloured noise is a stationary first-order process along a run,

    e_1 = s z_1,   e_k = r e_k-1 + s sqrt(1 - r^2) z_k,   z_k = sqrt(g) (common to all gauges) + sqrt(1 - g) (own),

with variance s^2, correlation r^|j-k| between readings and g between gauges. A bias is an offset of each gauge, the
same in every reading. What is a gauge's own is drawn by its name.

Source: G. E. P. Box, G. M. Jenkins, G. C. Reinsel, Time Series Analysis (2008), section 3.2.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from femlib.arrays import FloatArray
from femlib.dataset.gauge_draws import GaugeDraws
from femlib.errors import InputError, is_number


@runtime_checkable
class Noise(Protocol):
    """Errors that are added to clean readings."""

    def draw(self, n_runs: int, n_readings: int, offsets: FloatArray, draws: GaugeDraws) -> FloatArray:
        """Return errors (n_runs, n_readings, n_gauges) [microstrain]; `offsets` (n_gauges,) came from `fix`."""

    def fix(self, draws: GaugeDraws) -> FloatArray:
        """Return the offsets of the gauges (n_gauges,) [microstrain], drawn once for all readings."""


@dataclass(frozen=True, slots=True)
class WhiteNoise:
    """Independent Gaussian errors.

    Attributes
    ----------
    standard_deviation : float
        Of a reading at its load factor, before any division by it [microstrain]. The study's is sqrt(1000) = 31.6.

    Raises
    ------
    InputError
        If it is negative or not finite.
    """

    standard_deviation: float

    def __post_init__(self) -> None:
        _check_deviation("white noise standard_deviation", self.standard_deviation)

    def draw(self, n_runs: int, n_readings: int, offsets: FloatArray, draws: GaugeDraws) -> FloatArray:
        """Return errors (n_runs, n_readings, n_gauges) [microstrain]."""
        return draws.own(self.standard_deviation, (n_runs, n_readings))

    def fix(self, draws: GaugeDraws) -> FloatArray:
        """Return zeros (n_gauges,): nothing stays."""
        return np.zeros(len(draws))


@dataclass(frozen=True, slots=True)
class ColouredNoise:
    """Gaussian errors that neighbours in time, or gauges, share.

    Attributes
    ----------
    standard_deviation : float
        Of a reading at its load factor [microstrain].
    between_readings : float
        Correlation of one reading's error with the next one's of the same run, in [0, 1).
    between_gauges : float
        Correlation of the errors of two gauges in one reading, in [0, 1).

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    standard_deviation: float
    between_readings: float = 0.0
    between_gauges: float = 0.0

    def __post_init__(self) -> None:
        _check_deviation("coloured noise standard_deviation", self.standard_deviation)
        for name in ("between_readings", "between_gauges"):
            value = getattr(self, name)
            if not is_number(value) or not 0.0 <= value < 1.0:
                raise InputError(
                    f"coloured noise {name} is {value!r}; expected a correlation from 0 to below 1; 1 would be a Bias"
                )

    def draw(self, n_runs: int, n_readings: int, offsets: FloatArray, draws: GaugeDraws) -> FloatArray:
        """Return errors (n_runs, n_readings, n_gauges) [microstrain]."""
        own = draws.own(np.sqrt(1.0 - self.between_gauges), (n_runs, n_readings))
        errors = own + draws.shared.normal(0.0, np.sqrt(self.between_gauges), (n_runs, n_readings, 1))
        keep = self.between_readings
        errors[:, 1:] *= np.sqrt(1.0 - keep**2)
        for k in range(1, n_readings if keep else 0):
            errors[:, k] += keep * errors[:, k - 1]
        return np.asarray(self.standard_deviation * errors)

    def fix(self, draws: GaugeDraws) -> FloatArray:
        """Return zeros (n_gauges,): nothing stays."""
        return np.zeros(len(draws))


@dataclass(frozen=True, slots=True)
class Bias:
    """An offset of each gauge that stays the same in every reading, whatever the load.

    Attributes
    ----------
    offset : float
        Common to all gauges [microstrain].
    spread : float
        Standard deviation of each gauge's own offset about it, drawn once for a dataset [microstrain].

    Raises
    ------
    InputError
        If a number is not finite or the spread is negative.
    """

    offset: float = 0.0
    spread: float = 0.0

    def __post_init__(self) -> None:
        _check_deviation("bias spread", self.spread)
        if not is_number(self.offset):
            raise InputError(f"bias offset is {self.offset!r}; expected a finite number of microstrain; correct it")

    def draw(self, n_runs: int, n_readings: int, offsets: FloatArray, draws: GaugeDraws) -> FloatArray:
        """Return the offsets as errors (1, 1, n_gauges) [microstrain]."""
        return offsets[None, None, :]

    def fix(self, draws: GaugeDraws) -> FloatArray:
        """Return the offsets (n_gauges,) [microstrain]."""
        return self.offset + draws.own(self.spread)


def _check_deviation(name: str, value: float) -> None:
    if not is_number(value) or value < 0.0:
        raise InputError(f"{name} is {value!r}; expected 0 or more microstrain; 0 is no noise")

"""A failed gauge: found at a stated false-alarm rate, and its reading replaced by what the others say.

**Detection** sets each gauge against the others.

A healthy reading at a state s of the library is x = m_s + e, e ~ N(0, diag(sd^2)), the states alike in probability.
Leave gauge i out: the others have the density p(x_-i), a mixture over the states, and gauge i given them p(x_i | x_-i).
If a failed gauge may read anything, alike over its range, the odds that gauge i has failed are in proportion to

    p(x_-i) / p(x) = 1 / p(x_i | x_-i),

so one number, surprise_i = -log(p(x_i | x_-i) sd_i), both raises the alarm and names the gauge. The alarm limit is the
quantile of the largest surprise over all gauges in readings drawn from the library: the rate holds for a whole reading.
Source: Bayes' rule; leave-one-out predictive densities: S. Geisser, Predictive Inference (1993), chapter 2.

**Imputation** is the conditional mean of a normal distribution. With mean m and covariance C of the training readings,
missing gauges a and those at hand b,

    x_a = m_a + C_ab C_bb^+ (x_b - m_b).

Source: T. W. Anderson, An Introduction to Multivariate Statistical Analysis (2003), theorem 2.5.1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, ProblemError

Floats = NDArray[np.float64]

CHUNK = 1_000_000
"""Numbers (readings x states x gauges) compared at a time: 8 MB."""
N_DRAWS = 40_000
"""Healthy readings that the limit is taken from: at a rate of 1 % its own standard error is 0.05 %."""


@dataclass(frozen=True, slots=True, eq=False)
class FaultDetector:
    """A test that finds the failed gauge in a reading.

    Attributes
    ----------
    means
        (n_states, n_gauges) readings of the library's states, in the unit of the readings.
    noise_sd
        (n_gauges,) standard deviation of one reading; one number: the same for all.
    gauges
        their names.
    rate
        probability that a healthy reading raises an alarm.
    n_averaged
        each reading given is the mean of so many at one state, so its noise is less.
    seed
        of the draws that the limit is taken from.
    limit
        surprise from which on there is an alarm.
    """

    means: Floats
    noise_sd: Floats
    gauges: tuple[str, ...]
    rate: float = 0.01
    n_averaged: int = 1
    seed: int = 0
    limit: float = field(init=False)

    def __post_init__(self) -> None:
        means = np.array(self.means, dtype=np.float64)
        sd = np.broadcast_to(np.asarray(self.noise_sd, dtype=np.float64), means.shape[-1:]).copy()
        if means.ndim != 2 or means.shape[1] != len(self.gauges) or len(self.gauges) < 2:
            raise ProblemError(
                f"means has shape {means.shape}; expected (n_states, {len(self.gauges)}), two gauges or "
                "more; give one column per gauge"
            )
        if not np.isfinite(means).all() or not (sd > 0).all() or not np.isfinite(sd).all():
            raise ProblemError(
                f"means holds {np.count_nonzero(~np.isfinite(means))} numbers that are not finite and the least "
                f"noise_sd is {sd.min()}; expected none, and more than 0; leave out a gauge without noise"
            )
        if not 0 < self.rate < 1 or self.n_averaged < 1:
            raise ProblemError(
                f"rate is {self.rate} and n_averaged {self.n_averaged}; expected a rate between 0 and 1, and 1 or more "
                "readings; correct them"
            )
        object.__setattr__(self, "means", means)
        object.__setattr__(self, "noise_sd", sd / np.sqrt(self.n_averaged))
        healthy = self.draw(N_DRAWS, np.random.default_rng(self.seed))
        largest = self.surprise(healthy).max(axis=1)
        object.__setattr__(self, "limit", float(np.quantile(largest, 1.0 - self.rate)))

    def draw(self, n: int, rng: np.random.Generator) -> Floats:
        """Return n healthy readings (n, n_gauges) of states drawn alike."""
        states = rng.integers(0, len(self.means), n)
        return np.asarray(self.means[states] + rng.normal(size=(n, len(self.gauges))) * self.noise_sd)

    def surprise(self, readings: Floats) -> Floats:
        """Return ``-log(p(x_i | x_-i) sd_i)`` of every gauge, (n, n_gauges); NaN where the reading is missing.

        Raises
        ------
        DataError
            the readings have another shape or hold an infinite number.
        """
        readings = np.asarray(readings, dtype=np.float64)
        if readings.ndim != 2 or readings.shape[1] != len(self.gauges) or np.isinf(readings).any():
            raise DataError(
                f"readings has shape {readings.shape} or an infinite entry; expected finite numbers "
                f"(n, {len(self.gauges)}), NaN where a reading is missing; correct them"
            )
        step = max(1, CHUNK // self.means.size)
        parts = [self._surprise(readings[k : k + step]) for k in range(0, len(readings), step)]
        return np.concatenate(parts) if parts else np.zeros(readings.shape)

    def _surprise(self, readings: Floats) -> Floats:
        z = (readings[:, None, :] - self.means) / self.noise_sd
        terms = np.where(np.isnan(z), 0.0, -0.5 * z**2 - 0.5 * np.log(2 * np.pi))
        whole = terms.sum(axis=2)
        without = _log_sum(whole[:, :, None] - terms)
        found = without - _log_sum(whole[:, :, None])
        return np.where(np.isnan(readings), np.nan, found)

    def is_alarm(self, readings: Floats) -> NDArray[np.bool_]:
        """Return for each reading (n, n_gauges) whether some gauge does not fit the others, shape (n,)."""
        return np.asarray(np.nanmax(self.surprise(readings), axis=1, initial=-np.inf) > self.limit)

    def named(self, readings: Floats) -> NDArray[np.int64]:
        """Return the index of the gauge that most probably has failed in each reading, -1 without an alarm, (n,)."""
        surprise = np.where(np.isnan(readings), -np.inf, self.surprise(readings))
        return np.where(surprise.max(axis=1) > self.limit, surprise.argmax(axis=1), -1)

    def without_failed(self, readings: Floats, most: int = 1) -> Floats:
        """Return the readings with the named gauge as NaN, again while there is an alarm, `most` times at most."""
        out = np.array(readings, dtype=np.float64)
        for _ in range(most):
            named = self.named(out)
            rows = np.flatnonzero(named >= 0)
            if len(rows) == 0:
                break
            out[rows, named[rows]] = np.nan
        return out


@dataclass(frozen=True, slots=True, eq=False)
class Imputation:
    """Mean (n_features,) and covariance (n_features, n_features) of training readings."""

    mean: Floats
    covariance: Floats

    @classmethod
    def fit(cls, features: Floats) -> "Imputation":
        """Return the imputation learnt from features (n_samples, n_features) without missing readings."""
        return cls(features.mean(axis=0, dtype=np.float64), np.atleast_2d(np.cov(features, rowvar=False)))

    def impute(self, features: Floats) -> Floats:
        """Return features (n, n_features) with every NaN replaced; a row without any reading becomes the mean.

        Raises
        ------
        DataError
            the features have another number of columns.
        """
        if features.ndim != 2 or features.shape[1] != len(self.mean):
            raise DataError(f"features has shape {features.shape}; expected (n, {len(self.mean)}); give every feature")
        out, is_missing = features.copy(), np.isnan(features)
        patterns, of_row = np.unique(is_missing, axis=0, return_inverse=True)
        for k, gone in enumerate(patterns):
            if not gone.any():
                continue
            rows = np.flatnonzero(of_row.ravel() == k)
            slope = self.covariance[np.ix_(gone, ~gone)] @ np.linalg.pinv(self.covariance[np.ix_(~gone, ~gone)])
            known = features[np.ix_(rows, ~gone)] - self.mean[~gone]
            out[np.ix_(rows, gone)] = self.mean[gone] + known @ slope.T
        return out


def power(detector: FaultDetector, biases: Sequence[float], n: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return power and share of alarms that name the right gauge, both (n_biases, n_gauges), for an added bias.

    Parameters
    ----------
    detector
        the detector.
    biases
        added to one gauge, in the unit of the readings.
    n
        readings drawn for each bias and gauge.
    """
    found, right = np.zeros((2, len(biases), len(detector.gauges)))
    for b, bias in enumerate(biases):
        for g in range(len(detector.gauges)):
            readings = detector.draw(n, rng)
            readings[:, g] += bias
            named = detector.named(readings)
            found[b, g] = (named >= 0).mean()
            right[b, g] = (named == g).sum() / max(1, (named >= 0).sum())
    return found, right


def _log_sum(logs: Floats) -> Floats:
    """Return log sum exp of finite numbers (n, n_states, m) over the states; scipy's takes three times as long."""
    top = logs.max(axis=1)
    return np.asarray(top + np.log(np.exp(logs - top[:, None, :]).sum(axis=1)))

"""Which tests' tension readings cannot be right: a mixture over the tests of a series, most of them sound.

Each feature y of a sound test is Student's t about the series' location m with scale s; of a wrong one it is, with
chance `BROKEN` for each feature, Cauchy about m with scale `WIDE` s. With the share of wrong tests pi,

    P(wrong | y) = pi prod_j [(1 - BROKEN) t_j + BROKEN c_j] / (that + (1 - pi) prod_j t_j),

m, s and pi are fitted by expectation-maximisation: each test enters by its probability of being sound, so several
wrong ones do not hide each other. It starts from the median, from the rig's lever, and from each test that has a few
alike; the start with the largest posterior counts, so that wrong tests may be the majority as long as they do not
agree with each other and with the physics. Readings that are wrong without any comparison (standing still, cut off,
a copy) do not enter. The physics is the prior of m: both ends act on one drum, so their gains
are equal (`SAME_DRUM`); a slack end reads about nothing, and little of the force is left (`SOUND`).
Source: Box, Tiao (1968), "A Bayesian approach to some outlier problems", Biometrika 55.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import gammaln

from benchmarks.real.damper.features import FEATURES, Shown, force_size, shown
from benchmarks.real.damper.series import Recording
from femlib.arrays import FloatArray

SCALES = np.array([0.025, 0.025, 0.012, 0.012, 0.012, 0.004, 0.004, 0.4, 0.008, 0.4, 0.4, 0.4])
"""Scale of each feature before any data: 2.5 % of a gain, 1.2 % of the level, .4 in log rms, one sample of delay."""
WEIGHT = 60.0
"""Tests that the prior of a scale counts for."""
FREEDOM = 20.0
BROKEN = 0.15
WIDE = 8.0
SHARE = (1.0, 4.0)
"""Beta prior of the share of wrong tests."""
SAME_DRUM = 0.06
"""Sd of the log of the ratio of the two gains of a sound series."""
LEVER = (2.0, 0.07, 60.0)
"""The rig's lever [kip/1000 lb], the sd of its log, and the log odds of this rig in these units against any other."""
SOUND: Mapping[str, tuple[float, float]] = {
    "zero": (0.0, 0.03),
    "slack_a": (0.0, 0.02),
    "slack_b": (0.0, 0.02),
    "drift_a": (0.0, 0.01),
    "drift_b": (0.0, 0.01),
    "unexplained": (-3.0, 0.7),
    "delay": (0.02, 0.025),
    "worst": (0.2, 0.3),
    "noise_a": (-8.0, 1.0),
    "noise_b": (-8.0, 1.0),
}
"""Mean and sd of where a sound series has its features."""
CUT = 0.03
FASTER = ("unexplained", "noise_a", "noise_b")
"""Features that grow with the frequency of a test."""
SLOPE = (0.0, 0.5, 1.0)
"""Least, usual and largest change of their logs over that of the frequency."""
GAIN_SLOPE = (-0.1, 0.0, 0.1)
"""The same for the log gain over that of the force."""
APART = 0.3
"""Difference of logs from which two tests show a slope."""
ROUNDS = 60
SETTLED = 1e-4
"""Move of the locations, in scales, below which expectation-maximisation has settled."""


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Location and scale (n_features,) of sound tests, probability of being wrong (n_tests,), log posterior."""

    location: FloatArray
    scale: FloatArray
    wrong: FloatArray
    score: float


def accused(tests: Sequence[Recording], found: Shown | None = None) -> FloatArray:
    """Return the probability (n_tests,) that the tension reading of each test of a series cannot be right.

    `found` are the features, taken from the tests if not given.
    """
    found = shown(tests) if found is None else found
    values = levelled(found.values, np.array([test.frequency for test in tests]), force_size(tests))
    wrong = np.array([certain(test, tests) for test in tests])
    for one, other in copies(tests):
        worse = one if found.values[one, 7] > found.values[other, 7] else other
        wrong[worse] = max(wrong[worse], 0.98)
    open_ones = np.flatnonzero(wrong == 0.0)
    if len(open_ones):
        wrong[open_ones] = best_fit(values[open_ones], found.spread[open_ones]).wrong
    return wrong


def levelled(values: FloatArray, frequency: FloatArray, force: FloatArray) -> FloatArray:
    """Return the features as at the median frequency and force, by the median slope over pairs of tests."""
    found = values.copy()
    for names, by, (low, usual, high) in ((FASTER, frequency, SLOPE), (("gain_a", "gain_b"), force, GAIN_SLOPE)):
        logs = np.log(by / np.median(by))
        apart = [(i, j) for i, j in combinations(range(len(logs)), 2) if abs(logs[i] - logs[j]) > APART]
        for column in (FEATURES.index(name) for name in names):
            slopes = np.array([(values[i, column] - values[j, column]) / (logs[i] - logs[j]) for i, j in apart])
            slopes = slopes[np.isfinite(slopes)]
            found[:, column] -= (float(np.clip(np.median(slopes), low, high)) if len(slopes) >= 3 else usual) * logs
    return found


def certain(test: Recording, tests: Sequence[Recording]) -> float:
    """Return the probability from what needs no comparison: standing still, cut off, silent in this test only."""
    worst = 0.0
    for end in (0, 1):
        gaps = np.isnan(test.tension[end]).mean()
        others = np.median([np.isnan(other.tension[end]).mean() for other in tests])
        still = gaps < 0.5 and (stands_still(test.tension[end]) or cut_off(test.tension[end]))
        if still or gaps > 0.05 > others:
            worst = 0.99
    return worst


def stands_still(reading: FloatArray) -> bool:
    """Return whether more than half of the readings repeat the one before exactly: no cell is that quiet."""
    reading = reading[np.isfinite(reading)]
    return bool((np.diff(reading) == 0.0).mean() > 0.5) if len(reading) > 1 else False


def cut_off(reading: FloatArray) -> bool:
    """Return whether a reading stays at its extreme on the tight side for more than `CUT` of the time."""
    reading = reading[np.isfinite(reading)]
    away = np.abs(reading - np.median(reading))
    extreme = reading[int(away.argmax())]
    return bool((np.abs(reading - extreme) <= 1e-4 * np.ptp(reading)).mean() > CUT)


def copies(tests: Sequence[Recording]) -> list[tuple[int, int]]:
    """Return the pairs of tests of which a tension cell made the same record to its noise."""
    pairs = []
    for i, j in combinations(range(len(tests)), 2):
        n = min(len(tests[i].time), len(tests[j].time))
        if any(same_record(tests[i].tension[end, :n], tests[j].tension[end, :n]) for end in (0, 1)):
            pairs.append((i, j))
    return pairs


def same_record(one: FloatArray, other: FloatArray) -> bool:
    """Return whether two records rise and fall alike, sample by sample, while the end is slack (so by noise alone)."""
    if not (np.isfinite(one).any() and np.isfinite(other).any()):
        return False
    quiet = (one < np.nanquantile(one, 0.4)) & (other < np.nanquantile(other, 0.4))
    both = np.diff(np.where(quiet, one, np.nan)), np.diff(np.where(quiet, other, np.nan))
    use = np.isfinite(both[0]) & np.isfinite(both[1])
    if use.sum() < 50 or min(np.std(row[use]) for row in both) == 0.0:
        return False
    return bool(np.corrcoef(both[0][use], both[1][use])[0, 1] > 0.999)


def best_fit(values: FloatArray, spread: FloatArray) -> Fitted:
    """Return the fit with the largest posterior over all starts."""
    told = [column[np.isfinite(column)] for column in values.T]
    middle = np.array([np.median(column) if len(column) else 0.0 for column in told])
    lever = np.array([np.log(LEVER[0])] * 2 + [SOUND[name][0] for name in FEATURES[2:]])
    starts = [middle, lever, *(np.where(np.isfinite(row), row, middle) for row in values)]
    return max((converged(values, spread, start) for start in starts), key=lambda fitted: fitted.score)


def converged(values: FloatArray, spread: FloatArray, location: FloatArray) -> Fitted:
    """Return the fit that expectation-maximisation reaches from a location."""
    scale, share = 3.0 * SCALES, 0.2
    wrong = np.full(len(values), 0.0)
    for _ in range(ROUNDS):
        sound, broken = densities(values, location, scale * spread)
        odds = np.log(share) - np.log1p(-share) + broken - sound
        wrong = 1.0 / (1.0 + np.exp(-np.clip(odds, -700, 700)))
        before = location
        location, scale = moved(values, spread, 1.0 - wrong, location, scale)
        share = (wrong.sum() + SHARE[0]) / (len(values) + sum(SHARE))
        if np.max(np.abs(location - before) / scale) < SETTLED:
            break
    sound, broken = densities(values, location, scale * spread)
    total = np.logaddexp(np.log1p(-share) + sound, np.log(share) + broken).sum()
    prior = (SHARE[0] - 1.0) * np.log(share) + (SHARE[1] - 1.0) * np.log1p(-share)
    return Fitted(location, scale, wrong, float(total + prior + physics(location) + scale_prior(scale)))


def densities(values: FloatArray, location: FloatArray, scale: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the log density of each test if sound and if wrong; a feature that is not there says nothing."""
    there = np.isfinite(values)
    z = (np.where(there, values, location) - location) / scale
    sound = student(z) - np.log(scale)
    wide = -np.log(np.pi * WIDE * scale) - np.log1p((z / WIDE) ** 2)
    broken = np.logaddexp(np.log1p(-BROKEN) + sound, np.log(BROKEN) + wide)
    return np.where(there, sound, 0.0).sum(axis=1), np.where(there, broken, 0.0).sum(axis=1)


def student(z: FloatArray) -> FloatArray:
    """Return the log density of Student's t of `FREEDOM` degrees, as `scipy.stats.t` at a tenth of its time."""
    half = (FREEDOM + 1.0) / 2.0
    return np.asarray(
        gammaln(half) - gammaln(FREEDOM / 2.0) - 0.5 * np.log(FREEDOM * np.pi) - half * np.log1p(z**2 / FREEDOM)
    )


def moved(
    values: FloatArray, spread: FloatArray, sound: FloatArray, location: FloatArray, scale: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return location and scale with each test weighed by its probability and, as Student's t asks, by its distance."""
    there = np.isfinite(values)
    filled = np.where(there, values, location)
    z = (filled - location) / (scale * spread)
    weight = there * sound[:, None] * (FREEDOM + 1.0) / (FREEDOM + z**2) / spread**2
    total = weight.sum(axis=0)
    new = np.where(total > 1e-6, (weight * filled).sum(axis=0) / np.maximum(total, 1e-6), location)
    squares = (weight * (filled - new) ** 2).sum(axis=0)
    count = (sound[:, None] * np.isfinite(values)).sum(axis=0)
    return new, np.sqrt((WEIGHT * SCALES**2 + squares) / (WEIGHT + count))


def physics(location: FloatArray) -> float:
    """Return the log prior of the location of sound tests."""
    gain_a, gain_b = location[:2].tolist()
    lever = ((gain_a + gain_b) / 2.0 - np.log(LEVER[0])) / LEVER[1]
    z = [(gain_b - gain_a) / SAME_DRUM, min(abs(lever), np.sqrt(2.0 * LEVER[2]))]
    z += [(location[FEATURES.index(name)] - mean) / sd for name, (mean, sd) in SOUND.items()]
    return float(-0.5 * np.sum(np.square(z)))


def scale_prior(scale: FloatArray) -> float:
    """Return the log prior of the scales: scaled inverse chi-squared with `WEIGHT` tests about `SCALES`."""
    return float((-WEIGHT * np.log(scale / SCALES) - 0.5 * WEIGHT * (SCALES / scale) ** 2).sum())

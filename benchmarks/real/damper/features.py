"""What a test shows of its tension cells, in numbers without unit that should be alike in all tests of a series.

| feature | meaning | a fault that moves it |
|---|---|---|
| gain_a, gain_b | log of the lever by each end, from the force balance | wrong scale, ends exchanged, dead cell |
| zero | force at no tension over lever and level | zero of one cell |
| slack_a, slack_b | reading at the end that is slack, over the level | zero of a cell, also of both alike |
| drift_a, drift_b | change of that from the first to the second half of the test | drifting zero |
| unexplained | log of the rms share of the force that the balance leaves | stuck, another test's reading, noise |
| worst | log of that in the worst eighth of the test over the median eighth | drop-outs, a cell that fails half-way |
| noise_a, noise_b | log of the scatter from sample to sample at the slack end, over the level | noise |
| delay | delay of the channel against the force [s] | time base |

The level is the series' median of the tension at the tight end.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.real.damper.balance import DELAYS, Balance, Channel, balance_of, balances, channel_width, followed
from benchmarks.real.damper.series import Recording
from femlib.arrays import FloatArray

FEATURES = (
    "gain_a", "gain_b", "zero", "slack_a", "slack_b", "drift_a", "drift_b", "unexplained", "delay", "worst", "noise_a",
    "noise_b",
)  # fmt: skip
FAR = -8.0
"""Log gain that stands for a gain of the wrong sign or of none: no sound cell has it."""
PARTS = 8
QUIET = 1e-4
"""Noise over the level below which cells are not told apart."""
WEAK = ("gain_a", "gain_b", "unexplained", "worst", "delay")
"""Features that a small force blurs."""
SMALL = 0.33
"""Share of the scale of such a feature that comes from errors that do not grow with the force."""
KEPT = 25.0
"""Scales of a slack level by which a nominal tension as large as the level may move it: a third of that tension."""
ONE_END = 2.0
"""Factor on all scales where one end was not recorded: half of the balance is then missing."""
TURNED = 0.1
"""Share of positive gains below which the whole series names its ends the other way round: no fault of a test."""


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """Features of a series, how much wider each may spread, the sign of the lever, and the tension level [lb].

    `values` and `spread` are (n_tests, n_features): a test whose force is small shows its gains less sharply.
    """

    values: FloatArray
    spread: FloatArray
    sign: float
    level: float


def shown(tests: Sequence[Recording]) -> Shown:
    """Return the features of the tests of a series."""
    width = channel_width(tests)
    level = tension_level(tests)
    channels = [Channel(own_delay(test, width), width) for test in tests]
    fits = [balance_of(test, channel) for test, channel in zip(tests, channels, strict=True)]
    gains = np.array([[one.gain_a, one.gain_b] for one in fits])
    told = gains[np.isfinite(gains)]
    sign = -1.0 if len(told) and np.mean(told > 0.0) < TURNED else 1.0
    lever = float(np.median(np.abs(told))) if len(told) else 1.0
    rows = []
    for test, channel, one in zip(tests, channels, fits, strict=True):
        slack, drift, noise = slack_levels(test, channel, sign)
        rows.append([
            *log_gain(np.array([one.gain_a, one.gain_b]) * sign), 1e3 * one.zero / lever / level, *(slack / level),
            *(drift / level), 0.5 * np.log(max(one.unexplained, 1e-9)), channel.delay, worst_part(test, channel, one),
            *np.log(noise / level + QUIET),
        ])  # fmt: skip
    return Shown(np.array(rows), spreads(tests, level), sign, level)


def spreads(tests: Sequence[Recording], level: float) -> FloatArray:
    """Return the factors on the scales (n_tests, n_features).

    Errors of a share of the level weigh on a small force; gains vary with the force; a slack end keeps some of what
    the band has at rest.
    """
    small = np.median(force_size(tests)) / force_size(tests)
    wider = np.ones((len(tests), len(FEATURES)))
    for name in WEAK:
        wider[:, FEATURES.index(name)] = np.hypot(1.0, SMALL * small) / np.hypot(1.0, SMALL)
    for name in ("gain_a", "gain_b"):
        wider[:, FEATURES.index(name)] = np.hypot(wider[:, FEATURES.index(name)], np.log(small))
    nominal = np.array([test.nominal for test in tests])
    if np.isfinite(nominal).all():
        kept = np.hypot(1.0, KEPT * np.abs(nominal - np.median(nominal)) / level)
        for name in ("zero", "slack_a", "slack_b"):
            wider[:, FEATURES.index(name)] = kept
    silent = [not np.isfinite(test.tension).any(axis=1).all() for test in tests]
    wider[silent] *= ONE_END
    return wider


def force_size(tests: Sequence[Recording]) -> FloatArray:
    """Return the size of the force of each test [kip], at least a thousandth of the median."""
    size = np.array([np.quantile(np.abs(test.force - np.median(test.force)), 0.9) for test in tests])
    return np.asarray(np.maximum(size, 1e-3 * float(np.median(size)) + 1e-12))


def tension_level(tests: Sequence[Recording]) -> float:
    """Return the median over tests and ends of the tension at the tight end [lb]."""
    ends = np.concatenate([test.tension for test in tests], axis=1)
    if not np.isfinite(ends).any():
        return 1.0
    tight = [np.nanquantile(end, 0.9) for test in tests for end in test.tension if np.isfinite(end).any()]
    return max(float(np.median(tight)), 1e-6)


def log_gain(gain: FloatArray) -> FloatArray:
    """Return the logarithm of gains, `FAR` for those that no cell has, NaN where there is no reading."""
    positive = np.where(gain > np.exp(FAR), gain, np.exp(FAR))
    return np.where(np.isfinite(gain), np.log(positive), np.nan)


def slack_levels(test: Recording, channel: Channel, sign: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return each end's median reading while it is slack [lb], its change over the test, and its noise."""
    force = sign * followed(test, channel.width, np.array([channel.delay]))[0]
    force = force - (np.quantile(force, 0.95) + np.quantile(force, 0.05)) / 2.0
    large = 0.7 * np.quantile(np.abs(force), 0.9)
    early = test.time < np.median(test.time)
    found = np.full((3, 2), np.nan)
    for end, slack in enumerate((force > large, force < -large)):
        halves = [test.tension[end, slack & part] for part in (early, ~early)]
        if min(np.isfinite(half).sum() for half in halves) >= 8:
            both = np.concatenate(halves)
            change = float(np.nanmedian(halves[1]) - np.nanmedian(halves[0]))
            steps = np.abs(np.diff(both))
            steps = steps[np.isfinite(steps)]
            found[:, end] = np.nanmedian(both), change, np.median(steps) if len(steps) else np.nan
    return found[0], found[1], found[2]


def worst_part(test: Recording, channel: Channel, fit: Balance) -> float:
    """Return the log of the rms that the balance leaves in the worst eighth of the test, over the median eighth."""
    ends = np.array([-fit.gain_a, fit.gain_b])
    told = np.isfinite(ends)
    if not told.all():
        return np.nan
    force = followed(test, channel.width, np.array([channel.delay]))[0]
    left = force - fit.zero - ends @ test.tension / 1e3
    moving = np.flatnonzero(np.isfinite(left) & (np.abs(test.velocity) > 0.1 * np.abs(test.velocity).max()))
    parts = np.array([np.mean(left[part] ** 2) for part in np.array_split(moving, PARTS) if len(part)])
    return float(0.5 * np.log(parts.max() / max(np.median(parts), 1e-30))) if len(parts) == PARTS else np.nan


def own_delay(test: Recording, width: float) -> float:
    """Return the delay at which the balance leaves least of this test [s]; 0 without readings."""
    left = balances(test, width, DELAYS)[:, 3]
    return float(DELAYS[int(np.nanargmin(left))]) if np.isfinite(left).any() else 0.0

"""The display of a reading: its step, and the error that the step leaves in the mean of repeats.

A display shows whole multiples of its step d. Repeats that scatter by s about one value are not rounded each in a way
of its own: where s is small beside d all of them show the same, and no number of repeats makes their mean better. Over
all values the rounding has the variance d^2 / 12, of which repeats show

    v - s^2 = d^2 / 12 - D,    D = d^2 / (2 pi^2) sum_k exp(-4 pi^2 k^2 (s / d)^2) / k^2,

and D stays in the mean of any number of them: d^2 / 12 where all repeats are equal, nothing from s = d / 2 on.

Source: B. Widrow, I. Kollar (2008), "Quantization Noise", chapters 4 and 6.
"""

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign

Floats = NDArray[np.float64]

ROUNDING = 1e-9
"""Share of the greatest reading that sums and products in floating point may be off a multiple of the step."""
FEWEST_LEVELS = 6
"""Different readings whose common divisor is the step, where no two repeats differ."""
PRINTED = 10.0
"""Steps of the printed digits in one step of a converter, beyond which the levels tell it from them."""


def steps_of(campaign: Campaign) -> Floats:
    """Return the step of each gauge's display (n_gauges,), in its unit; 0 where its readings have none.

    A gauge of few levels whose repeats never differ shows multiples of its step alone: its levels may all be multiples
    of more. There the step is that of the unit's gauges together, unless these scatter by more than that step: then the
    gauge has a coarser display than they, and the common divisor of its levels bounds it from above.
    """
    units = np.array([campaign.unit_of(name) for name in campaign.gauges])
    spreads, steps = campaign.spreads(), np.zeros(len(campaign.gauges))
    for unit in dict.fromkeys(units.tolist()):
        gauges = np.flatnonzero(units == unit)
        scatter = spreads[:, gauges][spreads[:, gauges] > 0.0]
        typical = float(np.median(scatter)) if scatter.size else 0.0
        every = levels_of(campaign.readings[:, gauges])
        together = step_of(every) if scatter.size or len(every) >= FEWEST_LEVELS else 0.0
        for k in gauges.tolist():
            levels = levels_of(campaign.readings[:, k])
            is_plain = (spreads[:, k] > 0.0).any() or len(levels) >= FEWEST_LEVELS
            steps[k] = step_of(levels) if is_plain or (len(levels) > 2 and 0.0 < together < typical) else together
    return steps


def levels_of(readings: Floats) -> Floats:
    """Return the different readings (n_levels,), ascending, of readings of any shape."""
    return np.unique(readings[np.isfinite(readings)])


def step_of(levels: Floats) -> float:
    """Return the step of which all ascending levels (n,) are whole multiples apart; 0 where there is none.

    Levels printed with digits finer than the step lie off it by one digit at most.
    """
    if len(levels) < 3:
        return 0.0
    slack = ROUNDING * float(np.abs(levels).max())
    divisor = _divisor(np.diff(levels), slack)
    coarse = float(np.diff(levels).min())
    if len(levels) < FEWEST_LEVELS or coarse < PRINTED * divisor:
        return divisor
    return _fitted(levels, coarse, max(1.1 * divisor, slack)) or divisor


def _divisor(gaps: Floats, slack: float) -> float:
    """Return the greatest number of which all gaps (n,) are multiples up to a slack; 0 where that is some slacks."""
    divisor = float(gaps.min())
    while divisor > 10.0 * slack:
        off = np.abs(gaps - np.round(gaps / divisor) * divisor)
        rest = off[off > slack]
        if not rest.size:
            return divisor
        gaps, divisor = np.append(rest, divisor), float(rest.min())
    return 0.0


def _fitted(levels: Floats, step: float, slack: float) -> float:
    """Return the step near to one of which all levels (n,) are multiples up to a slack apart, 0 where there is none."""
    numbers = np.concatenate([np.zeros(1), np.cumsum(np.round(np.diff(levels) / step))])
    step = float(levels[-1] - levels[0]) / float(numbers[-1])
    return step if bool((np.abs(levels - levels[0] - numbers * step) <= slack).all()) else 0.0


_RATIO = np.linspace(0.0, 1.5, 601)
"""s / d of the table."""
_ORDER = np.arange(1, 400)
_LEFT = (np.exp(-((2.0 * np.pi * np.outer(_RATIO, _ORDER)) ** 2)) / (2.0 * np.pi**2 * _ORDER**2)).sum(axis=1)
"""D / d^2 at each of them."""
_SEEN = _RATIO**2 + _LEFT[0] - _LEFT
"""v / d^2, what repeats show."""


def left_by(steps: Floats, seen: Floats) -> Floats:
    """Return the variance D (n,) that steps (n,) leave in means of any number of repeats, whose variance is seen (n,).

    It is exact for normal noise, averaged over where the values lie between two steps.
    """
    ratio = np.where(steps > 0.0, seen / np.where(steps > 0.0, steps, 1.0) ** 2, np.inf)
    return np.asarray(steps**2 * np.interp(ratio, _SEEN, _LEFT, right=0.0))

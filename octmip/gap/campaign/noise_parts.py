"""The parts of the noise: what single gauges have, and what gauges share.

Residuals in standard deviations are split into the directions v over the gauges whose variance stands out of what
independent gauges would give (a common mode, or one gauge that wanders), and the rest; the scores f_k have a spectrum
each, the rest has one:

    e_t = sum_k v_k f_kt + u_t.

Source: I. M. Johnstone (2001), "On the distribution of the largest eigenvalue in principal components analysis",
Annals of Statistics 29 (the greatest eigenvalue of independent gauges).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from octmip.gap.campaign.noise import NoisePart
from octmip.gap.campaign.spectrum import SHARED, SHORTEST, SINGLE, WHITE, Serial, coefficients, fit

Floats = NDArray[np.float64]

MOST_SHARED = 3
"""Directions that gauges share, at most."""
LOW = 4
"""Cosines of longest period, which say most of the variance of means."""
DIFFERENT = 1e-4
"""Chance that some gauge's slow noise exceeds the others' so far; below it the gauge has a spectrum of its own."""
OUTSTANDING = 5.0
"""Standard deviations by which a greatest eigenvalue exceeds that of independent gauges; 3.3 is met once in 1000."""
POSSIBLE = 0.05
"""Probability above which a walk that gauges share is carried from cell to cell."""
LEAST_SINGLE = 0.05
"""Share of a gauge's variance that the rest keeps, at least, when its spectrum is brought to unit variance."""


def parts_of(blocks: Sequence[Floats]) -> tuple[list[NoisePart], float, float]:
    """Return the parts of the noise, how many readings one independent one is worth, and the share of such gauges.

    `blocks` holds for each cell residuals (n_repeats, n_gauges) in standard deviations, missing ones 0. The gauges' own
    part comes first, its walk left in however improbable (see `noise.sizes`); then gauges that differ, then what
    gauges share.
    """
    first = _own_serial(blocks)
    inflation = _inflation(first, [len(block) for block in blocks])
    single = np.eye(blocks[0].shape[1])[:, _different(blocks, first)]
    shared = _shared(blocks, first, inflation, single)
    complement = np.eye(len(shared)) - shared @ shared.T
    own = np.maximum(LEAST_SINGLE, np.diag(complement))
    serial = _own_serial([block @ complement / np.sqrt(own) for block in blocks])
    parts = [
        NoisePart(serial.variance * np.diag(own), serial),
        *(_part_along(blocks, v, k < single.shape[1]) for k, v in enumerate(shared.T)),
    ]
    whole = np.sum([part.covariance for part in parts], axis=0)
    sd = np.sqrt(np.diag(whole))
    return parts, inflation, len(whole) / float(np.sum((whole / np.outer(sd, sd)) ** 2))


def _inflation(serial: Serial, lengths: Sequence[int]) -> float:
    """Return readings over independent ones, for second moments: n sum d_j^2 / (sum d_j)^2."""
    independent = 0.0
    for n in (n for n in lengths if n > 1):
        d = serial.expected(n) if n >= SHORTEST else np.ones(n - 1)
        independent += n / (n - 1) * float(d.sum()) ** 2 / float(d @ d)
    return max(1.0, sum(lengths) / max(independent, 1e-9))


def greatest(n: float, n_gauges: int) -> float:
    """Return the variance that no direction of n independent readings of independent gauges exceeds by chance."""
    root = np.sqrt(max(n - 1.0, 1.0)), np.sqrt(n_gauges)
    centre = (root[0] + root[1]) ** 2
    spread = (root[0] + root[1]) * (1.0 / root[0] + 1.0 / root[1]) ** (1.0 / 3.0)
    return float((centre + OUTSTANDING * spread) / max(n, 1.0))


def _different(blocks: Sequence[Floats], serial: Serial) -> list[int]:
    """Return the gauges whose noise of long periods, trends left out, exceeds the others' by more than chance."""
    long = [block for block in blocks if len(block) >= SHORTEST]
    if not long or long[0].shape[1] < 3:
        return []
    power = [(coefficients(block)[1:LOW] ** 2).T @ (1.0 / serial.expected(len(block))[1:LOW]) for block in long]
    chance = np.asarray(chi2.sf(np.sum(power, axis=0), (LOW - 1) * len(long)))
    return [int(k) for k in np.flatnonzero(chance < DIFFERENT / len(chance))[:MOST_SHARED]]


def _shared(blocks: Sequence[Floats], serial: Serial, inflation: float, found: Floats) -> Floats:
    """Return the directions with those added that stand out: over all periods, then over the long ones."""
    found = _with_outstanding(found, np.concatenate(blocks), _degrees(blocks) / inflation)
    slow = [_slow(block, serial) for block in blocks if len(block) >= 2 * SHORTEST]
    return _with_outstanding(found, np.concatenate(slow), sum(map(len, slow))) if slow else found


def _degrees(blocks: Sequence[Floats]) -> int:
    """Return the readings beyond the first of each cell, which its mean takes."""
    return sum(len(block) - 1 for block in blocks)


def _slow(block: Floats, serial: Serial) -> Floats:
    """Return the coefficients (n_slow, n_gauges) of long periods in units of what is expected, the trend left out."""
    n_slow = max(2, len(block) // 8)
    return np.asarray(coefficients(block)[1:n_slow] / np.sqrt(serial.expected(len(block))[1:n_slow, None]))


def _with_outstanding(found: Floats, series: Floats, n: float) -> Floats:
    """Return the directions with those added whose variance in series (n_rows, n_gauges) stands out."""
    n_gauges = series.shape[1]
    if n_gauges < 2 or n < 4:
        return found
    rest = series - series @ found @ found.T
    values, vectors = np.linalg.eigh(rest.T @ rest / len(rest))
    for k in range(n_gauges - 1, -1, -1):
        left = n_gauges - found.shape[1]
        typical = float(np.sum(values[: k + 1])) / max(left, 1)
        if found.shape[1] >= min(MOST_SHARED, n_gauges - 1) or values[k] <= typical * greatest(n, left):
            break
        found = np.column_stack([found, vectors[:, k]])
    return found


def _own_serial(blocks: Sequence[Floats]) -> Serial:
    """Return the memory of what single gauges have, a pattern of trends that gauges share taken out.

    A drift and creep make trends with one pattern over the gauges: they are effects. Where the trends of the cells show
    no more of one pattern than chance, they count as they are.
    """
    cosines = [coefficients(block) for block in blocks if len(block) >= SHORTEST]
    return fit(cosines, has_trend=_has_trend(cosines))


def _has_trend(cosines: Sequence[Floats]) -> bool:
    """Return whether the trends of the cells, which are three or more, show no more of one pattern than chance."""
    if len(cosines) < 3 or cosines[0].shape[1] < 3:
        return False
    trends = np.array([c[0] for c in cosines])
    values = np.linalg.svd(trends, compute_uv=False)
    n_cells, n_gauges = trends.shape
    left = n_cells * n_gauges - n_cells - n_gauges + 1
    typical = float(np.sum(values[1:] ** 2)) / left
    return bool(values[0] ** 2 <= typical * n_gauges * greatest(n_gauges, n_cells))


def _part_along(blocks: Sequence[Floats], direction: Floats, is_single: bool) -> NoisePart:
    """Return what one gauge has, or gauges share, in a direction."""
    variance = float(np.sum((np.concatenate(blocks) @ direction) ** 2)) / max(_degrees(blocks), 1)
    pattern = np.outer(direction, direction)
    scores = [coefficients(block @ direction[:, None]) for block in blocks if len(block) >= SHORTEST]
    serial = fit(scores, SINGLE if is_single else SHARED, has_trend=not is_single)  # a drift of one gauge is an effect
    if serial is WHITE:
        return NoisePart(variance * pattern, WHITE)
    still = serial.walk == 0.0  # over many cells even a slow walk adds up: an improbable one is left out
    serial = serial.given(still) if still.any() and serial.walk_probability <= POSSIBLE else serial
    return NoisePart(serial.variance * pattern, serial)

"""What single gauges have of the noise and what gauges share, each with a memory of its own.

Residuals about the means of their cells, in standard deviations of their gauges, are split into the directions v over
the gauges whose variance stands out of what independent gauges would give (a common mode), and the rest:

    e_t = sum_k v_k f_kt + u_t.

The scores f_k have a spectrum each, the rest has one that all gauges share, or one of its own for a gauge that differs.

Source: I. M. Johnstone (2001), "On the distribution of the largest eigenvalue in principal components analysis",
Annals of Statistics 29 (the greatest eigenvalue of independent gauges); O. Ledoit and M. Wolf (2004), "A
well-conditioned estimator for large-dimensional covariance matrices", J. Multivariate Analysis 88 (the rest's
correlations, the shrinkage multiplied by what serial correlation takes of the number of readings).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2
from sklearn.covariance import ledoit_wolf

from octmip.gap.campaign.noise import NoisePart
from octmip.gap.campaign.spectrum import (
    SHARED,
    SHORTEST,
    WHITE,
    Serial,
    Spectrum,
    bands,
    coefficients,
    expected,
    fit,
    spectra_of,
    without_walk,
)

Floats = NDArray[np.float64]

MOST_SHARED = 3
"""Directions that gauges share, at most."""
OUTSTANDING = 5.0
"""Standard deviations by which a greatest eigenvalue exceeds that of independent gauges; 3.3 is met once in 1000."""
LOW = 4
"""Cosines of longest period, which say most of the variance of means."""
DIFFERENT = 1e-4
"""Chance that some gauge's slow noise exceeds the others' so far; below it the gauge has a spectrum of its own."""
EXCEEDING = 4.5
"""Standard deviations by which slow noise exceeds what its spectrum explains before it is enlarged."""
POSSIBLE = 0.05
"""Probability above which a walk is carried from cell to cell."""
LEAST_SINGLE = 0.05
"""Share of a gauge's variance that the rest keeps, at least, when its spectrum is brought to unit variance."""


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """The noise in parts, in units of the gauges' scatter.

    Attributes
    ----------
    parts
        the gauges' own first, then gauges with a spectrum of their own, then what gauges share.
    inflation
        cells' readings over the independent ones among them, for covariances of readings.
    independent
        share of the gauges that are independent of each other.
    n_shared
        number of directions that gauges share.
    wanders
        whether a random walk is more probable than not in one of them.
    is_serial
        whether successive readings are correlated in one of them.
    """

    parts: tuple[NoisePart, ...]
    inflation: float
    independent: float
    n_shared: int
    wanders: bool
    is_serial: bool


def parts_of(blocks: Sequence[Floats]) -> Parts:
    """Return the parts of residuals, for each cell (n_repeats, n_gauges) in standard deviations, missing ones 0."""
    first = fit(_own_spectra([coefficients(block) for block in blocks if len(block) >= SHORTEST]))
    inflation = _inflation(first, [len(block) for block in blocks])
    pooled = np.concatenate(blocks)
    correlation = correlation_of(pooled, inflation)
    shared = _shared(blocks, first, inflation)
    rest = [block - block @ shared @ shared.T for block in blocks]
    complement = np.eye(len(correlation)) - shared @ shared.T
    own = complement @ correlation @ complement
    scatter = np.sqrt(np.maximum(LEAST_SINGLE, np.diag(own)))
    cosines = [coefficients(block) / scatter for block in rest if len(block) >= SHORTEST]
    common = fit(_own_spectra(cosines))
    different = _different(cosines, common)
    parts = [_own_part(own, common, cosines, different)]
    parts += [_single_part(own, k, [c[:, [k]] for c in cosines]) for k in different]
    parts += [_shared_part(blocks, shared[:, k], len(pooled) / inflation) for k in range(shared.shape[1])]
    serials = [part.serial for part in parts]
    return Parts(
        tuple(parts),
        inflation,
        len(correlation) / float(np.sum(correlation**2)),
        shared.shape[1],
        any(serial.walk_probability > 0.5 for serial in serials),
        any(serial.white_probability < 0.01 for serial in serials) or any(part.excess > 1.0 for part in parts),
    )


def correlation_of(pooled: Floats, inflation: float) -> Floats:
    """Return the shrunk correlation matrix of readings (n, n_gauges) of which one in `inflation` is independent."""
    n_gauges = pooled.shape[1]
    if n_gauges < 2:
        return np.eye(n_gauges)
    sample = pooled.T @ pooled / len(pooled)
    shrinkage = min(1.0, float(ledoit_wolf(pooled, assume_centered=True)[1]) * inflation)
    mixed = (1.0 - shrinkage) * sample + shrinkage * float(np.trace(sample)) / n_gauges * np.eye(n_gauges)
    sd = np.sqrt(np.diag(mixed))
    return np.asarray(mixed / np.outer(sd, sd))


def _inflation(serial: Serial, lengths: Sequence[int]) -> float:
    """Return readings over independent ones, for second moments: n sum d_j^2 / (sum d_j)^2."""
    readings, independent = 0.0, 0.0
    for n in lengths:
        d = expected(serial, n) if n >= SHORTEST else np.ones(max(n - 1, 1))
        width = np.diff(np.append(bands(n), n - 1)) if n >= SHORTEST else np.ones(len(d))
        readings += n
        independent += n / (n - 1) * float(width @ d) ** 2 / float(width @ d**2) if n > 1 else 0.0
    return max(1.0, readings / max(independent, 1e-9))


def greatest(n: float, n_gauges: int) -> float:
    """Return the variance that no direction of n independent readings of independent gauges exceeds by chance."""
    root = np.sqrt(max(n - 1.0, 1.0)), np.sqrt(n_gauges)
    centre = (root[0] + root[1]) ** 2
    spread = (root[0] + root[1]) * (1.0 / root[0] + 1.0 / root[1]) ** (1.0 / 3.0)
    return float((centre + OUTSTANDING * spread) / max(n, 1.0))


def _shared(blocks: Sequence[Floats], serial: Serial, inflation: float) -> Floats:
    """Return the directions (n_gauges, n_shared) that gauges share: over all periods, then over the long ones."""
    pooled = np.concatenate(blocks)
    found = np.zeros((pooled.shape[1], 0))
    found = _with_outstanding(found, pooled, len(pooled) / inflation)
    slow = [_slow(block, serial) for block in blocks if len(block) >= 2 * SHORTEST]
    if slow:
        series = np.concatenate(slow)
        found = _with_outstanding(found, series, float(len(series)))
    return found


def _slow(block: Floats, serial: Serial) -> Floats:
    """Return the coefficients (n_slow, n_gauges) of long periods in units of what is expected, the trend left out."""
    n_slow = max(2, len(block) // 8)
    return np.asarray(coefficients(block)[1:n_slow] / np.sqrt(expected(serial, len(block))[1:n_slow, None]))


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


def _own_spectra(cosines: Sequence[Floats]) -> list[Spectrum]:
    """Return the pooled spectra of coefficients (n - 1, n_gauges) of every cell, a shared pattern of trends taken out.

    A drift and creep make trends with one pattern over the gauges: they are effects. Where the trends of the cells show
    no more of one pattern than chance, they count as they are.
    """
    has_trend, cosines = _without_trends(cosines)
    return spectra_of([c**2 for c in cosines], has_trend=has_trend)


def _without_trends(cosines: Sequence[Floats]) -> tuple[bool, Sequence[Floats]]:
    if len(cosines) < 3 or cosines[0].shape[1] < 3:
        return False, cosines
    trends = np.array([c[0] for c in cosines])
    values = np.linalg.svd(trends, compute_uv=False)
    n_cells, n_gauges = trends.shape
    left = n_cells * n_gauges - n_cells - n_gauges + 1
    typical = float(np.sum(values[1:] ** 2)) / left
    return bool(values[0] ** 2 <= typical * n_gauges * greatest(n_gauges, n_cells)), cosines


def _different(cosines: Sequence[Floats], common: Serial) -> list[int]:
    """Return the gauges whose slow noise is greater than the others' by more than chance."""
    if not cosines or cosines[0].shape[1] < 3:
        return []
    left = sum((c[1:LOW] ** 2 / expected(common, len(c) + 1)[1:LOW, None]).sum(axis=0) for c in cosines)
    trends = np.array([c[0] / np.sqrt(expected(common, len(c) + 1)[0]) for c in cosines])
    left = left + ((trends - trends.mean(axis=0)) ** 2).sum(axis=0)  # a drift of the gauge is an effect
    chance = chi2.sf(left, LOW * len(cosines) - 1)
    return [int(k) for k in np.flatnonzero(chance < DIFFERENT / len(left))]


def _slow_ratio(cosines: Floats, serial: Serial) -> Floats:
    """Return the power (n_gauges,) of long periods, the trend left out, over what is expected."""
    shape = expected(serial, len(cosines) + 1)[1:LOW]
    return np.asarray((cosines[1:LOW] ** 2 / shape[:, None]).mean(axis=0))


def _own_part(own: Floats, common: Serial, cosines: Sequence[Floats], different: Sequence[int]) -> NoisePart:
    """Return what single gauges have, those that differ left out."""
    serial = _decided(common)
    covariance = serial.variance * own
    covariance[different, :] = 0.0
    covariance[:, different] = 0.0
    keep = np.setdiff1d(np.arange(len(own)), different)
    excess = _excess([c[:, keep] for c in cosines], serial)
    return NoisePart(covariance, serial, excess, common if cosines else None)


def _single_part(own: Floats, gauge: int, cosines: Sequence[Floats]) -> NoisePart:
    """Return the noise of one gauge that differs from the others."""
    serial = _decided(fit(spectra_of([c**2 for c in cosines], has_trend=False)))
    covariance = np.zeros_like(own)
    covariance[gauge, gauge] = serial.variance * own[gauge, gauge]
    return NoisePart(covariance, serial, _excess(cosines, serial))


def _shared_part(blocks: Sequence[Floats], direction: Floats, n: float) -> NoisePart:
    """Return what gauges share in one direction, which n independent readings leave uncertain.

    With a variance lambda along it and about 1 across, the estimated direction is off by an angle of the expected
    square (n_gauges - 1) lambda / (n (lambda - 1)^2), which spreads over all other directions alike.
    """
    along = np.outer(direction, direction)
    pooled = float(np.mean((np.concatenate(blocks) @ direction) ** 2))
    off = min(1.0, pooled / (n * max(pooled - 1.0, 1e-3) ** 2))
    pattern = along + off * (np.eye(len(direction)) - along)
    scores = [coefficients(block @ direction[:, None]) for block in blocks if len(block) >= SHORTEST]
    if not scores:
        return NoisePart(pooled * pattern, WHITE)
    serial = _decided(fit(spectra_of([c**2 for c in scores], has_trend=True), SHARED))
    return NoisePart(serial.variance * pattern, serial, _excess(scores, serial))


def _decided(serial: Serial) -> Serial:
    """Return the posterior without the walk where that is improbable: over many cells even a slow one adds up."""
    return serial if serial.walk_probability > POSSIBLE else without_walk(serial)


def _excess(cosines: Sequence[Floats], serial: Serial) -> float:
    """Return the slow power over what is expected where it is more than chance gives, else 1."""
    if not cosines or not cosines[0].shape[1]:
        return 1.0
    ratio = float(np.mean([_slow_ratio(c, serial).mean() for c in cosines]))
    degrees = (LOW - 1) * sum(c.shape[1] for c in cosines)
    return ratio if np.log(max(ratio, 1e-12)) > EXCEEDING * np.sqrt(2.0 / degrees) else 1.0

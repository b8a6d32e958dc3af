"""The noise of a campaign estimated from its repeats.

Readings of one cell scatter about its mean. Pooled over cells the scatter gives the variance of every gauge, drawn
toward what all gauges have in common; in units of it the noise is split in parts (see `noise_parts`). scale(L) is the
ratio of the scatter at load L to the pooled one, 1 unless it differs significantly.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import digamma, polygamma

from octmip.errors import DataError
from octmip.gap.campaign.campaign import FEWEST_REPEATS, Campaign, Cell
from octmip.gap.campaign.noise import Noise, NoisePart
from octmip.gap.campaign.noise_parts import Parts, parts_of
from octmip.twin import Load, amounts_of

SIGNIFICANT = 4.0
"""Standard deviations beyond which a property of the noise is reported and used."""
MILD = 1e-5
"""Variance of log variances beyond chance below which all gauges are equally noisy."""
FEW_DEGREES = 40
"""Repeats beyond the first, over all cells, below which the commissioning run's are added."""
ROUNDING = 1e-12
"""Standard deviation over the greatest reading up to which repeats are equal: means round in the last digits."""
DIGITS = 9
"""Digits after the first one of the greatest reading that tell two readings apart; a step is ten times as coarse."""
SCALE_SIGNIFICANT = 1.08
"""Ratios of standard deviations between loads closer to 1 than this are not worth a model."""


def estimate_noise(campaign: Campaign, fallback: Campaign | None = None) -> Noise:
    """Return the noise of the campaign's repeats, those of `fallback` (the commissioning run) added where they are few.

    Raises
    ------
    DataError
        neither has repeats.
    """
    source = campaign
    if fallback is not None and len(campaign.test) - len(campaign.cells) < FEW_DEGREES:
        source = _together(campaign, fallback)
    if not source.has_repeats:
        raise DataError(_no_repeats(campaign))
    scatter = _scatter(source)
    found = _parts(scatter)
    scale = _scales(source, scatter, found.inflation / found.independent)
    kurtosis, heavy = _kurtosis(np.concatenate(scatter.scaled)[:, scatter.usable], found.inflation)
    step = quantisation_step(source.readings)
    sd = np.sqrt(scatter.variance)
    parts = tuple(replace(part, covariance=part.covariance * np.outer(sd, sd)) for part in found.parts)
    uneven = any(abs(s - 1.0) > 1e-9 for s in scale.values()) or _gauges_differ(scatter, kurtosis, found.inflation)
    names = {
        "heavy_tailed_noise": heavy,
        "heteroscedastic_noise": uneven,
        "correlated_noise": found.is_serial or found.n_shared > 0,
        "random_walk": found.wanders,
        "quantisation": step > 0.5 * float(np.sqrt(np.median(scatter.variance))),
    }
    return Noise(
        gauges=source.gauges,
        covariance=np.sum([part.covariance for part in parts], axis=0),
        inflation=_typical_inflation(parts, source),
        scale=scale,
        lag1=_typical_lag1(parts),
        kurtosis=kurtosis,
        step=step,
        stuck=tuple(name for name, is_stuck in zip(source.gauges, scatter.stuck, strict=True) if is_stuck),
        findings=tuple(name for name, is_there in names.items() if is_there),
        degrees=float(scatter.degrees[scatter.usable].mean()),
        parts=parts,
    )


def _typical_inflation(parts: Sequence[NoisePart], campaign: Campaign) -> float:
    """Return the factor on the variance of means of the typical gauge in the typical cell."""
    n = max(1, int(np.median([len(cell.rows) for cell in campaign.cells])))
    of_mean = np.sum([n * part.of_mean(n) * np.diag(part.covariance) for part in parts], axis=0)
    return float(np.median(of_mean / np.sum([np.diag(part.covariance) for part in parts], axis=0)))


def _typical_lag1(parts: Sequence[NoisePart]) -> float:
    weight = np.array([np.trace(part.covariance) for part in parts])
    return float(weight @ [part.serial.lag1 for part in parts] / weight.sum())


def _no_repeats(campaign: Campaign) -> str:
    cell = campaign.cells[0]
    return (
        f"row {campaign.row_number(int(cell.rows[0]))} ({cell.name}): every load of every test was read fewer than "
        f"{FEWEST_REPEATS} times, so the noise cannot be estimated; repeat the readings, or give a commissioning "
        "run with repeats, or the standard deviation of one reading (noise_sd, --noise)"
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Scatter:
    """The scatter of the repeats about the means of their cells.

    Attributes
    ----------
    scaled
        for each cell (n_repeats, n_gauges) in standard deviations; NaN where nothing was recorded.
    own, variance
        (n_gauges,) variance of one reading, as it scatters and drawn toward all gauges, in squares of its unit.
    degrees
        (n_gauges,) repeats less cells.
    usable, stuck
        (n_gauges,) gauges that scatter, and those whose repeats never change.
    """

    scaled: tuple[NDArray[np.float64], ...]
    own: NDArray[np.float64]
    variance: NDArray[np.float64]
    degrees: NDArray[np.float64]
    usable: NDArray[np.bool_]
    stuck: NDArray[np.bool_]


def _scatter(campaign: Campaign) -> _Scatter:
    residuals = [_centred(campaign, cell) for cell in campaign.cells]
    pooled = np.concatenate(residuals)
    degrees = np.isfinite(pooled).sum(axis=0) - sum((cell.count > 0).astype(int) for cell in campaign.cells)
    own = np.nansum(pooled**2, axis=0) / np.maximum(degrees, 1)
    stuck = (own <= least_variance(campaign.readings)) & (degrees > 0)
    usable = (degrees > 0) & ~stuck
    if not usable.any():
        raise DataError("no gauge shows any scatter between repeats; expected noise; the rows are copies of each other")
    variance = np.full_like(own, np.median(own[usable]))
    variance[usable] = _moderated(own[usable], degrees[usable])
    return _Scatter(tuple(r / np.sqrt(variance) for r in residuals), own, variance, degrees, usable, stuck)


def _parts(scatter: _Scatter) -> Parts:
    """Return the parts of the noise over all gauges; a gauge that does not scatter is taken as white."""
    usable = np.flatnonzero(scatter.usable)
    found = parts_of([np.nan_to_num(block[:, usable]) for block in scatter.scaled])
    n_gauges = len(scatter.variance)
    whole = []
    for k, part in enumerate(found.parts):
        covariance = np.zeros((n_gauges, n_gauges)) if k else np.eye(n_gauges)
        covariance[np.ix_(usable, usable)] = part.covariance
        whole.append(replace(part, covariance=covariance))
    return replace(found, parts=tuple(whole))


def _together(campaign: Campaign, run: Campaign) -> Campaign:
    """Return the rows of both, where the run has every gauge of the campaign; else the campaign."""
    if set(campaign.gauges) - set(run.gauges) or campaign.parameters != run.parameters:
        return campaign
    if campaign.load_names != run.load_names:
        return campaign
    order = [run.gauges.index(name) for name in campaign.gauges]
    return Campaign(
        campaign.gauges,
        campaign.parameters,
        (*campaign.test, *(f"commissioning {name}" for name in run.test)),
        np.concatenate([campaign.load_factor, run.load_factor]),
        np.concatenate([campaign.states, run.states]),
        np.concatenate([campaign.readings, run.readings[:, order]]),
        np.concatenate([campaign.time, run.time]),
        np.concatenate([campaign.temperature, run.temperature]),
        load_names=campaign.load_names,
        units=campaign.units,
    )


def _centred(campaign: Campaign, cell: Cell) -> NDArray[np.float64]:
    readings = campaign.readings[cell.rows] - cell.mean
    return np.asarray(np.where(cell.count > 1, readings, np.nan))


def _moderated(variance: NDArray[np.float64], degrees: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return variances (n,) drawn toward what all gauges have in common, the more so the fewer degrees they have.

    With a handful of repeats a gauge's own variance is off by a half, and one that is too small calls noise a gap.
    Source: G. K. Smyth (2004), "Linear models and empirical Bayes methods for assessing differential expression in
    microarray experiments", Statist. Appl. Genet. Mol. Biol. 3, section 6.2, with the sample's mean trigamma.
    """
    if len(variance) < 3:
        return variance
    half = degrees / 2.0
    e = np.log(variance) - digamma(half) + np.log(half)
    excess = float(np.var(e, ddof=1) - np.mean(polygamma(1, half)))
    if excess <= MILD:
        return np.full_like(variance, np.exp(float(np.average(e, weights=degrees))))
    prior = 2.0 * float(brentq(lambda h: float(polygamma(1, h)) - excess, 1e-3, 1e6))
    common = np.exp(float(e.mean()) + float(digamma(prior / 2.0)) - np.log(prior / 2.0))
    return np.asarray((prior * common + degrees * variance) / (prior + degrees))


def _scales(campaign: Campaign, scatter: _Scatter, inflation: float) -> dict[Load, float]:
    """Return the variance ratio of each load to the whole where it is significant, else 1.

    One reading in `inflation` is independent of the others.
    """
    loads = [cell.load for cell in campaign.cells]
    squares: dict[Load, tuple[float, float]] = {}
    for load in sorted(set(loads), key=amounts_of):
        blocks = [scatter.scaled[k][:, scatter.usable] for k, own in enumerate(loads) if own == load]
        total = sum(float(np.nansum(block**2)) for block in blocks)
        degrees = sum(float(np.maximum(np.isfinite(block).sum(axis=0) - 1, 0).sum()) for block in blocks)
        squares[load] = (total, degrees)
    whole = sum(t for t, _ in squares.values()) / max(1.0, sum(d for _, d in squares.values()))
    scale = {}
    for load, (total, degrees) in squares.items():
        ratio = total / degrees / whole if degrees > 0 else 1.0
        z = abs(np.log(max(ratio, 1e-12))) / np.sqrt(2.0 * inflation / max(degrees, 1.0))
        scale[load] = ratio if z > SIGNIFICANT and max(ratio, 1 / ratio) > SCALE_SIGNIFICANT else 1.0
    return scale


def _kurtosis(scaled: NDArray[np.float64], inflation: float) -> tuple[float, bool]:
    values = scaled[np.isfinite(scaled)]
    excess = float(np.mean(values**4) / np.mean(values**2) ** 2 - 3.0)
    return excess, excess > max(0.5, SIGNIFICANT * np.sqrt(24.0 * inflation / values.size))


def _gauges_differ(scatter: _Scatter, kurtosis: float, inflation: float) -> bool:
    """Return whether some gauge is noisier than the others (maximum of log ratios, corrected for tails and number)."""
    variance, degrees = scatter.own[scatter.usable], scatter.degrees[scatter.usable]
    spread = np.sqrt((2.0 + max(0.0, kurtosis)) * inflation / np.maximum(degrees, 1))
    z = np.abs(np.log(variance / np.median(variance))) / spread
    return bool(z.max() > SIGNIFICANT + 0.5)


def least_variance(readings: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the variance (n_gauges,) beyond which repeats differ, of readings (n_rows, n_gauges) in any unit."""
    return np.asarray((ROUNDING * np.max(np.abs(np.nan_to_num(readings)), axis=0, initial=0.0)) ** 2)


def quantisation_step(readings: NDArray[np.float64]) -> float:
    """Return the step that all readings are whole multiples of, in their unit; 0 when there is none.

    Steps below 1e-8 of the greatest reading, or less, are none.
    """
    recorded = readings[np.isfinite(readings)]
    greatest = float(np.abs(recorded).max(initial=0.0))
    if not greatest > 0.0:
        return 0.0
    digits = DIGITS - int(np.floor(np.log10(greatest)))
    values = np.unique(np.round(recorded, digits))
    if len(values) < 3:
        return 0.0
    step = float(np.diff(values).min())
    if step < 10.0 ** (1 - digits):
        return 0.0
    multiples = (values - values[0]) / step
    off = np.abs(multiples - np.round(multiples))
    return step if bool(np.all(off < 1e-3 * np.maximum(1, np.abs(multiples) * 1e-3))) else 0.0

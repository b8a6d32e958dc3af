"""The noise of a campaign estimated from its repeats.

Readings of one cell scatter about its mean. Pooled over cells the scatter gives the variance of every gauge, drawn
toward what all gauges have in common; in units of it the noise is split in parts (see `noise_parts`). scale(L) is the
ratio of the scatter at load L to the pooled one, 1 unless it differs significantly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import digamma, polygamma

from octmip.errors import DataError
from octmip.gap.campaign.campaign import FEWEST_REPEATS, Campaign
from octmip.gap.campaign.fault import Fault
from octmip.gap.campaign.noise import Noise, NoisePart
from octmip.gap.campaign.noise_parts import parts_of
from octmip.twin import Load, amounts_of

Floats = NDArray[np.float64]

SIGNIFICANT = 4.0
"""Standard deviations beyond which a property of the noise is reported and used."""
MILD = 1e-5
"""Variance of log variances beyond chance below which all gauges are equally noisy."""
FEW_DEGREES = 40
"""Repeats beyond the first, over all cells, below which the commissioning run's are added."""
SURELY_WHITE = 0.01
"""Probability of white noise below which successive readings are correlated."""
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
    sources = [campaign]
    if fallback is not None and len(campaign.test) - len(campaign.cells) < FEW_DEGREES and _fits(campaign, fallback):
        sources.append(fallback)
    if not any(source.has_repeats for source in sources):
        raise DataError(_no_repeats(campaign))
    scatter = _scatter(sources)
    blocks = [np.nan_to_num(block[:, scatter.usable]) for block in scatter.scaled]
    parts, inflation, independent = parts_of(blocks)
    scale = _scales(scatter, inflation / independent)
    kurtosis, heavy = _kurtosis(np.concatenate(scatter.scaled)[:, scatter.usable], inflation)
    step = quantisation_step(scatter.readings)
    uneven = any(abs(s - 1.0) > 1e-9 for s in scale.values()) or _gauges_differ(scatter, kurtosis, inflation)
    names = {
        "heavy_tailed_noise": heavy,
        "heteroscedastic_noise": uneven,
        "correlated_noise": len(parts) > 1 or parts[0].serial.white_probability < SURELY_WHITE,
        "quantisation": step > 0.5 * float(np.sqrt(np.median(scatter.variance))),
    }
    parts = [scatter.in_units(part, k == 0) for k, part in enumerate(parts)]
    n = max(1, int(np.median([len(block) for block in blocks])))
    return Noise(
        gauges=campaign.gauges,
        parts=tuple(parts),
        inflation=_typical_inflation(parts, n),
        scale=scale,
        kurtosis=kurtosis,
        step=step,
        faults=tuple(_stuck(campaign, int(k)) for k in np.flatnonzero(scatter.stuck)),
        properties=tuple(name for name, is_there in names.items() if is_there),
    )


def _stuck(campaign: Campaign, gauge: int) -> Fault:
    name, rows = campaign.gauges[gauge], np.arange(len(campaign.test))
    words = f"Readings of {name} never change between repeats: a stuck channel."
    return Fault("stuck", name, rows, words, float(campaign.cells[0].mean[gauge]), 0)


def _fits(campaign: Campaign, run: Campaign) -> bool:
    """Return whether a run has every gauge of the campaign, and its loads."""
    return not set(campaign.gauges) - set(run.gauges) and campaign.load_names == run.load_names


def _no_repeats(campaign: Campaign) -> str:
    cell = campaign.cells[0]
    return (
        f"row {campaign.row_number(int(cell.rows[0]))} ({cell.name}): every load of every test was read fewer than "
        f"{FEWEST_REPEATS} times, so the noise cannot be estimated; repeat the readings, or give a commissioning "
        "run with repeats, or the standard deviation of one reading (noise_sd, --noise)"
    )


def _typical_inflation(parts: Sequence[NoisePart], n: int) -> float:
    """Return the factor on the variance of means of n readings of the typical gauge."""
    of_mean = np.sum([n * part.of_mean(n) * np.diag(part.covariance) for part in parts], axis=0)
    return float(np.median(of_mean / np.sum([np.diag(part.covariance) for part in parts], axis=0)))


@dataclass(frozen=True, slots=True, eq=False)
class _Scatter:
    """The scatter of the repeats about the means of their cells.

    Attributes
    ----------
    readings
        (n_rows, n_gauges) all of them.
    loads
        of each cell.
    scaled
        for each cell (n_repeats, n_gauges) in standard deviations; NaN where nothing was recorded.
    own, variance
        (n_gauges,) variance of one reading, as it scatters and drawn toward all gauges, in squares of its unit.
    degrees
        (n_gauges,) repeats less cells.
    usable, stuck
        (n_gauges,) gauges that scatter, and those whose repeats never change.
    """

    readings: Floats
    loads: tuple[Load, ...]
    scaled: tuple[Floats, ...]
    own: Floats
    variance: Floats
    degrees: Floats
    usable: NDArray[np.bool_]
    stuck: NDArray[np.bool_]

    def in_units(self, part: NoisePart, is_own: bool) -> NoisePart:
        """Return a part of the usable gauges as one of all, in their units; a gauge that does not scatter is white."""
        covariance = np.diag(np.where(self.usable, 0.0, float(is_own)))
        covariance[np.ix_(self.usable, self.usable)] = part.covariance
        sd = np.sqrt(self.variance)
        return NoisePart(covariance * np.outer(sd, sd), part.serial)


def _scatter(sources: Sequence[Campaign]) -> _Scatter:
    gauges, blocks, loads, every = sources[0].gauges, [], [], []
    for source in sources:
        columns = [source.gauges.index(name) for name in gauges]
        every.append(source.readings[:, columns])
        for cell in source.cells:
            residual = source.readings[cell.rows] - cell.mean
            blocks.append(np.where(cell.count > 1, residual, np.nan)[:, columns])
            loads.append(cell.load)
    readings, pooled = np.concatenate(every), np.concatenate(blocks)
    degrees = sum((np.maximum(np.isfinite(block).sum(axis=0) - 1, 0) for block in blocks), np.zeros(len(gauges)))
    own = np.nansum(pooled**2, axis=0) / np.maximum(degrees, 1)
    stuck = (own <= least_variance(readings)) & (degrees > 0)
    usable = (degrees > 0) & ~stuck
    if not usable.any():
        raise DataError("no gauge shows any scatter between repeats; expected noise; the rows are copies of each other")
    variance = np.full_like(own, np.median(own[usable]))
    variance[usable] = _moderated(own[usable], degrees[usable])
    scaled = tuple(block / np.sqrt(variance) for block in blocks)
    return _Scatter(readings, tuple(loads), scaled, own, variance, degrees, usable, stuck)


def _moderated(variance: Floats, degrees: Floats) -> Floats:
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


def _scales(scatter: _Scatter, inflation: float) -> dict[Load, float]:
    """Return the variance ratio of each load to the whole where it is significant, else 1.

    One reading in `inflation` is independent of the others.
    """
    squares: dict[Load, list[float]] = {}
    for load, block in zip(scatter.loads, scatter.scaled, strict=True):
        own, found = block[:, scatter.usable], squares.setdefault(load, [0.0, 0.0])
        found[0] += float(np.nansum(own**2))
        found[1] += float(np.maximum(np.isfinite(own).sum(axis=0) - 1, 0).sum())
    whole = sum(t for t, _ in squares.values()) / max(1.0, sum(d for _, d in squares.values()))
    scale = {}
    for load in sorted(squares, key=amounts_of):
        total, degrees = squares[load]
        ratio = total / degrees / whole if degrees > 0 else 1.0
        z = abs(np.log(max(ratio, 1e-12))) / np.sqrt(2.0 * inflation / max(degrees, 1.0))
        scale[load] = ratio if z > SIGNIFICANT and max(ratio, 1 / ratio) > SCALE_SIGNIFICANT else 1.0
    return scale


def _kurtosis(scaled: Floats, inflation: float) -> tuple[float, bool]:
    values = scaled[np.isfinite(scaled)]
    excess = float(np.mean(values**4) / np.mean(values**2) ** 2 - 3.0)
    return excess, excess > max(0.5, SIGNIFICANT * np.sqrt(24.0 * inflation / values.size))


def _gauges_differ(scatter: _Scatter, kurtosis: float, inflation: float) -> bool:
    """Return whether some gauge is noisier than the others (maximum of log ratios, corrected for tails and number)."""
    variance, degrees = scatter.own[scatter.usable], scatter.degrees[scatter.usable]
    spread = np.sqrt((2.0 + max(0.0, kurtosis)) * inflation / np.maximum(degrees, 1))
    z = np.abs(np.log(variance / np.median(variance))) / spread
    return bool(z.max() > SIGNIFICANT + 0.5)


def least_variance(readings: Floats) -> Floats:
    """Return the variance (n_gauges,) beyond which repeats differ, of readings (n_rows, n_gauges) in any unit."""
    return np.asarray((ROUNDING * np.max(np.abs(np.nan_to_num(readings)), axis=0, initial=0.0)) ** 2)


def quantisation_step(readings: Floats) -> float:
    """Return the step that all readings are whole multiples of, in their unit; 0 when there is none.

    Steps below 1e-8 of the greatest reading, or less, are none.
    """
    recorded = readings[np.isfinite(readings)]
    greatest_one = float(np.abs(recorded).max(initial=0.0))
    if not greatest_one > 0.0:
        return 0.0
    digits = DIGITS - int(np.floor(np.log10(greatest_one)))
    values = np.unique(np.round(recorded, digits))
    if len(values) < 3:
        return 0.0
    step = float(np.diff(values).min())
    if step < 10.0 ** (1 - digits):
        return 0.0
    multiples = (values - values[0]) / step
    off = np.abs(multiples - np.round(multiples))
    return step if bool(np.all(off < 1e-3 * np.maximum(1, np.abs(multiples) * 1e-3))) else 0.0

"""The noise of a campaign estimated from its repeats.

Readings of one cell scatter about its mean. Pooled over cells the scatter gives the variance of every gauge, drawn
toward what all gauges have in common; the step of its display adds what repeats do not show (`display`). In units of it
the residuals are split into parts (`noise_parts`). scale(L) is the ratio of the scatter at load L to the pooled one, 1
unless it differs significantly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import digamma, polygamma
from scipy.stats import chi2, norm

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.display import left_by, steps_of
from octmip.gap.campaign.noise import Noise, NoisePart
from octmip.gap.campaign.noise_parts import parts_of
from octmip.gap.campaign.spectrum import WHITE
from octmip.twin import Load, amounts_of

Floats = NDArray[np.float64]

LEAST_DEGREES = 0.5
"""Degrees of freedom beyond two, at least: the mean of a variance from two or fewer has no end."""
SIGNIFICANT = 4.0
"""Standard deviations beyond which a property of the noise is reported and used."""
MILD = 1e-5
"""Variance of log variances beyond chance below which all gauges are equally noisy."""
FEW_DEGREES = 40
"""Repeats beyond the first, over all cells, below which the commissioning run's are added."""
SCALE_SIGNIFICANT = 1.08
"""Ratios of standard deviations between loads closer to 1 than this are not worth a model."""
LEAST_RATIO = 1e-4
"""Ratio of variances below which a load has no noise to speak of."""
LEAST_SEEN = 1e-3
"""Variance of a reading over the square of the step, at least, where no repeats differ: what the step hides."""


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
    if not scatter.usable.any():
        return scatter.of_displays()
    blocks = [np.nan_to_num(block[:, scatter.usable]) for block in scatter.scaled]
    parts, inflation, independent = parts_of(blocks)
    scale = _scales(scatter, inflation / independent)
    kurtosis, heavy = _kurtosis(scatter, inflation)
    uneven = any(abs(s - 1.0) > 1e-9 for s in scale.values()) or _gauges_differ(campaign, scatter, kurtosis, inflation)
    names = {
        "heavy_tailed_noise": heavy,
        "heteroscedastic_noise": uneven,
        "correlated_noise": len(parts) > 1 or parts[0].remembers,
        "quantisation": scatter.is_coarse,
    }
    parts = [scatter.in_units(part, k == 0) for k, part in enumerate(parts)]
    n = max(1, int(np.median([len(block) for block in blocks])))
    return Noise(
        gauges=campaign.gauges,
        parts=tuple(parts),
        inflation=_typical_inflation(parts, n),
        scale=scale,
        kurtosis=kurtosis,
        steps=scatter.steps,
        rounding=scatter.rounding,
        properties=tuple(name for name, is_there in names.items() if is_there),
    )


def _fits(campaign: Campaign, run: Campaign) -> bool:
    """Return whether a run has every gauge of the campaign, and its loads."""
    return not set(campaign.gauges) - set(run.gauges) and campaign.load_names == run.load_names


def _no_repeats(campaign: Campaign) -> str:
    cell = campaign.cells[0]
    return (
        f"row {campaign.row_number(int(cell.rows[0]))} ({cell.name}): at most one load of one test was read twice, and "
        "none more often, so the noise cannot be estimated; repeat the readings of two loads, or give a commissioning "
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
    gauges
        names.
    loads
        of each cell.
    scaled
        for each cell (n_repeats, n_gauges) in standard deviations; NaN where nothing was recorded.
    own, variance
        (n_gauges,) variance of one reading, as it scatters and drawn toward all gauges, in squares of its unit.
    degrees
        (n_gauges,) repeats less cells.
    usable
        (n_gauges,) gauges that scatter.
    steps, rounding
        (n_gauges,) of the display, and the variance that they leave in means.
    """

    gauges: tuple[str, ...]
    loads: tuple[Load, ...]
    scaled: tuple[Floats, ...]
    own: Floats
    variance: Floats
    degrees: Floats
    usable: NDArray[np.bool_]
    steps: Floats
    rounding: Floats

    @property
    def is_coarse(self) -> bool:
        """Whether the step of the typical gauge shows in its noise."""
        return bool(np.median(self.steps / np.sqrt(self.variance + self.rounding)) > 0.5)

    def in_units(self, part: NoisePart, is_own: bool) -> NoisePart:
        """Return a part of the usable gauges as one of all, in their units; a gauge that does not scatter is white."""
        covariance = np.diag(np.where(self.usable, 0.0, float(is_own)))
        covariance[np.ix_(self.usable, self.usable)] = part.covariance
        sd = np.sqrt(self.variance)
        return NoisePart(covariance * np.outer(sd, sd), part.serial)

    def of_displays(self) -> Noise:
        """Return the noise where no repeats differ: that of the displays' steps."""
        part = NoisePart(np.diag(self.variance), WHITE)
        return Noise(self.gauges, (part,), steps=self.steps, rounding=self.rounding, properties=("quantisation",))


def _scatter(sources: Sequence[Campaign]) -> _Scatter:
    gauges, blocks, loads = sources[0].gauges, list[Floats](), list[Load]()
    for source in sources:
        columns = _order(gauges, source)
        for cell in source.cells:
            residual = source.readings[cell.rows] - cell.mean
            blocks.append(np.where(cell.count > 1, residual, np.nan)[:, columns])
            loads.append(cell.load)
    pooled, steps = np.concatenate(blocks), steps_of(sources[0])
    degrees = sum((np.maximum(np.isfinite(block).sum(axis=0) - 1, 0) for block in blocks), np.zeros(len(gauges)))
    own = np.nansum(pooled**2, axis=0) / np.maximum(degrees, 1)
    usable = np.any([(source.spreads()[:, _order(gauges, source)] > 0.0).any(axis=0) for source in sources], axis=0)
    variance = _typical(sources[0], own, usable, degrees > 0, steps)
    variance[usable] = _moderated(own[usable], degrees[usable])
    rounding = left_by(steps, np.where(degrees > 0, np.minimum(own, variance), variance))
    scaled = tuple(block / np.sqrt(variance) for block in blocks)
    return _Scatter(gauges, tuple(loads), scaled, own, variance, degrees, usable, steps, rounding)


def _order(gauges: Sequence[str], campaign: Campaign) -> list[int]:
    """Return the positions (n_gauges,) of gauges in a campaign."""
    return [campaign.gauges.index(name) for name in gauges]


def _typical(
    campaign: Campaign, own: Floats, usable: NDArray[np.bool_], is_repeated: NDArray[np.bool_], steps: Floats
) -> Floats:
    """Return the variance (n_gauges,) of gauges that do not scatter.

    Repeats that a display keeps equal have next to none; of a gauge without repeats it is that of the gauges of its
    unit, or where none of these scatters that of its display.
    """
    units = np.array([campaign.unit_of(name) for name in campaign.gauges])
    greatest = np.abs(np.nan_to_num(campaign.readings)).max(axis=0)
    found = np.maximum(LEAST_SEEN * steps**2, (1e-9 * np.where(greatest > 0.0, greatest, 1.0)) ** 2)
    for k in np.flatnonzero(~usable & ~is_repeated).tolist():
        alike = own[usable & (units == units[k])]
        found[k] = float(np.median(alike)) if alike.size else max(steps[k] ** 2 / 12.0, found[k])
    return np.asarray(found)


def _moderated(variance: Floats, degrees: Floats) -> Floats:
    """Return variances (n,) drawn toward what all gauges have in common, the more so the fewer degrees they have.

    With a handful of repeats a gauge's own variance is off by a half, and one that is too small calls noise a gap.
    Source: G. K. Smyth (2004), "Linear models and empirical Bayes methods for assessing differential expression in
    microarray experiments", Statist. Appl. Genet. Mol. Biol. 3, section 6.2, with the sample's mean trigamma.
    """
    if len(variance) < 3:
        return _expected(variance, degrees)
    half = degrees / 2.0
    e = np.log(variance) - digamma(half) + np.log(half)
    excess = float(np.var(e, ddof=1) - np.mean(polygamma(1, half)))
    if excess <= MILD:
        return _expected(np.full_like(variance, np.exp(float(np.average(e, weights=degrees)))), degrees.sum())
    prior = 2.0 * float(brentq(lambda h: float(polygamma(1, h)) - excess, 1e-3, 1e6))
    common = np.exp(float(e.mean()) + float(digamma(prior / 2.0)) - np.log(prior / 2.0))
    return _expected((prior * common + degrees * variance) / (prior + degrees), prior + degrees)


def _expected(variance: Floats, degrees: Floats | float) -> Floats:
    """Return the mean of the inverse gamma posterior of variances (n,) estimated with so many degrees of freedom."""
    return np.asarray(variance * degrees / np.maximum(degrees - 2.0, LEAST_DEGREES))


def _scales(scatter: _Scatter, inflation: float) -> dict[Load, float]:
    """Return the variance ratio of each load to the whole where it is significant, else 1.

    One reading in `inflation` is independent of the others. What the display hides counts at every load alike, so that
    equal repeats are no load without noise.
    """
    hidden = scatter.rounding[scatter.usable] / scatter.variance[scatter.usable]
    squares: dict[Load, list[float]] = {}
    for load, block in zip(scatter.loads, scatter.scaled, strict=True):
        own, found = block[:, scatter.usable], squares.setdefault(load, [0.0, 0.0])
        degrees_of = np.maximum(np.isfinite(own).sum(axis=0) - 1, 0)
        found[0] += float(np.nansum(own**2) + degrees_of @ hidden)
        found[1] += float(degrees_of.sum())
    whole = sum(t for t, _ in squares.values()) / max(1.0, sum(d for _, d in squares.values()))
    scale = {}
    for load in sorted(squares, key=amounts_of):
        total, degrees = squares[load]
        ratio = max(total / degrees / whole, LEAST_RATIO) if degrees > 0 else 1.0
        independent = max(degrees, 1.0) / inflation
        chance = float(min(chi2.cdf(ratio * independent, independent), chi2.sf(ratio * independent, independent)))
        is_significant = chance < norm.sf(SIGNIFICANT) and max(ratio, 1 / ratio) > SCALE_SIGNIFICANT
        scale[load] = ratio if is_significant else 1.0
    return scale


def _kurtosis(scatter: _Scatter, inflation: float) -> tuple[float, bool]:
    scaled = np.concatenate(scatter.scaled)[:, scatter.usable]
    values = scaled[np.isfinite(scaled)]
    excess = float(np.mean(values**4) / np.mean(values**2) ** 2 - 3.0)
    degrees = float(scatter.degrees[scatter.usable].sum())
    return excess, excess > max(0.5, SIGNIFICANT * np.sqrt(24.0 * inflation / degrees))


def _gauges_differ(campaign: Campaign, scatter: _Scatter, kurtosis: float, inflation: float) -> bool:
    """Return whether some gauge is noisier than the others of its unit, corrected for tails and number."""
    variance, degrees = scatter.own[scatter.usable], scatter.degrees[scatter.usable]
    units = np.array([campaign.unit_of(name) for name in scatter.gauges])[scatter.usable]
    typical = np.array([np.median(variance[units == unit]) for unit in units])
    spread = np.sqrt((2.0 + max(0.0, kurtosis)) * inflation / np.maximum(degrees, 1))
    z = np.abs(np.log(variance / typical)) / spread
    return bool(z.max() > SIGNIFICANT + 0.5)

"""The noise as a hypothesis of its own: estimated from repeats, never taken for granted.

Readings of one cell scatter about its mean; pooled over cells the scatter gives the covariance V of one reading over
the gauges, shrunk toward its diagonal (Ledoit and Wolf (2004), "A well-conditioned estimator for large-dimensional
covariance matrices", J. Multivariate Analysis 88, on readings scaled to unit variance). Means of N repeats have
covariance inflation * scale(L) * V / N, where

* inflation is the variance ratio of batch means, 1 unless the lag-1 correlation is significant (Flegal and Jones
  (2010), "Batch means and spectral variance estimators in Markov chain Monte Carlo", Annals of Statistics 38);
* scale(L) is the ratio of the scatter at load L to the pooled one, 1 unless it differs significantly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import digamma, polygamma
from sklearn.covariance import ledoit_wolf

from octmip.errors import DataError
from octmip.gap.campaign.campaign import FEWEST_REPEATS, Campaign, Cell
from octmip.twin import Load, amounts_of

SIGNIFICANT = 4.0
"""Standard deviations beyond which a property of the noise is reported and used."""
MILD = 1e-5
"""Variance of log variances beyond chance below which all gauges are equally noisy."""
FEW_DEGREES = 40
"""Repeats beyond the first, over all cells, below which the commissioning run's are added."""
SCALE_SIGNIFICANT = 1.08
"""Ratios of standard deviations between loads closer to 1 than this are not worth a model."""


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """The noise of the readings, from their repeats.

    Attributes
    ----------
    gauges
        names.
    covariance
        (n_gauges, n_gauges) of one reading [microstrain^2].
    inflation
        factor on the variance of means for serial correlation.
    scale
        variance ratio by load.
    lag1
        mean lag-1 correlation of successive repeats.
    kurtosis
        excess kurtosis, 0 for a normal distribution.
    step
        quantisation step [microstrain], 0 when none is seen.
    stuck
        gauges whose repeats never change.
    findings
        names of what is not plain white noise, of the effects' list.
    clipped
        by gauge that met the end of its range, where that lies [microstrain].
    degrees
        repeats less cells, over the gauges' mean.
    """

    gauges: tuple[str, ...]
    covariance: NDArray[np.float64]
    inflation: float
    scale: Mapping[Load, float]
    lag1: float
    kurtosis: float
    step: float
    stuck: tuple[str, ...]
    findings: tuple[str, ...]
    degrees: float
    clipped: Mapping[str, float] = field(default_factory=dict)

    @property
    def sd_microstrain(self) -> float:
        """Typical standard deviation of one reading [microstrain]."""
        return float(np.sqrt(np.median(np.diag(self.covariance))))

    def of_gauges(self, gauges: Sequence[str]) -> "Noise":
        """Return the noise of these gauges, in their order."""
        order = [self.gauges.index(name) for name in gauges]
        return replace(self, gauges=tuple(gauges), covariance=self.covariance[np.ix_(order, order)])

    def of_mean(self, repeats: NDArray[np.int64], load: Load) -> NDArray[np.float64]:
        """Return the covariance (n_gauges, n_gauges) of means of so many repeats (n_gauges,), one or more per gauge."""
        count = np.maximum(repeats, 1).astype(np.float64)
        overlap = np.minimum(count[:, None], count[None, :]) / (count[:, None] * count[None, :])
        factor = self.inflation * self.scale.get(load, 1.0)
        return np.asarray(factor * self.covariance * overlap)


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
    usable, residuals, scaled = scatter.usable, scatter.scaled, np.concatenate(scatter.scaled)
    covariance = _shrunk(scaled, usable) * np.sqrt(np.outer(scatter.variance, scatter.variance))
    lag1, inflation = _serial(residuals, usable)
    scale = _scales(source, residuals, usable)
    kurtosis, heavy = _kurtosis(scaled[:, usable])
    step = quantisation_step(source.readings)
    uneven = any(abs(s - 1.0) > 1e-9 for s in scale.values()) or _gauges_differ(scatter, kurtosis)
    found = {
        "heavy_tailed_noise": heavy,
        "heteroscedastic_noise": uneven,
        "correlated_noise": inflation > 1.0 or _gauges_correlate(scaled[:, usable]),
        "quantisation": step > 0.5 * float(np.sqrt(np.median(scatter.variance))),
    }
    return Noise(
        gauges=source.gauges,
        covariance=covariance,
        inflation=inflation,
        scale=scale,
        lag1=lag1,
        kurtosis=kurtosis,
        step=step,
        stuck=tuple(name for name, is_stuck in zip(source.gauges, scatter.stuck, strict=True) if is_stuck),
        findings=tuple(name for name, is_there in found.items() if is_there),
        degrees=float(scatter.degrees[usable].mean()),
    )


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
        (n_gauges,) variance of one reading, as it scatters and drawn toward all gauges [microstrain^2].
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
    stuck = (own <= 1e-18) & (degrees > 0)
    usable = (degrees > 0) & ~stuck
    if not usable.any():
        raise DataError("no gauge shows any scatter between repeats; expected noise; the rows are copies of each other")
    variance = np.full_like(own, np.median(own[usable]))
    variance[usable] = _moderated(own[usable], degrees[usable])
    return _Scatter(tuple(r / np.sqrt(variance) for r in residuals), own, variance, degrees, usable, stuck)


def given_noise(gauges: tuple[str, ...], sd: float | Mapping[str, float]) -> Noise:
    """Return white noise of a known standard deviation [microstrain], of all gauges or by gauge.

    Raises
    ------
    DataError
        no positive number for some gauge.
    """
    wanted = [sd.get(name, float("nan")) if isinstance(sd, Mapping) else sd for name in gauges]
    for name, value in zip(gauges, wanted, strict=True):
        if not (np.isfinite(value) and value > 0.0):
            raise DataError(f"noise_sd of gauge {name} is {value}; expected a positive number in its unit; give it")
    covariance = np.diag(np.square(np.array(wanted, dtype=np.float64)))
    return Noise(gauges, covariance, 1.0, {}, 0.0, 0.0, 0.0, (), (), float("inf"))


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


def _shrunk(scaled: NDArray[np.float64], usable: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the shrunk correlation matrix; missing readings count as their mean, which only shrinks it further."""
    filled = np.where(np.isfinite(scaled), scaled, 0.0)[:, usable]
    matrix = np.eye(scaled.shape[1])
    if filled.shape[1] > 1:
        estimate = np.asarray(ledoit_wolf(filled, assume_centered=True)[0], dtype=np.float64)
        sd = np.sqrt(np.diag(estimate))
        matrix[np.ix_(usable, usable)] = estimate / np.outer(sd, sd)
    return matrix


def _serial(residuals: Sequence[NDArray[np.float64]], usable: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the lag-1 correlation and the inflation of the variance of means."""
    products, squares, pairs, cells = 0.0, 0.0, 0, 0
    long = [np.nan_to_num(r[:, usable]) for r in residuals if len(r) >= 8]
    for r in long:
        products += float(np.sum(r[1:] * r[:-1]))
        squares += float(np.sum(r * r))
        pairs += (len(r) - 1) * r.shape[1]
        cells += r.shape[1]
    if pairs == 0 or squares == 0.0:
        return 0.0, 1.0
    lag1 = products / squares + cells / pairs  # centring costs -1/N
    if lag1 < SIGNIFICANT / np.sqrt(pairs):
        return lag1, 1.0
    return lag1, max(1.0, (1.0 + lag1) / (1.0 - min(lag1, 0.95)), _batch_ratio(long))


def _batch_ratio(residuals: list[NDArray[np.float64]]) -> float:
    """Return the variance of batch means over what white noise would give; batches of the square root of N."""
    above, below = 0.0, 0.0
    for r in residuals:
        size = max(2, int(np.sqrt(len(r))))
        count = len(r) // size
        means = r[: count * size].reshape(count, size, -1).mean(axis=1)
        above += float(np.sum((means - means.mean(axis=0)) ** 2)) * size / (count - 1)
        below += float(np.sum(r**2)) / (len(r) - 1)
    return above / below


def _scales(
    campaign: Campaign, residuals: Sequence[NDArray[np.float64]], usable: NDArray[np.bool_]
) -> dict[Load, float]:
    """Return the variance ratio of each load to the whole where it is significant, else 1."""
    loads = [cell.load for cell in campaign.cells]
    squares: dict[Load, tuple[float, float]] = {}
    for load in sorted(set(loads), key=amounts_of):
        total, degrees = 0.0, 0.0
        for k in (k for k, own in enumerate(loads) if own == load):
            r = residuals[k][:, usable]
            total += float(np.nansum(r**2))
            degrees += float(np.maximum(np.isfinite(r).sum(axis=0) - 1, 0).sum())
        squares[load] = (total, degrees)
    whole = sum(t for t, _ in squares.values()) / max(1.0, sum(d for _, d in squares.values()))
    scale = {}
    for load, (total, degrees) in squares.items():
        ratio = total / degrees / whole if degrees > 0 else 1.0
        z = abs(np.log(max(ratio, 1e-12))) / np.sqrt(2.0 / max(degrees, 1.0))
        scale[load] = ratio if z > SIGNIFICANT and max(ratio, 1 / ratio) > SCALE_SIGNIFICANT else 1.0
    return scale


def _kurtosis(scaled: NDArray[np.float64]) -> tuple[float, bool]:
    values = scaled[np.isfinite(scaled)]
    excess = float(np.mean(values**4) / np.mean(values**2) ** 2 - 3.0)
    return excess, excess > max(0.5, SIGNIFICANT * np.sqrt(24.0 / values.size))


def _gauges_differ(scatter: _Scatter, kurtosis: float) -> bool:
    """Return whether some gauge is noisier than the others (maximum of log ratios, corrected for tails and number)."""
    variance, degrees = scatter.own[scatter.usable], scatter.degrees[scatter.usable]
    spread = np.sqrt((2.0 + max(0.0, kurtosis)) / np.maximum(degrees, 1))
    z = np.abs(np.log(variance / np.median(variance))) / spread
    return bool(z.max() > SIGNIFICANT + 0.5)


def _gauges_correlate(scaled: NDArray[np.float64]) -> bool:
    """Return whether readings of different gauges share noise: the mean squared correlation against 1/n."""
    filled = np.nan_to_num(scaled)
    n, g = filled.shape
    if g < 2:
        return False
    r = np.asarray(np.corrcoef(filled.T))[np.triu_indices(g, 1)]
    z = (float(np.sum(r**2)) * n - r.size) / np.sqrt(2.0 * r.size)
    return bool(z > 2 * SIGNIFICANT)


def quantisation_step(readings: NDArray[np.float64]) -> float:
    """Return the step [microstrain] that all readings are whole multiples of, 0 when there is none above 1e-6."""
    values = np.unique(np.round(readings[np.isfinite(readings)], 6))
    if len(values) < 3:
        return 0.0
    step = float(min(b - a for a, b in pairwise(values.tolist())))
    if step < 1e-5:
        return 0.0
    multiples = (values - values[0]) / step
    return (
        step
        if bool(np.all(np.abs(multiples - np.round(multiples)) < 1e-3 * np.maximum(1, np.abs(multiples) * 1e-3)))
        else 0.0
    )

"""The noise of a campaign estimated from its repeats.

Readings of one cell scatter about its mean. Pooled over cells the scatter gives the variance of every gauge, drawn
toward what all gauges have in common. In units of it the residuals are split into the directions v over the gauges
whose variance stands out of what independent gauges would give (a common mode, or one gauge that wanders), and the
rest; the scores f_k have a spectrum each, the rest has one:

    e_t = sum_k v_k f_kt + u_t.

scale(L) is the ratio of the scatter at load L to the pooled one, 1 unless it differs significantly.

Source: I. M. Johnstone (2001), "On the distribution of the largest eigenvalue in principal components analysis",
Annals of Statistics 29 (the greatest eigenvalue of independent gauges).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import digamma, polygamma
from scipy.stats import chi2

from octmip.errors import DataError
from octmip.gap.campaign.campaign import FEWEST_REPEATS, Campaign, Fault
from octmip.gap.campaign.noise import Noise, NoisePart
from octmip.gap.campaign.spectrum import SHARED, SHORTEST, SINGLE, WHITE, Serial, coefficients, fit
from octmip.twin import Load, amounts_of

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
    pooled = np.concatenate(blocks)
    found = _with_outstanding(found, pooled, len(pooled) / inflation)
    slow = [_slow(block, serial) for block in blocks if len(block) >= 2 * SHORTEST]
    return _with_outstanding(found, np.concatenate(slow), sum(map(len, slow))) if slow else found


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
    variance = float(np.mean((np.concatenate(blocks) @ direction) ** 2))
    pattern = np.outer(direction, direction)
    scores = [coefficients(block @ direction[:, None]) for block in blocks if len(block) >= SHORTEST]
    serial = fit(scores, SINGLE if is_single else SHARED, has_trend=not is_single)  # a drift of one gauge is an effect
    if serial is WHITE:
        return NoisePart(variance * pattern, WHITE)
    still = serial.walk == 0.0  # over many cells even a slow walk adds up: an improbable one is left out
    serial = serial.given(still) if still.any() and serial.walk_probability <= POSSIBLE else serial
    return NoisePart(serial.variance * pattern, serial)


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

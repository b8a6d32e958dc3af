"""The commissioning run as the culprit: a hypothesis beside all that may be wrong with the asset of today.

A run that was taken with a wrong load cell, crossed wires or an unseen damage accuses a sound asset of the opposite.
Campaign and run share the difference d of twin and asset; the twin alone says how large that usually is. So a wrong run
is a hypothesis beside all causes of the campaign, weighed by its evidence over both,

    r_run = phi d + s theta + noise,   r_campaign = phi d + noise,   d ~ N(0, l^2 K),

with s theta one effect of the library in the run only, or a state that is not as stated, or any pattern over the gauges
(a run of another asset, or of other gauges; the same pattern is weighed in the campaign). With d integrated out at
each level an effect has the Gram scalar s's - a'Qa and the projection s'r - a'Qh, a = Phi's, whitened by the noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.noise import Noise
from octmip.gap.inference.discrepancy import LEVEL_PRIOR, LEVELS, uncalibrated
from octmip.gap.inference.evidence import alike, fits_of
from octmip.gap.inference.inputs import Inputs, prepare
from octmip.gap.inference.linear_model import OPEN_STATE, STEP, LinearModel, linearise
from octmip.gap.inference.posterior import Posterior
from octmip.gap.odds import Odds
from octmip.twin import Effect

Floats = NDArray[np.float64]

OF_STATE, OF_EFFECT, OF_OTHER = 0.4, 0.4, 0.2
"""Shares of what may be wrong with a run: the state, one effect, all of it."""
FIELDS = (0.01, 0.03, 0.1)
"""Sd of any pattern over the scale of the readings."""
SILENT = 1e-250
"""Probability of a sound campaign below which the best single effect says how much better it is explained."""


@dataclass(frozen=True, slots=True)
class WrongRun:
    """How probable it is that the run is wrong and the asset sound.

    Attributes
    ----------
    probability
        of that, beside all that may be wrong with the asset.
    what
        the run's fault in words.
    """

    probability: float
    what: str


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Readings of a run or a campaign, whitened by all but d.

    Attributes
    ----------
    phi
        (n, n_gauges) pattern of d.
    signatures, tangents
        (n, n_candidates) of the effects, (n, n_parameters) of the state.
    residual
        (n,) of the twin without d.
    log_root
        log determinant of the noise's factor.
    """

    phi: Floats
    signatures: Floats
    tangents: Floats
    residual: Floats
    log_root: float


def wrong_run(
    posterior: Posterior,
    run: Campaign,
    effects: Mapping[str, Effect],
    noise_sd: float | Mapping[str, float] | None,
    odds: Odds,
) -> WrongRun:
    """Return how probable it is that a run is wrong and the asset of the campaign sound."""
    today = posterior.model
    kernels = _kernels(today.inputs)
    campaign = _part(today, today.inputs)
    before = _of_run(today, run, _difference(campaign, kernels), effects, noise_sd, odds)
    other = _with_own_walk(before, today.inputs, kernels)
    none = _levels([campaign, other], kernels)
    scale = today.inputs.discrepancy.scale
    outside = _log_prior(odds.unknown[:1], odds) + _with_field(campaign, [campaign, other], kernels, scale)
    gain = _log_gain(posterior, campaign, [campaign, other], kernels, today.inputs)
    right = float(np.logaddexp(_log(none) + gain, _log(none + outside)))
    single = _with_single(other, [campaign, other], kernels, before.inputs)
    weights = {
        "state": np.log(OF_STATE) + _log(none + _with_state(other, [campaign, other], kernels)),
        "effect": np.log(OF_EFFECT) + _log_sum(none, single),
        "other": np.log(OF_OTHER) + _log(none + _with_field(other, [campaign, other], kernels, scale)),
    }
    wrong = float(np.log(max(odds.wrong_run, 1e-300))) + float(logsumexp(list(weights.values())))
    probability = float(1.0 / (1.0 + np.exp(np.clip(right - wrong, -700.0, 700.0))))
    likeliest = max(weights, key=lambda name: weights[name])
    best = before.inputs.candidates[int(np.argmax(_logs(none, single)))]
    words = {
        "state": "its readings are those of another state than is stated",
        "effect": f"its readings are explained by an effect of that day: {best.words.replace('_', ' ')}",
        "other": "it is of another asset, or of gauges that were wired otherwise",
    }
    return WrongRun(probability, words[likeliest])


def _of_run(
    today: LinearModel,
    run: Campaign,
    difference: Floats,
    effects: Mapping[str, Effect],
    noise_sd: float | Mapping[str, float] | None,
    odds: Odds,
) -> LinearModel:
    """Return the model of the run as a campaign of its own, of the gauges of the campaign.

    What its effects change is taken from the twin with the `difference` (n_gauges,) that the campaign shows.
    """
    gauges = today.inputs.campaign.gauges
    readings = run.readings[:, [run.gauges.index(name) for name in gauges]]
    own = replace(run, gauges=gauges, readings=readings, units=())
    inputs, _ = prepare(own, today.inputs.twin, effects, None, noise_sd, odds=odds)
    states = np.array([cell.state for cell in inputs.campaign.cells])
    own_gauges = [gauges.index(name) for name in inputs.campaign.gauges]
    mean = today.inputs.share_of_reference(inputs.reference) * difference[own_gauges]
    return linearise(replace(inputs, discrepancy=replace(inputs.discrepancy, mean=mean)), states)


def _difference(campaign: _Part, kernels: list[Floats]) -> Floats:
    """Return the difference (n_gauges,) of twin and asset that a sound campaign shows by itself."""
    precision, projection = _sums([campaign])
    levels = _levels([campaign], kernels)
    kernel = kernels[int(np.argmax(levels + np.log(LEVEL_PRIOR)))]
    return np.asarray(np.linalg.solve(np.eye(len(kernel)) + kernel @ precision, kernel @ projection))


def _with_own_walk(before: LinearModel, of: Inputs, kernels: list[Floats]) -> _Part:
    """Return the readings of the run under the size of its own walk that explains them best."""
    variants = before.inputs.variants
    parts = [_part(before, of, variant.noise) for variant in variants]
    values = [_log(_levels([part], kernels)) + variant.log_share for part, variant in zip(parts, variants, strict=True)]
    return parts[int(np.argmax(values))]


def _kernels(inputs: Inputs) -> list[Floats]:
    prior = uncalibrated(inputs.twin, inputs.campaign.gauges, inputs.reference, inputs.odds.differences)
    return [prior.at(level).covariance for level in LEVELS]


def _part(model: LinearModel, of: Inputs, noise: Noise | None = None) -> _Part:
    """Return the readings of a model whitened, its discrepancy left out; gauges and reference are those `of` inputs.

    With another `noise` than the model's where one is given.
    """
    inputs, gauge = model.inputs, model.gauge
    known = inputs.discrepancy
    covariance = model.covariance - np.outer(model.share, model.share) * known.covariance[np.ix_(gauge, gauge)]
    if noise is not None:
        rows = (inputs.averages, inputs.loads, model.average, gauge)
        covariance += noise.of_averages(*rows) - inputs.noise.of_averages(*rows)
    root = np.linalg.cholesky(0.5 * (covariance + covariance.T))
    phi = np.array([of.share_of_reference(load) for load in inputs.loads])[model.average]
    number = np.array([of.campaign.gauges.index(name) for name in inputs.campaign.gauges])[gauge]
    pattern = phi[:, None] * (number[:, None] == np.arange(len(of.campaign.gauges)))
    residual = model.residual + model.share * known.mean[gauge]
    columns = np.column_stack([pattern, model.signatures, _tangents(model), residual])
    white = linalg.solve_triangular(root, columns, lower=True)
    n_gauges, n_candidates = pattern.shape[1], model.signatures.shape[1]
    patterns, signatures, tangents = np.split(white[:, :-1], [n_gauges, n_gauges + n_candidates], axis=1)
    return _Part(patterns, signatures, tangents, white[:, -1], float(np.log(np.diag(root)).sum()))


def _tangents(model: LinearModel) -> Floats:
    """Return what each state parameter, the same in all tests, changes in every row (n, n_parameters)."""
    inputs, order = model.inputs, list(model.inputs.order)
    columns = np.zeros((len(inputs.averages), len(order), len(inputs.names)))
    for k, average in enumerate(inputs.averages):
        load, state = inputs.loads[k], model.states[average.cell]
        now, *ahead = inputs.twin.predict_states(np.vstack([state, state + STEP * np.eye(len(state))]), load)
        columns[k] = ((np.array(ahead).reshape(len(state), len(now)) - now) / STEP)[:, order].T
    return columns[model.average, model.gauge]


def _levels(parts: list[_Part], kernels: list[Floats]) -> Floats:
    """Return the log evidence (n_levels,) of readings that share one d, with nothing else."""
    precision, projection = _sums(parts)
    squared = sum(float(part.residual @ part.residual) for part in parts)
    constant = -0.5 * squared - sum(part.log_root for part in parts)
    found = []
    for kernel in kernels:
        grown = np.eye(len(kernel)) + kernel @ precision
        mean = np.linalg.solve(grown, kernel @ projection)
        found.append(constant + 0.5 * float(projection @ mean) - 0.5 * float(np.linalg.slogdet(grown)[1]))
    return np.array(found)


def _sums(parts: list[_Part]) -> tuple[Floats, Floats]:
    precision = np.sum([part.phi.T @ part.phi for part in parts], axis=0)
    projection = np.sum([part.phi.T @ part.residual for part in parts], axis=0)
    return precision, projection


def _conditional(columns: Floats, own: _Part, parts: list[_Part], kernel: Floats) -> tuple[Floats, Floats]:
    """Return Gram matrix and projection of whitened columns (n, m) of one part, d of all parts integrated out."""
    precision, projection = _sums(parts)
    across = own.phi.T @ columns
    solved = np.linalg.solve(np.eye(len(kernel)) + kernel @ precision, kernel @ np.column_stack([across, projection]))
    gram = columns.T @ columns - across.T @ solved[:, :-1]
    return gram, columns.T @ own.residual - across.T @ solved[:, -1]


def _with_single(own: _Part, parts: list[_Part], kernels: list[Floats], inputs: Inputs) -> Floats:
    """Return what each single effect that acts in one part adds to the log evidence (n_levels, n_candidates)."""
    prior = inputs.priors
    found = np.zeros((len(kernels), len(prior.mean)))
    for row, kernel in zip(found, kernels, strict=True):
        gram, projection = _conditional(own.signatures, own, parts, kernel)
        for group in alike(prior, [(j,) for j in range(len(row))]):
            index = [members[0] for members in group]
            lengths = np.maximum(np.diag(gram)[index], 0.0)[:, None, None]
            row[index] = [fit.log_factor for fit in fits_of(prior, group, lengths, projection[index][:, None])]
    return np.asarray(found + prior.log_weight - np.log(max(prior.n_effects, 1)))


def _with_state(own: _Part, parts: list[_Part], kernels: list[Floats]) -> Floats:
    """Return what another state than is stated, in one part, adds to the log evidence (n_levels,)."""
    n = own.tangents.shape[1]
    return (
        _with_columns(own.tangents, np.full(n, OPEN_STATE), own, parts, kernels)
        if n
        else np.full(len(kernels), -np.inf)
    )


def _with_field(own: _Part, parts: list[_Part], kernels: list[Floats], scale: Floats) -> Floats:
    """Return what a pattern of any shape over the gauges, in one part, adds to the log evidence (n_levels,)."""
    found = [_with_columns(own.phi, size * scale, own, parts, kernels) for size in FIELDS]
    return np.asarray(logsumexp(found, axis=0) - np.log(len(FIELDS)))


def _with_columns(columns: Floats, sd: Floats, own: _Part, parts: list[_Part], kernels: list[Floats]) -> Floats:
    """Return what whitened columns (n, m) with weights of these sd (m,) add to the log evidence (n_levels,)."""
    found = []
    for kernel in kernels:
        gram, projection = _conditional(columns, own, parts, kernel)
        inner = gram + np.diag(sd**-2.0)
        log_det = float(np.linalg.slogdet(inner)[1]) + 2.0 * float(np.log(sd).sum())
        found.append(0.5 * float(projection @ np.linalg.solve(inner, projection)) - 0.5 * log_det)
    return np.array(found)


def _log_gain(posterior: Posterior, own: _Part, parts: list[_Part], kernels: list[Floats], inputs: Inputs) -> float:
    """Return the log of how much better all that may be wrong with the asset explains it than nothing, with priors.

    It is what the posterior says, or what single effects alone do, where that is more.
    """
    nothing = sum(h.probability for h in posterior.judged if not h.members and not h.has_unknown and not h.doubted)
    none, count = _levels(parts, kernels), np.log(np.maximum(inputs.odds.count, 1e-300))
    single = _log_sum(none, _with_single(own, parts, kernels, inputs)) - _log(none) + float(count[1:2].sum() - count[0])
    return max(single, -float(np.log(max(nothing, SILENT))))


def _log_sum(none: Floats, added: Floats) -> float:
    """Return the log of the evidence summed over what each of (n_levels, n_candidates) adds."""
    return float(logsumexp(_logs(none, added))) if added.size else -np.inf


def _logs(none: Floats, added: Floats) -> Floats:
    """Return `_log` of the evidence (n_levels,) with each of (n_levels, n_candidates) added (n_candidates,)."""
    return np.asarray(logsumexp((none + np.log(LEVEL_PRIOR))[:, None] + added, axis=0))


def _log_prior(probabilities: tuple[float, ...], odds: Odds) -> float:
    """Return the log of a prior probability over that of nothing."""
    return float(np.log(max(sum(probabilities), 1e-300)) - np.log(odds.count[0]))


def _log(levels: Floats) -> float:
    """Return the log of evidence (n_levels,) summed over levels with their prior."""
    return float(logsumexp(levels + np.log(LEVEL_PRIOR)))

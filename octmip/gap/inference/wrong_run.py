"""The one hypothesis under which something acts in the commissioning run: the run was wrong, the asset is sound.

A calibration hides whatever was wrong on its day, and accuses the sound asset of the opposite. Three things may have
been wrong: an effect of the library acted, the state was not as stated, or the readings are of another asset. The first
two are columns s over the run's rows; with X = L_r^-1 K_rc, a = L_r^-1 s and L_r, L_c the factors of the run's
covariance and of the campaign's given the run, the column of the stack of both is [a, -L_c^-1 X' a], and its evidence
that of any candidate. Another asset differs by `OTHER_LEVELS`, while the campaign is as the twin says.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.campaign.campaign import Cell
from octmip.gap.effects.words import words_at
from octmip.gap.inference.candidates import SCALES
from octmip.gap.inference.difference import ALL_GAUGES
from octmip.gap.inference.evidence import single_logs
from octmip.gap.inference.inputs import Inputs, Run, relearnt
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.posterior import levels_without_run
from octmip.gap.inference.signatures import signatures_of
from octmip.gap.inference.states import grid, highest
from octmip.gap.inference.whitening import log_normal
from octmip.twin import Effect

Floats = NDArray[np.float64]

OTHER_LEVELS = (4.0, 8.0)
"""Levels of the difference of another asset."""
NODE_SPREAD = 0.15
"""Relative sd of what a state changes about what the nearest node of the grid does."""
SHARES = {"effect": 0.5, "state": 0.25, "asset": 0.25}
"""Of the probability that a run was wrong, by what was wrong with it."""


@dataclass(frozen=True, slots=True, eq=False)
class WrongRun:
    """What was wrong with a run, if it was.

    Attributes
    ----------
    log_weight
        log of prior times evidence of a sound asset beside a wrong run, all three kinds together.
    words
        the most probable of them.
    correction, spread, own_spread
        (n,) what it added to the run's readings, and one standard deviation of it: of the whole, and beside that of
        each gauge by itself; None of another asset.
    log_usual
        what a right run gains, too, where the difference is allowed to be the usual one: logs of evidences compared
        must be under the same alternatives.
    """

    log_weight: float
    words: str
    correction: Floats | None
    spread: Floats | None
    own_spread: Floats | None
    log_usual: float = 0.0


def weigh_wrong_run(model: LinearModel) -> WrongRun:
    """Return the hypothesis that the run was wrong, about the model of a campaign beside it."""
    inputs, run = model.inputs, model.inputs.run
    assert run is not None
    prior = float(np.log(max(inputs.odds.wrong_run, 1e-300))) + float(np.log(inputs.odds.count[0]))
    good = replace(inputs, difference=inputs.usual)  # beside a wrong run the twin may well be good
    models = [model, *(replace(model, inputs=good).under(level) for level in (1.0, 2.0))]
    columns = {_by_effect: _of_effects(inputs, run), _by_state: _of_states(inputs, run)}
    found = [part(one, columns[part]) for part in columns for one in models]
    shares = [SHARES[k] / len(models) for k in ("effect", "state") for _ in models]
    found.append(_by_asset(model, run))
    shares.append(SHARES["asset"])
    found = [replace(p, log_weight=p.log_weight + prior + float(np.log(s))) for p, s in zip(found, shares, strict=True)]
    best = max(found, key=lambda p: p.log_weight)
    log_usual = float(logsumexp([one.log_none for one in models])) - float(np.log(len(models))) - model.log_none
    return replace(best, log_weight=float(logsumexp([p.log_weight for p in found])), log_usual=max(0.0, log_usual))


def corrected(inputs: Inputs, wrong: WrongRun) -> Inputs:
    """Return the inputs with what was wrong taken off the run, or without the run where it is of another asset."""
    run = inputs.run
    if wrong.correction is None or wrong.spread is None or wrong.own_spread is None or run is None:
        return replace(inputs, run=None, difference=inputs.usual)
    means = replace(run.means, measured=run.means.measured - wrong.correction)
    same = run.means.gauge[:, None] == run.means.gauge
    added = np.outer(wrong.spread, wrong.spread) + same * np.outer(wrong.own_spread, wrong.own_spread)
    # what was wrong may have looked like a walk: every noise stays open
    noises = tuple(replace(one, covariance=one.covariance + added) for one in run.noises)
    return relearnt(inputs, replace(run, means=means, noises=noises))


def _weighed(model: LinearModel, columns: Floats) -> tuple[Floats, Floats]:
    """Return squared lengths and projections (k,) of columns (n_run, k) in run and campaign together."""
    given, run = model.given, model.inputs.run
    assert given.of_run is not None
    assert given.across is not None
    assert run is not None
    a = given.of_run.of_columns(columns)
    b = -model.whiten(given.across.T @ a)
    lengths = np.einsum("ij,ij->j", a, a) + np.einsum("ij,ij->j", b, b)
    return lengths, a.T @ given.of_run.of_columns(run.residual) + b.T @ model.left


def _of_effects(inputs: Inputs, run: Run) -> Floats:
    """Return what every candidate changes in the run's readings (n_run, n_candidates)."""
    as_campaign = replace(inputs, campaign=run.campaign, averages=run.averages, groups=(), run=None)
    flat = run.means.average * len(inputs.order) + run.means.gauge
    return np.asarray(signatures_of(as_campaign, _states(run, inputs), run.means.expected)[:, flat].T)


def _of_states(inputs: Inputs, run: Run) -> Floats:
    """Return what another state than the stated one changes in the run's readings (n_run, n_nodes), by node."""
    columns = np.array([_changed(inputs, run.averages, node) - run.means.expected for node in _nodes(inputs)])
    return columns[:, run.means.average, run.means.gauge].T if len(columns) else np.zeros((len(run.residual), 0))


def _nodes(inputs: Inputs) -> Floats:
    """Return the states (n_nodes, n_parameters) that are not sound; none where none is looked for."""
    if not inputs.names or not (highest(inputs) > 0.0).any():
        return np.zeros((0, len(inputs.names)))
    nodes = grid(len(inputs.names))
    return np.asarray(nodes[(nodes <= highest(inputs)).all(axis=1) & (nodes > 0.0).any(axis=1)])


def _by_effect(model: LinearModel, columns: Floats) -> WrongRun:
    """Return the run with an effect of the library in it."""
    inputs, run = model.inputs, model.inputs.run
    assert run is not None
    lengths, projection = _weighed(model, columns)
    logs = np.logaddexp.reduce(single_logs(inputs.priors, lengths, projection), axis=0) - np.log(len(SCALES))
    logs += inputs.priors.log_weight - np.log(max(inputs.priors.n_effects, 1))
    logs[[getattr(one.effect, "uses_time", False) for one in inputs.candidates]] = -np.inf  # it wanders
    built = getattr(inputs.twin.twin, "constants", {})
    logs[[one.name in built for one in inputs.candidates]] = -np.inf  # then the asset was built so
    logs[[one.is_nameless for one in inputs.candidates]] = -np.inf  # too rare
    if not len(logs):
        return WrongRun(-np.inf, "", None, None, None)
    best = int(np.argmax(logs))
    prior_sd = inputs.priors.sd[best]
    precision = lengths[best] + (3.0 * prior_sd) ** -2
    size = projection[best] / precision if not inputs.priors.is_discrete[best] else inputs.priors.mean[best]
    chosen = inputs.candidates[best]
    effect: Effect = chosen.effect
    words = f"{words_at(effect, inputs.twin, chosen.place).name}, {size:.3g} {effect.unit}, acted while it was taken"
    total = model.log_none + float(logsumexp(logs))
    gauges = [inputs.order[k] for k in run.means.gauge.tolist()]
    share = np.broadcast_to(chosen.signature_errors, len(inputs.twin.gauges))[gauges]
    correction = size * columns[:, best]
    return WrongRun(total, words, correction, precision**-0.5 * columns[:, best], share * correction)


def _by_state(model: LinearModel, columns: Floats) -> WrongRun:
    """Return the run with another state than it says, the same in all its cells."""
    inputs, nodes = model.inputs, _nodes(model.inputs)
    if not len(nodes):
        return WrongRun(-np.inf, "", None, None, None)
    lengths, projection = _weighed(model, columns)
    precision = lengths + NODE_SPREAD**-2
    sizes = (projection + NODE_SPREAD**-2) / precision  # between nodes: the column of one, somewhat longer or shorter
    logs = 0.5 * (sizes**2 * precision - NODE_SPREAD**-2 - np.log(precision * NODE_SPREAD**2)) - np.log(len(nodes))
    best = int(np.argmax(logs))
    there = sizes[best] * nodes[best]
    shown = ", ".join(f"{name} {value:.2f}" for name, value in zip(inputs.names, there, strict=True))
    total = model.log_none + float(logsumexp(logs))
    correction = sizes[best] * columns[:, best]
    common, own = np.sqrt(ALL_GAUGES), np.sqrt(1.0 - ALL_GAUGES)
    spread = inputs.difference.usual.damage * correction
    words = f"its readings are those of the state {shown}"
    return WrongRun(total, words, correction, common * spread, own * spread)


def _changed(inputs: Inputs, cells: Sequence[Cell], node: Floats) -> Floats:
    named = inputs.named(node)
    return np.array([inputs.twin.predict(named, cell.load)[list(inputs.order)] for cell in cells])


def _by_asset(model: LinearModel, run: Run) -> WrongRun:
    """Return the run of another asset, beside a campaign that is judged without it."""
    inputs, usual, rows = model.inputs, model.inputs.usual, run.means.rows
    logs = [log_normal(run.noise + usual.at(level).covariance(rows, rows), run.residual) for level in OTHER_LEVELS]
    log_run = float(logsumexp(logs)) - float(np.log(len(logs)))
    alone = replace(model, inputs=replace(inputs, run=None, difference=usual))
    of_levels = [alone.under(level).log_none + np.log(p) for level, p in levels_without_run(inputs).items()]
    total = float(logsumexp(of_levels)) + log_run
    return WrongRun(total, "it differs from the asset of today as another asset would", None, None, None)


def _states(run: Run, inputs: Inputs) -> Floats:
    columns = [run.campaign.parameters.index(name) for name in inputs.names]
    return np.array([cell.state for cell in run.campaign.cells])[:, columns]

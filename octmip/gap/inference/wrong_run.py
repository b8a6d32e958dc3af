"""The one hypothesis under which something acts in the commissioning run: the run was wrong, the asset is sound.

A calibration hides whatever was wrong on its day, and accuses the sound asset of the opposite. Three things may have
been wrong: an effect of the library acted, the state was not as stated, or the readings are of another asset. The first
two are columns over the rows of run and campaign together, 0 in the campaign, with the evidence of any candidate.
Another asset differs by `OTHER_LEVELS`, while the campaign is as the twin says.

Constants that such a run says are wrong themselves. About the drawing they are open: with m what that reads more than
the model by the run, and K the columns of a prior sd of each, the rows r of both are N(m, C + K K') and not N(0, C). A
right run has the same factor over its own rows, about its own constants.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.campaign.campaign import Cell
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.effects.words import words_at
from octmip.gap.inference.candidates import SCALES
from octmip.gap.inference.difference import Difference
from octmip.gap.inference.evidence import last_added
from octmip.gap.inference.inputs import Inputs, Run, levels_without_run
from octmip.gap.inference.linear_model import OPEN_STATE, LinearModel
from octmip.gap.inference.signatures import signatures_of
from octmip.gap.inference.states import grid, highest
from octmip.gap.inference.whitening import Whitening, log_normal

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
    log_usual
        what a right run gains, too, where the difference is allowed to be the usual one and constants are open: logs
        of evidences compared must be under the same alternatives.
    """

    log_weight: float
    words: str
    log_usual: float = 0.0


def weigh_wrong_run(model: LinearModel) -> WrongRun:
    """Return the hypothesis that the run was wrong, about the model of a campaign beside it."""
    inputs, run, usual = model.inputs, model.inputs.run, model.inputs.usual
    assert run is not None
    nodes, states = _nodes(inputs), _states(run, inputs)
    columns = np.column_stack([_of_effects(inputs, run, states), _of_states(inputs, run, nodes)])
    slopes = [_slopes(inputs, run.averages, states, run.rows.average, run.rows.gauge)]
    slopes += [_slopes(inputs, inputs.averages, model.states, model.average, model.gauge)]
    differences = (inputs.difference.at(model.level), usual, usual.at(2.0))  # the twin may well be good
    found, log_right = list[WrongRun](), list[float]()
    for difference in differences:
        log_wrong, right, lengths, projection = _weighed(model, run, difference, np.concatenate(slopes), columns)
        n = len(inputs.candidates)
        kinds = {"effect": _by_effect(inputs, lengths[:n], projection[:n])}
        kinds["state"] = _by_state(inputs, nodes, lengths[n:], projection[n:])
        found += [
            replace(one, log_weight=one.log_weight + log_wrong + float(np.log(SHARES[kind] / len(differences))))
            for kind, one in kinds.items()
        ]
        log_right.append(right)
    found.append(_by_asset(model, run, log_right[0] - model.log_none + float(np.log(SHARES["asset"]))))
    prior = float(np.log(max(inputs.odds.wrong_run, 1e-300))) + float(np.log(inputs.odds.count[0]))
    log_usual = max(log_right[0], float(logsumexp(log_right)) - float(np.log(len(log_right)))) - model.log_none
    words = max(found, key=lambda one: one.log_weight).words
    return WrongRun(prior + float(logsumexp([one.log_weight for one in found])), words, log_usual)


def _weighed(
    model: LinearModel, run: Run, difference: Difference, slopes: Floats, columns: Floats
) -> tuple[float, float, Floats, Floats]:
    """Return log evidences of no effect, and squared lengths and projections (k,) of columns in the whitened rows.

    The first evidence has constants that follow all rows, the second those that follow the run's alone.

    Parameters
    ----------
    slopes
        (n_run + n, n_constants) what a prior sd of each constant changes in the rows of run and campaign.
    columns
        (n_run, k) what the run alone has.
    """
    own, n = model.inputs.twin.twin, len(run.rows.residual)
    rows = (run.rows, model.rows)
    covariance = np.block([[difference.covariance(a, b) for b in rows] for a in rows])
    covariance[:n, :n] += run.noise
    covariance[n:, n:] += model.noise + OPEN_STATE**2 * model.tangents @ model.tangents.T
    residual = np.append(run.rows.residual, model.rows.residual)
    departures = own.departures.values() if isinstance(own, FunctionTwin) else ()
    left = residual - slopes @ np.array([gone / sd for gone, sd in departures])
    opened = covariance + slopes @ slopes.T
    of_run = log_normal(opened[:n, :n], left[:n]) - log_normal(covariance[:n, :n], residual[:n])
    whitening = Whitening.of(opened)
    white, rest = whitening.of_columns(np.pad(columns, ((0, model.n), (0, 0)))), whitening.of_columns(left)
    log_right = log_normal(covariance, residual) + of_run
    return whitening.log_density(rest), log_right, np.einsum("ij,ij->j", white, white), white.T @ rest


def _slopes(
    inputs: Inputs, averages: Sequence[Cell], states: Floats, average: NDArray[np.int64], gauge: NDArray[np.int64]
) -> Floats:
    """Return what a prior sd of each constant changes in some means (n, k)."""
    asked = [(inputs.named(states[part.number]), part.load) for part in averages]
    return np.array([inputs.frame.slopes(*one) for one in asked])[average, gauge]


def _states(run: Run, inputs: Inputs) -> Floats:
    columns = [run.campaign.parameters.index(name) for name in inputs.names]
    return np.array([cell.state for cell in run.campaign.cells])[:, columns]


def _of_effects(inputs: Inputs, run: Run, states: Floats) -> Floats:
    """Return what every candidate changes in the run's readings (n_run, n_candidates)."""
    as_campaign = replace(inputs, campaign=run.campaign, averages=run.averages, groups=(), run=None)
    flat = run.rows.average * len(inputs.order) + run.rows.gauge
    return np.asarray(signatures_of(as_campaign, states, np.zeros((len(run.averages), len(inputs.order))))[:, flat].T)


def _of_states(inputs: Inputs, run: Run, nodes: Floats) -> Floats:
    """Return what another state than the stated one changes in the run's readings (n_run, n_nodes), by node."""
    order, found = list(inputs.order), np.zeros((len(run.rows.residual), len(nodes)))
    for k, node in enumerate(nodes):
        there = np.array([inputs.twin.predict(inputs.named(node), cell.load)[order] for cell in run.averages])
        found[:, k] = there[run.rows.average, run.rows.gauge] - run.rows.predicted
    return found


def _nodes(inputs: Inputs) -> Floats:
    """Return the states (n_nodes, n_parameters) that are not sound; none where none is looked for."""
    if not inputs.names or not (highest(inputs) > 0.0).any():
        return np.zeros((0, len(inputs.names)))
    nodes = grid(len(inputs.names))
    return np.asarray(nodes[(nodes <= highest(inputs)).all(axis=1) & (nodes > 0.0).any(axis=1)])


def _by_effect(inputs: Inputs, lengths: Floats, projection: Floats) -> WrongRun:
    """Return the run with an effect of the library in it."""
    if not len(lengths):
        return WrongRun(-np.inf, "")
    priors, built = inputs.priors, getattr(inputs.twin.twin, "constants", {})
    logs = last_added(priors, np.arange(len(lengths))[:, None], lengths[:, None, None], projection[:, None])
    logs += priors.log_weight - np.log(max(priors.n_effects, 1))
    for j, one in enumerate(inputs.candidates):
        wanders, is_built = getattr(one.effect, "uses_time", False), one.name in built  # the asset was built so
        if wanders or is_built or one.is_nameless or one.test:  # too rare; another day
            logs[j] = -np.inf
    best = int(np.argmax(logs))
    size = projection[best] / (lengths[best] + (SCALES[-1] * priors.sd[best]) ** -2)
    size = priors.mean[best] if priors.is_discrete[best] else size
    chosen = inputs.candidates[best]
    named = words_at(chosen.effect, inputs.twin, chosen.place).name
    words = f"{named}, {size:.3g} {chosen.effect.unit}, acted while it was taken"
    return WrongRun(float(logsumexp(logs)), words)


def _by_state(inputs: Inputs, nodes: Floats, lengths: Floats, projection: Floats) -> WrongRun:
    """Return the run with another state than it says, the same in all its cells."""
    if not len(nodes):
        return WrongRun(-np.inf, "")
    precision = lengths + NODE_SPREAD**-2
    sizes = (projection + NODE_SPREAD**-2) / precision  # between nodes: the column of one, somewhat longer or shorter
    logs = 0.5 * (sizes**2 * precision - NODE_SPREAD**-2 - np.log(precision * NODE_SPREAD**2)) - np.log(len(nodes))
    best = int(np.argmax(logs))
    there = sizes[best] * nodes[best]
    shown = ", ".join(f"{name} {value:.2f}" for name, value in zip(inputs.names, there, strict=True))
    return WrongRun(float(logsumexp(logs)), f"its readings are those of the state {shown}")


def _by_asset(model: LinearModel, run: Run, log_share: float) -> WrongRun:
    """Return the run of another asset, beside a campaign that is judged without it."""
    inputs, usual, rows = model.inputs, model.inputs.usual, run.rows
    logs = [log_normal(run.noise + usual.at(level).covariance(rows, rows), run.rows.residual) for level in OTHER_LEVELS]
    alone = replace(model, inputs=replace(inputs, run=None, difference=usual))
    of_levels = [alone.under(level).log_none + np.log(p) for level, p in levels_without_run(inputs).items()]
    total = float(logsumexp(of_levels)) + float(logsumexp(logs)) - float(np.log(len(logs))) + log_share
    return WrongRun(total, "it differs from the asset of today as another asset would")

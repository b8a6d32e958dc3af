"""The one hypothesis under which something acts in the commissioning run: the run was wrong, the asset is sound.

A calibration hides whatever was wrong on its day, and accuses the sound asset of the opposite. Three things may have
been wrong: an effect of the library acted, the state was not as stated, or the readings are of another asset. The first
two are columns s over the run's rows; with X = L_r^-1 K_rc, a = L_r^-1 s and L_r, L_c the factors of the run's
covariance and of the campaign's given the run, the column of the stack of both is [a, -L_c^-1 X' a], and its evidence
that of any candidate. Another asset differs by `OTHER_LEVELS`, while the campaign is as the twin says.

Constants that such a run says are wrong themselves. About the drawing they are open: with m what that reads more than
the model by the run, and C the columns of a prior sd of each, the rows r of both have the evidence of N(m, I + C C') in
place of N(0, I). A right run has the same factor over its own rows, about its own constants.
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
from octmip.gap.inference.evidence import single_logs
from octmip.gap.inference.inputs import Inputs, Run, levels_without_run
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.rows import Means
from octmip.gap.inference.signatures import signatures_of
from octmip.gap.inference.states import grid, highest
from octmip.gap.inference.whitening import Whitening, log_normal
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
    log_usual
        what a right run gains, too, where the difference is allowed to be the usual one and constants are open: logs
        of evidences compared must be under the same alternatives.
    """

    log_weight: float
    words: str
    log_usual: float = 0.0


def weigh_wrong_run(model: LinearModel) -> WrongRun:
    """Return the hypothesis that the run was wrong, about the model of a campaign beside it."""
    inputs, run = model.inputs, model.inputs.run
    assert run is not None
    prior = float(np.log(max(inputs.odds.wrong_run, 1e-300))) + float(np.log(inputs.odds.count[0]))
    good = replace(inputs, difference=inputs.usual)  # beside a wrong run the twin may well be good
    models = [model, *(replace(model, inputs=good).under(level) for level in (1.0, 2.0))]
    own = inputs.twin.twin
    away = np.array([gone / sd for gone, sd in own.departures.values()] if isinstance(own, FunctionTwin) else [])
    in_run = _slopes(inputs, run.averages, run.means, _states(run, inputs))
    in_campaign = _slopes(inputs, inputs.averages, model.means, model.states)
    stacks = [_Stack.of(one, in_run, in_campaign, away) for one in models]
    columns = {_by_effect: _of_effects(inputs, run), _by_state: _of_states(inputs, run)}
    found = [part(one, columns[part]) for part in columns for one in stacks]
    shares = [SHARES[k] / len(models) for k in ("effect", "state") for _ in models]
    found.append(_by_asset(stacks[0]))
    shares.append(SHARES["asset"])
    found = [replace(p, log_weight=p.log_weight + prior + float(np.log(s))) for p, s in zip(found, shares, strict=True)]
    best = max(found, key=lambda p: p.log_weight)
    log_right = [one.model.log_none + one.log_of_run for one in stacks]
    log_usual = max(log_right[0], float(logsumexp(log_right)) - float(np.log(len(models)))) - model.log_none
    return replace(best, log_weight=float(logsumexp([p.log_weight for p in found])), log_usual=log_usual)


@dataclass(frozen=True, slots=True, eq=False)
class _Stack:
    """The rows of run and campaign, whitened over constants that are open.

    Attributes
    ----------
    model
        of the campaign beside the run.
    whitening
        of the rows that the model whitens, by I + C C'.
    left
        (n_rows,) readings less what the drawing says.
    log_of_both, log_of_run
        what open constants add to the log evidence of no effect, where they follow all rows and the run's alone.
    """

    model: LinearModel
    whitening: Whitening
    left: Floats
    log_of_both: float
    log_of_run: float

    @classmethod
    def of(cls, model: LinearModel, in_run: Floats, in_campaign: Floats, departures: Floats) -> "_Stack":
        """Return that of columns (n_run, k) and (n, k) of k constants, and the drawing's values (k,) in prior sds."""
        given, run = model.given, model.inputs.run
        assert given.of_run is not None
        assert run is not None
        constants = _stacked(model, in_run, in_campaign)
        rest = np.concatenate([given.of_run.of_columns(run.residual), model.left])
        left, open_ = rest - constants @ departures, np.eye(len(rest)) + constants @ constants.T
        added = [
            log_normal(open_[:n, :n], left[:n]) - log_normal(np.eye(n), rest[:n]) for n in (len(rest), len(in_run))
        ]
        whitening = Whitening.of(open_)
        return cls(model, whitening, whitening.of_columns(left), *added)

    @property
    def run(self) -> Run:
        """The run."""
        assert self.model.inputs.run is not None
        return self.model.inputs.run

    def weighed(self, columns: Floats) -> tuple[Floats, Floats]:
        """Return squared lengths and projections (k,) of columns (n_run, k) that the run alone has."""
        both = _stacked(self.model, columns, np.zeros((self.model.n, columns.shape[1])))
        own = self.whitening.of_columns(both)
        return np.einsum("ij,ij->j", own, own), own.T @ self.left


def _slopes(inputs: Inputs, averages: Sequence[Cell], means: Means, states: Floats) -> Floats:
    """Return what a prior sd of each constant changes in some means (n, k)."""
    asked = [(inputs.named(states[part.number]), part.load) for part in averages]
    return np.array([inputs.frame.slopes(*one) for one in asked])[means.average, means.gauge]


def _stacked(model: LinearModel, in_run: Floats, in_campaign: Floats) -> Floats:
    """Return columns of run and campaign, whitened (n_run + n, k)."""
    given = model.given
    assert given.of_run is not None
    assert given.across is not None
    of_run = given.of_run.of_columns(in_run)
    return np.concatenate([of_run, model.whiten(in_campaign - given.across.T @ of_run)])


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


def _by_effect(stack: _Stack, columns: Floats) -> WrongRun:
    """Return the run with an effect of the library in it."""
    inputs = stack.model.inputs
    lengths, projection = stack.weighed(columns)
    logs = np.logaddexp.reduce(single_logs(inputs.priors, lengths, projection), axis=0) - np.log(len(SCALES))
    logs += inputs.priors.log_weight - np.log(max(inputs.priors.n_effects, 1))
    logs[[getattr(one.effect, "uses_time", False) for one in inputs.candidates]] = -np.inf  # it wanders
    built = getattr(inputs.twin.twin, "constants", {})
    logs[[one.name in built for one in inputs.candidates]] = -np.inf  # then the asset was built so
    logs[[one.is_nameless or bool(one.test) for one in inputs.candidates]] = -np.inf  # too rare; another day
    if not len(logs):
        return WrongRun(-np.inf, "")
    best = int(np.argmax(logs))
    prior_sd = inputs.priors.sd[best]
    precision = lengths[best] + (3.0 * prior_sd) ** -2
    size = projection[best] / precision if not inputs.priors.is_discrete[best] else inputs.priors.mean[best]
    chosen = inputs.candidates[best]
    effect: Effect = chosen.effect
    words = f"{words_at(effect, inputs.twin, chosen.place).name}, {size:.3g} {effect.unit}, acted while it was taken"
    return WrongRun(stack.model.log_none + stack.log_of_both + float(logsumexp(logs)), words)


def _by_state(stack: _Stack, columns: Floats) -> WrongRun:
    """Return the run with another state than it says, the same in all its cells."""
    inputs, nodes = stack.model.inputs, _nodes(stack.model.inputs)
    if not len(nodes):
        return WrongRun(-np.inf, "")
    lengths, projection = stack.weighed(columns)
    precision = lengths + NODE_SPREAD**-2
    sizes = (projection + NODE_SPREAD**-2) / precision  # between nodes: the column of one, somewhat longer or shorter
    logs = 0.5 * (sizes**2 * precision - NODE_SPREAD**-2 - np.log(precision * NODE_SPREAD**2)) - np.log(len(nodes))
    best = int(np.argmax(logs))
    there = sizes[best] * nodes[best]
    shown = ", ".join(f"{name} {value:.2f}" for name, value in zip(inputs.names, there, strict=True))
    words = f"its readings are those of the state {shown}"
    return WrongRun(stack.model.log_none + stack.log_of_both + float(logsumexp(logs)), words)


def _changed(inputs: Inputs, cells: Sequence[Cell], node: Floats) -> Floats:
    named = inputs.named(node)
    return np.array([inputs.twin.predict(named, cell.load)[list(inputs.order)] for cell in cells])


def _by_asset(stack: _Stack) -> WrongRun:
    """Return the run of another asset, beside a campaign that is judged without it."""
    model, run = stack.model, stack.run
    inputs, usual, rows = model.inputs, model.inputs.usual, run.means.rows
    logs = [log_normal(run.noise + usual.at(level).covariance(rows, rows), run.residual) for level in OTHER_LEVELS]
    log_run = float(logsumexp(logs)) - float(np.log(len(logs)))
    alone = replace(model, inputs=replace(inputs, run=None, difference=usual))
    of_levels = [alone.under(level).log_none + np.log(p) for level, p in levels_without_run(inputs).items()]
    total = float(logsumexp(of_levels)) + log_run + stack.log_of_run
    return WrongRun(total, "it differs from the asset of today as another asset would")


def _states(run: Run, inputs: Inputs) -> Floats:
    columns = [run.campaign.parameters.index(name) for name in inputs.names]
    return np.array([cell.state for cell in run.campaign.cells])[:, columns]

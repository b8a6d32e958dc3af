"""Unknown damage states: found on a grid of nodes, integrated by local Gaussians about the best ones.

Every group of cells with one unknown state is screened over a grid, under a covariance that allows for every effect
at its prior scale, so that no effect can hide the right node. The model is then linearised about the best nodes; each
hypothesis is judged in the model closest to its own posterior state. A state must lie between 0 and `highest`: the
share of a hypothesis's Gaussian within the box multiplies its evidence.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from octmip.gap.inference.difference import ALL_GAUGES
from octmip.gap.inference.evidence import Fit
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import OPEN_STATE, STEP, LinearModel, linearise
from octmip.gap.inference.whitening import log_normal
from octmip.twin import state_limits_of

Floats = NDArray[np.float64]

MOST = 0.9
"""Largest damage that is considered."""
LINES = {1: 37, 2: 17}
"""Grid lines for each parameter by the number of parameters; more parameters get pairs of active ones."""
STATE_RESOLUTION = 0.05
"""Distance of states, as fractions of damage, below which they count as one."""
MODES = 3
"""Nodes per group that are looked at."""
NODE_ERROR = 0.02
"""Relative sd of a node's change: the state lies up to half a grid line from it."""
PLAUSIBLE = 12.0
"""Log units below the best node within which another node is still looked at."""


def highest(inputs: Inputs) -> Floats:
    """Return up to which value (n_parameters,) each state is looked for: `MOST`, or less where the twin has a limit.

    A tangent needs a step more. A state of limit 0 is taken as stated.
    """
    return np.clip(np.array(state_limits_of(inputs.twin), dtype=np.float64) - STEP, 0.0, MOST)


def grid(n_parameters: int) -> Floats:
    """Return the nodes (n_nodes, n_parameters)."""
    if n_parameters in LINES:
        axis = np.linspace(0.0, 0.85, LINES[n_parameters])
        return np.array(np.meshgrid(*[axis] * n_parameters, indexing="ij")).reshape(n_parameters, -1).T
    nodes = [np.zeros(n_parameters)]
    for active in [*((k,) for k in range(n_parameters)), *combinations(range(n_parameters), 2)]:
        for level in (0.1, 0.3, 0.5, 0.7):
            node = np.zeros(n_parameters)
            node[list(active)] = level
            nodes.append(node)
    return np.array(nodes)


def starting_states(inputs: Inputs) -> list[Floats]:
    """Return assignments (n_cells, n_parameters): all best nodes first, then one group at a time at another node."""
    states = np.array([cell.state for cell in inputs.campaign.cells])
    best = states.copy()
    nodes = [_likely_nodes(inputs, group) for group in inputs.groups]
    for group, found in zip(inputs.groups, nodes, strict=True):
        best[list(group)] = found[0]
    others = []
    for group, found in zip(inputs.groups, nodes, strict=True):
        for node in found[1:]:
            moved = best.copy()
            moved[list(group)] = node
            others.append(moved)
    return [best, *others]


def moved_states(model: LinearModel, fit: Fit, most: Floats) -> Floats:
    """Return the assignment that a hypothesis itself prefers, between 0 and `most` (n_parameters,)."""
    states = model.states.copy()
    moved = model.moved_by(fit.members, fit.size).reshape(len(model.inputs.groups), -1)
    for group, step in zip(model.inputs.groups, moved, strict=True):
        rows = list(group)
        states[rows] = np.minimum(np.maximum(states[rows] + step, 0.0), most)
    return states


def distance(a: Floats, b: Floats) -> float:
    """Return the largest difference of any state parameter between two assignments."""
    return float(np.abs(a - b).max(initial=0.0))


def log_box(model: LinearModel, fit: Fit, most: Floats) -> float:
    """Return the log of the share of the open states' posterior between 0 and `most` (n_parameters,), by marginals."""
    if not model.inputs.groups:
        return 0.0
    mean, covariance = state_posterior(model, fit)
    sd = np.sqrt(np.maximum(covariance.diagonal(), 1e-18))
    inside = ndtr((np.tile(most, len(model.inputs.groups)) - mean) / sd) - ndtr(-mean / sd)
    return float(np.log(np.maximum(inside, 1e-300)).sum())


def state_posterior(model: LinearModel, fit: Fit) -> tuple[Floats, Floats]:
    """Return mean (n_open,) and covariance (n_open, n_open) of the open states under a hypothesis."""
    centre = np.array([model.states[group[0]] for group in model.inputs.groups]).ravel()
    cross = model.sensitivity(fit.members)
    return centre + model.moved_by(fit.members, fit.size), model.open_covariance + cross @ fit.covariance @ cross.T


def joint_covariance(model: LinearModel, fit: Fit) -> Floats:
    """Return the posterior covariance of (open states, sizes): what damage and effects share."""
    own, cross = model.open_covariance, model.sensitivity(fit.members)
    return np.block(
        [[own + cross @ fit.covariance @ cross.T, -cross @ fit.covariance], [-fit.covariance @ cross.T, fit.covariance]]
    )


def _likely_nodes(inputs: Inputs, group: tuple[int, ...]) -> list[Floats]:
    """Return the nodes where the group's state may lie, best first, none near a better one."""
    nodes = grid(len(inputs.names))
    nodes = nodes[(nodes <= highest(inputs)).all(axis=1)]
    logs = _node_logs(inputs, group, nodes)
    found: list[Floats] = []
    for k in np.argsort(-logs, kind="stable"):
        if logs[k] < logs.max() - PLAUSIBLE or len(found) == MODES:
            break
        if all(np.abs(nodes[k] - other).max() > 3 * STATE_RESOLUTION for other in found):
            found.append(nodes[k])
    return found


def _node_logs(inputs: Inputs, group: tuple[int, ...], nodes: Floats) -> Floats:
    """Return the log evidence (n_nodes,) of every node with all effects allowed for at their prior scale."""
    states = np.array([cell.state for cell in inputs.campaign.cells])
    model = linearise(inputs, np.where(np.isfinite(states), states, 0.0))
    rows = np.flatnonzero(np.isin(model.cells, group))
    noise = _with_all_effects(model, rows)
    healthy = model.predicted[rows]
    y = healthy + model.residual[rows]
    gauge = model.gauge[rows]
    same = inputs.difference.usual.damage**2 * np.where(gauge[:, None] == gauge[None, :], 1.0, ALL_GAUGES)
    diagonal = np.diag_indices(len(rows))
    logs = []
    for row in _changes(model, rows, nodes):
        covariance = noise + same * np.outer(row, row)
        covariance[diagonal] += (NODE_ERROR * row) ** 2
        logs.append(log_normal(covariance, y - healthy - row))
    return np.array(logs)


def _with_all_effects(model: LinearModel, rows: NDArray[np.int64]) -> Floats:
    """Return the covariance of some rows with every effect at its prior scale in place of the unknown damage."""
    prior = model.inputs.priors
    scale = np.where(prior.is_discrete, 0.0, prior.sd * np.exp(0.5 * prior.log_weight))
    spread = model.signatures[rows] * scale
    noise = model.covariance[np.ix_(rows, rows)] + spread @ spread.T
    noise -= OPEN_STATE**2 * model.tangents[rows] @ model.tangents[rows].T
    return np.asarray(noise)


def _changes(model: LinearModel, rows: NDArray[np.int64], nodes: Floats) -> Floats:
    """Return what the damage of every node changes in the twin's strains (n_nodes, n_rows)."""
    inputs, order, gauge = model.inputs, list(model.inputs.order), model.gauge[rows]
    loads = [model.loads[k] for k in rows.tolist()]
    change = np.zeros((len(nodes), len(rows)))
    for at in dict.fromkeys(loads):
        strain = inputs.twin.predict_states(nodes, at)[:, order]
        healthy = inputs.twin.predict(inputs.named(np.zeros(len(inputs.names))), at)[order]
        here = np.array([load == at for load in loads])
        change[:, here] = (strain - healthy)[:, gauge[here]]
    return change

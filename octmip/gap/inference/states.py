"""Unknown damage states: a grid of nodes to find where a state may lie, local Gaussians about those places to
integrate.

Every group of cells with one unknown state is screened over a grid, under a covariance that allows for every effect
at its prior scale, so that no effect can hide the right node. The scene is then linearised about the best nodes; each
hypothesis is judged in the scene closest to its own posterior state. A state must lie between 0 and `MOST`: the share
of a hypothesis's Gaussian within the box multiplies its evidence.
"""

from itertools import combinations

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray
from scipy.special import ndtr

from octmip.gap.inference.evidence import Fit
from octmip.gap.inference.linear_model import OPEN_STATE, Scene, Setting, build_scene, named_state

Floats = NDArray[np.float64]

MOST = 0.9
"""Largest damage that is considered."""
LINES = {1: 37, 2: 17}
"""Grid lines for each parameter by the number of parameters; more parameters get pairs of active ones."""
NEAR = 0.05
"""States closer than this are one place."""
MODES = 3
"""Places per group that are looked at."""
PLAUSIBLE = 12.0
"""Log units below the best node within which another node is still a place to look at."""


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


def starting_states(setting: Setting) -> list[Floats]:
    """Return assignments (n_cells, n_parameters): all best nodes first, then one group at a time at another place."""
    states = np.array([cell.state for cell in setting.campaign.cells])
    best = states.copy()
    places = [_places(setting, group) for group in setting.groups]
    for group, found in zip(setting.groups, places, strict=True):
        best[list(group)] = found[0]
    others = []
    for group, found in zip(setting.groups, places, strict=True):
        for place in found[1:]:
            moved = best.copy()
            moved[list(group)] = place
            others.append(moved)
    return [best, *others]


def moved_states(scene: Scene, fit: Fit) -> Floats:
    """Return the assignment that a hypothesis itself prefers, inside the box."""
    states = scene.states.copy()
    shift = scene.shift(fit.members, fit.size).reshape(len(scene.setting.groups), -1)
    for group, step in zip(scene.setting.groups, shift, strict=True):
        states[list(group)] = np.clip(states[list(group)] + step, 0.0, MOST)
    return states


def distance(a: Floats, b: Floats) -> float:
    """Return the largest difference of any state parameter between two assignments."""
    return float(np.abs(a - b).max(initial=0.0))


def log_box(scene: Scene, fit: Fit) -> float:
    """Return the log of the share of the open states' posterior that lies between 0 and `MOST` (marginals only)."""
    if not scene.setting.groups:
        return 0.0
    mean, covariance = state_posterior(scene, fit)
    sd = np.sqrt(np.maximum(np.diag(covariance), 1e-18))
    inside = ndtr((MOST - mean) / sd) - ndtr(-mean / sd)
    return float(np.log(np.maximum(inside, 1e-300)).sum())


def state_posterior(scene: Scene, fit: Fit) -> tuple[Floats, Floats]:
    """Return mean (n_open,) and covariance (n_open, n_open) of the open states under a hypothesis."""
    centre = np.array([scene.states[group[0]] for group in scene.setting.groups]).ravel()
    mean = centre + scene.shift(fit.members, fit.size)
    covariance = joint_covariance(scene, fit)[: len(centre), : len(centre)]
    return mean, covariance


def joint_covariance(scene: Scene, fit: Fit) -> Floats:
    """Return the posterior covariance of (open states, sizes): what damage and effects share."""
    own, cross = scene.open_covariance, scene.lean[:, list(fit.members)]
    return np.block(
        [[own + cross @ fit.covariance @ cross.T, -cross @ fit.covariance], [-fit.covariance @ cross.T, fit.covariance]]
    )


def _places(setting: Setting, group: tuple[int, ...]) -> list[Floats]:
    """Return the nodes where the group's state may lie, best first, none near a better one."""
    nodes = grid(len(setting.names))
    logs = np.array(_node_logs(setting, group, nodes))
    found: list[Floats] = []
    for k in np.argsort(-logs, kind="stable"):
        if logs[k] < logs.max() - PLAUSIBLE or len(found) == MODES:
            break
        if all(np.abs(nodes[k] - place).max() > 3 * NEAR for place in found):
            found.append(nodes[k])
    return found


def _node_logs(setting: Setting, group: tuple[int, ...], nodes: Floats) -> list[float]:
    """Return the log evidence of every node with all effects allowed for at their prior scale."""
    states = np.array([cell.state for cell in setting.campaign.cells])
    states = np.where(np.isfinite(states), states, 0.0)
    scene = build_scene(setting, states)
    rows = np.flatnonzero(np.isin([setting.blocks[b].cell for b in scene.block], group))
    prior = setting.priors
    spread = scene.signatures[rows] * np.where(prior.is_fact, 0.0, prior.sd * np.exp(0.5 * prior.log_weight))
    noise = scene.covariance[np.ix_(rows, rows)] + spread @ spread.T
    noise -= OPEN_STATE**2 * scene.tangents[rows] @ scene.tangents[rows].T
    block, gauge = scene.block[rows], scene.gauge[rows]
    healthy = scene.predicted[rows]
    y = healthy + scene.residual[rows]
    order = list(setting.order)
    loads = np.array([setting.cell_of(b).load_factor for b in setting.blocks])
    strains = {
        load: setting.memory.predict_states(nodes, load)[:, order] for load in sorted(set(loads[block].tolist()))
    }
    start = {
        load: setting.memory.predict(named_state(setting, np.zeros(len(setting.names))), load)[order]
        for load in strains
    }
    load = loads[block]
    change = np.zeros((len(nodes), len(rows)))
    for at, strain in strains.items():
        change[:, load == at] = (strain - start[at])[:, gauge[load == at]]
    same = np.where(gauge[:, None] == gauge[None, :], setting.discrepancy.damage**2, 0.0)
    diagonal = np.diag_indices(len(rows))
    logs = []
    for row in change:
        covariance = noise + same * np.outer(row, row)
        covariance[diagonal] += (0.02 * row) ** 2
        factor = linalg.cholesky(covariance, lower=True, overwrite_a=True, check_finite=False)
        left = linalg.solve_triangular(factor, y - healthy - row, lower=True, check_finite=False)
        logs.append(-0.5 * float(left @ left) - float(np.log(factor[diagonal]).sum()))
    return logs

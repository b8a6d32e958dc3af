"""The least worst case by plain enumeration of all trees to depth 2: no bound, no event, no rank. For small problems.

Every threshold at which any sample, with its lowest, true or highest reading, changes sides; every label of every leaf;
every set of at most `off` sensors.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from octmip.trees.problem import Problem
from octmip.trees.worst_case import Bands

Floats = NDArray[np.float64]
Child = tuple[int | None, NDArray[np.bool_], list[Floats]]
"""Feature or None, samples left by their true reading, what each sample pays: still, and with its sensor off."""


def least_worst_case(problem: Problem, bands: Bands, off: int) -> float:
    """Return the least worst case of all trees of depth 1 or 2, and of all leaves."""
    weights = problem.weights[:, None] * problem.costs[problem.codes]
    leaves: list[Child] = [(None, np.ones(len(weights), bool), [weights[:, k]] * 2) for k in range(problem.n_classes)]
    cuts = _cuts(problem, bands)
    stumps = [child for cut in cuts for child in _stumps(cut, weights)] if problem.depth > 1 else []
    children = leaves + stumps
    best = min(float(paid[0].sum()) for _, _, paid in leaves)
    sensors = range(len(problem.sensors))
    sets = [set(chosen) for size in range(off + 1) for chosen in combinations(sensors, size)]
    for feature, ways in cuts:
        sides = [_feasible(problem, feature, children, members) for members in (ways[0][0], ~ways[0][0])]
        if not sides[0] or not sides[1]:
            continue
        worst = np.max([_costs(problem, feature, ways, sides, chosen) for chosen in sets], axis=0)
        n_splits = np.add.outer(*([int(child[0] is not None) for child in side] for side in sides)) + 1
        worst = worst + problem.leaf_penalty * n_splits
        for i, j in np.argwhere(worst < best):
            read = {int(problem.sensor_index[f]) for f in (feature, sides[0][i][0], sides[1][j][0]) if f is not None}
            if sum(problem.sensor_costs[list(read)]) <= problem.sensor_limit:
                best = min(best, float(worst[i, j]))
    return best


def _cuts(problem: Problem, bands: Bands) -> list[tuple[int, list[tuple[NDArray[np.bool_], NDArray[np.bool_]]]]]:
    """Return each cut's feature and, still and off, which samples may go left and which right."""
    found = {}
    for f in range(problem.n_features):
        values = [table[:, f] for table in (bands.low, problem.features, bands.high)]
        for threshold in np.unique(values) if problem.is_allowed((f,)) else ():
            left = [value <= threshold for value in values]
            if left[1].any() and not left[1].all():
                found[f, *(side.tobytes() for side in left)] = (f, [(left[1], ~left[1]), (left[0], ~left[2])])
    return list(found.values())


def _stumps(cut: tuple[int, list[tuple[NDArray[np.bool_], NDArray[np.bool_]]]], weights: Floats) -> list[Child]:
    feature, ways = cut
    pairs = [(a, b) for a in range(weights.shape[1]) for b in range(weights.shape[1]) if a != b]

    def paid(a: int, b: int, way: tuple[NDArray[np.bool_], NDArray[np.bool_]]) -> Floats:
        return np.maximum(np.where(way[0], weights[:, a], -1), np.where(way[1], weights[:, b], -1))

    return [(feature, ways[0][0], [paid(a, b, way) for way in ways]) for a, b in pairs]


def _feasible(problem: Problem, root: int, children: list[Child], members: NDArray[np.bool_]) -> list[Child]:
    """Return the children whose leaves hold enough of the members by their true readings."""
    size = problem.leaf_size
    if members.sum() < size:
        return []
    return [c for c in children if c[0] is None or min((members & c[1]).sum(), (members & ~c[1]).sum()) >= size]


def _costs(
    problem: Problem,
    root: int,
    ways: list[tuple[NDArray[np.bool_], NDArray[np.bool_]]],
    sides: list[list[Child]],
    off: set[int],
) -> Floats:
    """Return the cost of every pair of children while some sensors are off."""
    left, right = ways[int(problem.sensor_index[root]) in off]

    def state(feature: int | None) -> int:
        return int(feature is not None and int(problem.sensor_index[feature]) in off)

    paid = [np.array([child[2][state(child[0])] for child in side]) for side in sides]
    ours, theirs = np.where(left, paid[0], -1.0), np.where(right, paid[1], -1.0)
    return np.asarray(np.maximum(ours[:, None, :], theirs[None, :, :]).sum(axis=2))

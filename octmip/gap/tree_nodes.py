"""Nodes of a deployed tree at which the gap flips decisions.

A large gap can be irrelevant to the decision, and a small one decisive. The tree reads strain divided by load factor.
For every known or estimated state of the campaign the twin says how readings would spread about each node's split; the
asset's readings say how they do. A node's share is the part of all readings that reach it in the asset and pass it
other than the twin's would: reach * |P_sim(left) - P_real(left)|.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.location import Flip
from octmip.trees.tree import Leaf, Node, condition, features_used, goes_left
from octmip.twin import is_zero

Floats = NDArray[np.float64]

DRAWS = 200
"""Simulated readings for each real one's cell."""


def flips(model: LinearModel, tree: Node, feature_names: Sequence[str], seed: int = 0) -> tuple[Flip, ...]:
    """Return the nodes, greatest share of flipped decisions first.

    Parameters
    ----------
    model
        the campaign about its states.
    tree
        a tree whose features are gauges, in microstrain per unit of load factor.
    feature_names
        names of the features.
    seed
        of the simulated noise.

    Raises
    ------
    DataError
        the tree reads a feature that is no gauge of the campaign.
    """
    gauges = model.inputs.campaign.gauges
    missing = [feature_names[f] for f in sorted(features_used(tree)) if feature_names[f] not in gauges]
    if missing:
        raise DataError(
            f"the tree reads {missing[0]!r}, which is no gauge of the campaign; expected gauges {gauges[:3]}..."
        )
    order = [gauges.index(name) if name in gauges else -1 for name in feature_names]
    real, simulated = _readings(model, order, np.random.default_rng(seed))
    found = _flips(tree, "", real, simulated, feature_names, max(len(real), 1))
    return tuple(sorted(found, key=lambda flip: -flip.share))


def _flips(tree: Node, path: str, real: Floats, simulated: Floats, names: Sequence[str], n: int) -> list[Flip]:
    """Return the nodes from `path` on, of n readings those that reach it."""
    if isinstance(tree, Leaf):
        return []
    here, there = goes_left(tree, real), goes_left(tree, simulated)
    found = []
    if len(real) and len(simulated):
        p_real, p_simulated = float(here.mean()), float(there.mean())
        words = condition(tree, lambda feature: names[feature])
        found.append(Flip(path, words, p_simulated, p_real, len(real) / n * abs(p_real - p_simulated)))
    found += _flips(tree.left, path + "L", real[here], simulated[there], names, n)
    return found + _flips(tree.right, path + "R", real[~here], simulated[~there], names, n)


def _readings(model: LinearModel, order: list[int], rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return real readings (n, n_features) and simulated ones, divided by the one load; rows with gaps left out."""
    inputs = model.inputs
    n_gauges = len(inputs.campaign.gauges)
    root = np.linalg.cholesky(inputs.noise.covariance)
    real, simulated = [], []
    first = {average.cell: k for k, average in reversed(list(enumerate(inputs.averages)))}
    for k, cell in enumerate(inputs.campaign.cells):
        if is_zero(cell.load):
            continue
        unit = cell.load if isinstance(cell.load, float) else 1.0
        mean = np.full(n_gauges, np.nan)
        here = model.average == first[k]
        mean[model.gauge[here]] = model.predicted[here]
        rows = inputs.campaign.readings[cell.rows]
        real.append(rows / unit)
        simulated.append((mean + rng.standard_normal((DRAWS, n_gauges)) @ root.T) / unit)
    kept = [np.concatenate(part)[:, order] if part else np.zeros((0, len(order))) for part in (real, simulated)]
    return kept[0][np.isfinite(kept[0]).all(axis=1)], kept[1][np.isfinite(kept[1]).all(axis=1)]

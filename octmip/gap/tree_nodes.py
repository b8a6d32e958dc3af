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
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split, goes_left
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
    used = {f for split in _splits(tree, "") for f in split[1].features}
    missing = [feature_names[f] for f in sorted(used) if feature_names[f] not in gauges]
    if missing:
        raise DataError(
            f"the tree reads {missing[0]!r}, which is no gauge of the campaign; expected gauges {gauges[:3]}..."
        )
    order = [gauges.index(name) if name in gauges else -1 for name in feature_names]
    real, simulated = _readings(model, order, np.random.default_rng(seed))
    found = []
    for path, split in _splits(tree, ""):
        here, there = _reaching(tree, path, real), _reaching(tree, path, simulated)
        if not len(here) or not len(there):
            continue
        p_real, p_simulated = float(goes_left(split, here).mean()), float(goes_left(split, there).mean())
        share = len(here) / len(real) * abs(p_real - p_simulated)
        found.append(Flip(path, _words(split, feature_names), p_simulated, p_real, share))
    return tuple(sorted(found, key=lambda flip: -flip.share))


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


def _splits(tree: Node, path: str) -> list[tuple[str, Split | HyperplaneSplit]]:
    if isinstance(tree, Leaf):
        return []
    return [(path, tree), *_splits(tree.left, path + "L"), *_splits(tree.right, path + "R")]


def _reaching(tree: Node, path: str, rows: Floats) -> Floats:
    for turn in path:
        assert not isinstance(tree, Leaf)
        left = goes_left(tree, rows)
        rows, tree = (rows[left], tree.left) if turn == "L" else (rows[~left], tree.right)
    return rows


def _words(split: Split | HyperplaneSplit, names: Sequence[str]) -> str:
    if isinstance(split, Split):
        if split.threshold is None:
            return f"{names[split.feature]} is {'' if split.missing == 'left' else 'not '}missing"
        return f"{names[split.feature]} <= {split.threshold:.4g}"
    terms = " + ".join(f"{c:.3g} {names[f]}" for f, c in zip(split.features, split.coefficients, strict=True))
    return f"{terms} <= {split.offset:.4g}"

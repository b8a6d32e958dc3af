"""Location of the gap: by entry, gauge, load and test, and at the nodes of a deployed tree that it flips.

Residuals are readings less the (calibrated) twin, in standard deviations of noise and of what two good models differ
by. Entries are significant under the false-discovery rate of 5 %: Benjamini and Hochberg (1995), J. R. Statist. Soc.
B 57; each gauge, load or test under a chi-squared test of all its entries with their full covariance, Bonferroni
over the groups. The halves of a test's readings are taken together.

Nodes of a deployed tree at which the gap flips decisions.

A large gap can be irrelevant to the decision, and a small one decisive. The tree reads strain divided by load factor.
For every known or estimated state of the campaign the twin says how readings would spread about each node's split; the
asset's readings say how they do. A node's share is the part of all readings that reach it in the asset and pass it
other than the twin's would: reach * |P_sim(left) - P_real(left)|.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, false_discovery_control

from octmip.errors import DataError
from octmip.gap.inference.linear_model import LinearModel
from octmip.trees.nodes.tree import Leaf, Node, condition, features_used, goes_left
from octmip.twin import MIXED, is_zero

Floats = NDArray[np.float64]

RATE = 0.05
"""False-discovery rate of entries, and familywise error of groups."""


@dataclass(frozen=True, slots=True)
class Place:
    """One gauge, load, test or single entry.

    Attributes
    ----------
    name
        in words.
    z
        standardised residual (an entry), or sqrt(chi2 / entries) (a group).
    p_value
        of no gap.
    is_significant
        after correction.
    share
        part of the whole squared gap, noise taken off.
    gap
        mean residual.
    unit
        of it.
    """

    name: str
    z: float
    p_value: float
    is_significant: bool
    share: float
    gap: float
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class Where:
    """The gap by place.

    Attributes
    ----------
    entries
        one for each averaged reading, most significant first.
    gauges, loads, tests
        groups, greatest share first.
    nodes
        nodes of the deployed tree, greatest share of flipped decisions first; empty without a tree.
    rms, unit
        root mean square gap, noise taken off, and its unit.
    p_value
        of the whole: chi-squared of all entries.
    """

    entries: tuple[Place, ...]
    gauges: tuple[Place, ...]
    loads: tuple[Place, ...]
    tests: tuple[Place, ...]
    nodes: tuple["Flip", ...]
    rms: float
    unit: str
    p_value: float


@dataclass(frozen=True, slots=True)
class Flip:
    """A node of a tree at which readings of twin and asset go different ways.

    Attributes
    ----------
    path
        the way to the node, "L" and "R" from the root, "" for the root.
    words
        its split in words.
    simulated, real
        share of readings that pass left, twin and asset.
    share
        part of all real readings that reach the node and go the other way than the twin's would.
    """

    path: str
    words: str
    simulated: float
    real: float
    share: float


def localise(model: LinearModel, nodes: tuple[Flip, ...]) -> Where:
    """Return where readings and twin differ about a model's states."""
    (cell, gauge), mix = whole_means(model)
    scale, units = model.inputs.scale[gauge], np.array(model.inputs.units)[gauge]
    residual, covariance = mix @ model.residual, mix @ model.covariance @ mix.T
    excess = (residual**2 - np.einsum("ij,jk,ik->i", mix, model.scatter, mix)) / scale**2
    share = excess / max(float(excess.sum()), 1e-12)

    def place(name: str, rows: NDArray[np.int64]) -> Place:
        own = residual[rows]
        squared = float(own @ np.linalg.solve(covariance[np.ix_(rows, rows)], own))
        p_value, z = float(chi2.sf(squared, len(rows))), float(np.sqrt(squared / len(rows)))
        unit = str(units[rows[0]]) if (units[rows] == units[rows[0]]).all() else MIXED
        gap = own / scale[rows] if unit == MIXED else own
        return Place(name, z, p_value, False, float(share[rows].sum()), float(gap.mean()), unit)

    cells = [model.inputs.campaign.cells[c] for c in cell]
    gauges = [model.inputs.campaign.gauges[g] for g in gauge]
    entries = [place(f"{g}, {c.name}", np.array([k])) for k, (g, c) in enumerate(zip(gauges, cells, strict=True))]
    return Where(
        entries=_entries(entries),
        gauges=_groups(place, gauges),
        loads=_groups(place, [c.load_words for c in cells]),
        tests=_groups(place, [c.test for c in cells]),
        nodes=nodes,
        rms=float(np.sqrt(max(0.0, float(excess.mean())))),
        unit=model.inputs.unit,
        p_value=float(chi2.sf(float(model.left @ model.left), model.n)),
    )


def whole_means(model: LinearModel) -> tuple[NDArray[np.int64], Floats]:
    """Return cell and gauge (2, n_means) of every mean reading, and the weights (n_means, n) that join its halves."""
    count = np.array([average.count for average in model.inputs.averages])[model.average, model.gauge]
    places, entry = np.unique(np.stack([model.cells, model.gauge]), axis=1, return_inverse=True)
    mix = np.zeros((places.shape[1], model.n))
    mix[entry.ravel(), np.arange(model.n)] = count
    return places, mix / mix.sum(axis=1, keepdims=True)


def _entries(found: Sequence[Place]) -> tuple[Place, ...]:
    """Return every mean reading as a place with its significance, the least probable without a gap first."""
    significant = false_discovery_control([place.p_value for place in found]) <= RATE
    signed = zip(found, significant.tolist(), strict=True)
    entries = [replace(place, z=math.copysign(place.z, place.gap), is_significant=far) for place, far in signed]
    return tuple(sorted(entries, key=lambda place: place.p_value))


def _groups(place: Callable[[str, NDArray[np.int64]], Place], names: Sequence[str]) -> tuple[Place, ...]:
    """Return the groups of means of one name each as places, the greatest share of the gap first."""
    named = np.array(names)
    found = [place(name, np.flatnonzero(named == name)) for name in dict.fromkeys(names)]
    groups = [replace(one, is_significant=one.p_value < RATE / len(found)) for one in found]
    return tuple(sorted(groups, key=lambda one: -one.share))


DRAWS = 200
"""Simulated readings for each real one's cell."""


def flips(model: LinearModel, tree: Node, feature_names: Sequence[str]) -> tuple[Flip, ...]:
    """Return the nodes, greatest share of flipped decisions first.

    Parameters
    ----------
    model
        the campaign about its states.
    tree
        a tree whose features are gauges, in microstrain per unit of load factor.
    feature_names
        names of the features.

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
    real, simulated = _readings(model, order, np.random.default_rng(0))
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
    first = {average.number: k for k, average in reversed(list(enumerate(inputs.averages)))}
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

"""The likelihood of a leaf: P(leaf | state, load) of the leaf that a reading reached, in every state of a library.

The table is drawn: readings of every state (spread over its cell, with the library's noise) are sent down the tree.
With N draws an entry p has the standard error sqrt(p (1 - p) / N). Half a draw is shared by all leaves, so that what
was not drawn is unlikely but not impossible. Half a draw for every leaf would be too much: no reading could then speak
against a state by more than a factor of 2 N, and a sudden damage, rarer than that by growth, needed a second reading.

A reading that lacks gauges reaches all leaves that the known gauges leave open; what was seen is that it lies in one
of them, so their probabilities add up. Nothing is imputed.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.input.named_arrays import by_name
from octmip.monitor.compiled import CompiledTree
from octmip.monitor.library import Applied, Library
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node
from octmip.trees.uncertainty import smoothed_shares

Floats = NDArray[np.float64]

DRAWS = 2000
"""Readings drawn in every state: an entry of one half is known to 0.011."""
HALF_DRAW = 0.5
"""Draws that all leaves of a state share besides."""
LOAD_STEP = 0.02
"""Ratio between the loads that tables are drawn for, less 1: the noise per unit of load is then right to 1 %, and a
stream whose load never repeats needs no more tables than there are steps."""
ROWS = 200_000
"""Readings drawn at once: bounds memory."""


@dataclass(slots=True, eq=False)
class LeafLikelihood:
    """The leaf of a tree as an observation of the state; keeps its tables, so it is not frozen.

    Attributes
    ----------
    tree
        over readings per unit of load factor.
    library
        the states; not necessarily those that the tree predicts.
    n_draws
        readings drawn in every state for the table of a load.
    seed
        of the draws.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> tree = Split(0, 125.0, Leaf(0), Leaf(1))  # of the gauge g1
    >>> LeafLikelihood(tree, library).table(1.0).round(2).tolist()  # leaves by states
    [[0.99, 0.01], [0.01, 0.99]]
    """

    tree: Node
    library: Library
    n_draws: int = DRAWS
    seed: int = 0
    _compiled: CompiledTree = field(init=False, repr=False)
    _tables: dict[int, Floats] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._compiled = CompiledTree(self.tree, self.library.gauges)

    @property
    def n_leaves(self) -> int:
        """Number of leaves."""
        return self._compiled.n_leaves

    def table(self, load_factor: Applied) -> Floats:
        """Return P(leaf | state), shape (n_leaves, n_states), at a load; leaves from the left."""
        step = round(np.log(self.library.checked_load(load_factor)) / np.log1p(LOAD_STEP))
        if step not in self._tables:
            self._tables[step] = self._drawn(float((1.0 + LOAD_STEP) ** step))
        return self._tables[step]

    def log_likelihood(self, readings: Floats, load_factor: Applied) -> Floats:
        """Return log P(what was seen | state), shape (n, n_states), of readings (n, n_gauges), NaN where missing."""
        table = self.table(load_factor)
        open_leaves = self.open_leaves(self.library.features(readings, load_factor))
        is_one = open_leaves.sum(axis=1) == 1
        found = np.empty((len(readings), self.library.n_states))
        found[is_one] = np.log(table)[open_leaves[is_one].argmax(axis=1)]
        found[~is_one] = np.log(open_leaves[~is_one] @ table)
        return found

    def open_leaves(self, features: Floats) -> NDArray[np.bool_]:
        """Return the mask (n, n_leaves) of leaves that features (n, n_gauges) may have reached: one if none is missing.

        Raises
        ------
        DataError
            the rows have another length.
        """
        at = self._compiled.leaf_index(features)
        is_known = at < self.n_leaves
        found = np.zeros((len(features), self.n_leaves), dtype=bool)
        found[np.flatnonzero(is_known), at[is_known]] = True
        rows = np.flatnonzero(~is_known)
        if rows.size:
            found[rows] = _open_leaves(self.tree, features[rows])
        return found

    def _drawn(self, load: float) -> Floats:
        library, rng = self.library, np.random.default_rng(self.seed)
        counts = np.zeros((library.n_states, self.n_leaves))
        per_pass = max(1, ROWS // self.n_draws)
        for first in range(0, library.n_states, per_pass):
            states = np.repeat(np.arange(first, min(first + per_pass, library.n_states)), self.n_draws)
            offset = rng.uniform(-0.5, 0.5, (len(states), len(library.parameters))) * library.widths
            features = library.strains[states]
            for k in range(len(library.parameters)):
                features = features + offset[:, k, None] * library.slopes[states, k]
            features += rng.standard_normal(features.shape) * (library.noise_sd / load)
            np.add.at(counts, (states, self._compiled.leaf_index(features)), 1.0)
        return smoothed_shares(counts, HALF_DRAW).T


def _open_leaves(tree: Node, features: Floats) -> NDArray[np.bool_]:
    """Return the leaves, from the left, that rows with missing values leave open, as a mask (n, n_leaves)."""
    columns: list[NDArray[np.bool_]] = []

    def visit(node: Node, is_here: NDArray[np.bool_]) -> None:
        if isinstance(node, Leaf):
            columns.append(is_here)
            return
        if isinstance(node, HyperplaneSplit):
            total, limit = np.zeros(len(features)), node.offset
            for coefficient, feature in zip(node.coefficients, node.features, strict=True):
                with np.errstate(over="ignore", invalid="ignore"):  # beyond float64 is inf, as in CompiledTree
                    total = total + coefficient * features[:, feature]
        elif node.threshold is None:  # it asks what a complete reading answers always alike
            visit(node.left, is_here & (node.missing == "right"))
            visit(node.right, is_here & (node.missing == "left"))
            return
        else:
            total, limit = features[:, node.feature], node.threshold
        # NaN is neither greater nor not: it may be on either side
        visit(node.left, is_here & np.logical_not(total > limit))
        visit(node.right, is_here & np.logical_not(total <= limit))

    visit(tree, np.ones(len(features), dtype=bool))
    return np.stack(columns, axis=1)


def check_readings(readings: Any, library: Library) -> Floats:
    """Return readings as (n, n_gauges), columns with names in the order of the library's gauges.

    Raises
    ------
    DataError
        they have another shape, lack a gauge, or hold an infinite number.
    """
    rows, _ = by_name(readings, library.gauges, "readings")
    if np.isinf(rows).any():
        row, column = (int(k) for k in np.argwhere(np.isinf(rows))[0])
        raise DataError(f"reading {row} of {library.gauges[column]} is infinite; expected microstrain, NaN if missing")
    return rows

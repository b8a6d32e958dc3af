"""A tree compiled to flat tables, for streams: microseconds per reading, a fraction of one in batches.

Same left rule as octmip.trees.nodes.tree to the last bit, and the same sides for missing readings (NaN). Where a split
on its way has no side for one, a reading has no result: `label` refuses it with a sentence; a batch, and every export,
returns `REFUSED`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, nodes, splits

REFUSED = -1
"""Result of a batch and of every export for a reading without a number where the tree asks for one."""
BLOCK = 4096
"""Readings routed together: their node numbers stay in the cache."""

Step = tuple[tuple[int, ...], tuple[float, ...], float, int, int, int]
"""Features, coefficients, threshold, the steps left and right, and the one for missing readings (`REFUSED`: none). The
threshold is NaN where a split asks for missing readings alone: every number then takes the step that these do not."""


@dataclass(frozen=True, slots=True, eq=False)
class CompiledTree:
    """A tree ready for readings.

    Attributes
    ----------
    tree
        the tree.
    feature_names
        (n_features,) names in the order of a reading.

    Examples
    --------
    >>> CompiledTree(Split(0, 125.0, Leaf(0), Leaf(1)), ("g1", "g2")).labels(np.array([[100, 0], [150, 0]])).tolist()
    [0, 1]
    """

    tree: Node
    feature_names: tuple[str, ...]
    _steps: tuple[Step, ...] = field(init=False, repr=False)
    _labels: tuple[int, ...] = field(init=False, repr=False)
    _features: NDArray[np.intp] = field(init=False, repr=False)
    _coefficients: NDArray[np.float64] = field(init=False, repr=False)
    _thresholds: NDArray[np.float64] = field(init=False, repr=False)
    _next: NDArray[np.intp] = field(init=False, repr=False)
    _missing: NDArray[np.intp] = field(init=False, repr=False)
    _n_terms: NDArray[np.intp] = field(init=False, repr=False)
    _depth: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        found = splits(self.tree)
        highest = max((split.features[-1] for split in found), default=-1)
        if highest >= len(self.feature_names):
            raise DataError(
                f"the tree reads feature {highest} but has {len(self.feature_names)} feature names; expected one for "
                "each; complete them"
            )
        number = {id(node): k for k, node in enumerate(nodes(self.tree))}
        self._set_steps(number)
        self._set_tables(max((len(split.features) for split in found), default=1))

    def _set_steps(self, number: dict[int, int]) -> None:
        """Set the steps of the nodes in preorder; a leaf's step has no feature."""
        steps: list[Step] = []
        labels: list[int] = []
        for k, node in enumerate(nodes(self.tree)):
            if isinstance(node, Leaf):
                steps.append(((), (), 0.0, k, k, k))
                labels.append(node.label)
                continue
            left, right = number[id(node.left)], number[id(node.right)]
            coefficients = node.coefficients if isinstance(node, HyperplaneSplit) else (1.0,)
            given = node.threshold if isinstance(node, Split) else node.offset
            threshold = np.nan if given is None else given
            missing = {"left": left, "right": right, None: REFUSED}[node.missing]
            steps.append((node.features, coefficients, threshold, left, right, missing))
            labels.append(REFUSED)
        object.__setattr__(self, "_steps", tuple(steps))
        object.__setattr__(self, "_labels", tuple(labels))

    def _set_tables(self, n_terms: int) -> None:
        """Lay the steps out as arrays; the last row is where readings without a result stay."""
        n = len(self._steps)
        features = np.zeros((n_terms, n + 1), dtype=np.intp)
        coefficients = np.zeros((n_terms, n + 1))
        thresholds = np.zeros(n + 1)
        goes = np.full((n + 1, 3), n, dtype=np.intp)  # columns: neither, left, right
        missing = np.full(n + 1, n, dtype=np.intp)
        for k, (terms, weights, threshold, left, right, lost) in enumerate(self._steps):
            if not terms:
                goes[k] = k
                continue
            features[: len(terms), k], coefficients[: len(terms), k] = terms, weights
            thresholds[k] = threshold
            goes[k, 1:] = left, right
            missing[k] = n if lost == REFUSED else lost
            if np.isnan(threshold):
                goes[k, 0] = left + right - lost
        is_axis = n_terms == 1 and all(weights in ((), (1.0,)) for _, weights, *_ in self._steps)
        depth = _levels(self._steps)
        tables = {
            "_features": features,
            "_thresholds": thresholds,
            "_next": goes.ravel(),
            "_missing": missing,
            "_depth": depth,
        }
        tables["_n_terms"] = np.array([*(len(terms) for terms, *_ in self._steps), 0], dtype=np.intp)
        tables["_coefficients"] = np.zeros((0, 0)) if is_axis else coefficients
        for name, table in tables.items():
            object.__setattr__(self, name, table)

    def node(self, reading: Sequence[float] | NDArray[np.float64]) -> int:
        """Return the preorder number of the leaf of one reading (n_features,).

        Raises
        ------
        DataError
            the reading has another length, or no number where a split on its way asks for one.
        """
        if len(reading) != len(self.feature_names):
            raise DataError(
                f"reading has {len(reading)} values; expected {len(self.feature_names)}, one for each of "
                f"{self.feature_names[0]} to {self.feature_names[-1]}"
            )
        if self._coefficients.size and isinstance(reading, np.ndarray):
            reading = reading.tolist()  # sums of Python's floats take half the time of numpy's
        steps, k = self._steps, 0
        while True:
            terms, weights, threshold, left, right, _ = steps[k]
            if not terms:
                return k
            if len(terms) == 1 and weights[0] == 1.0:
                total = reading[terms[0]]
            else:
                total = 0.0
                for j, weight in zip(terms, weights, strict=True):
                    total += weight * reading[j]
            if total <= threshold:
                k = left
            elif total > threshold:
                k = right
            else:
                k = self._step_without_number(k, reading)

    def _step_without_number(self, k: int, reading: Sequence[float] | NDArray[np.float64]) -> int:
        """Return the step after step k for a reading that is on neither side of its threshold."""
        terms, _, threshold, left, right, missing = self._steps[k]
        is_missing = any(np.isnan(reading[j]) for j in terms)
        if is_missing and missing != REFUSED:
            return missing
        if np.isnan(threshold):
            return left + right - missing
        if not is_missing:  # infinity minus infinity, as in the tree
            return right
        raise DataError(self._complaint(terms, reading))

    def label(self, reading: Sequence[float] | NDArray[np.float64]) -> int:
        """Return the class index of one reading (n_features,).

        Raises
        ------
        DataError
            as `node`.
        """
        return self._labels[self.node(reading)]

    def path_to(self, node: int) -> list[int]:
        """Return the preorder numbers on the way from the root to a node, both included."""
        path = [0]
        while path[-1] != node:
            _, _, _, left, right, _ = self._steps[path[-1]]
            path.append(right if node >= right else left)  # preorder: the right subtree comes after all of the left
        return path

    def _complaint(self, terms: tuple[int, ...], reading: Sequence[float] | NDArray[np.float64]) -> str:
        missing = [self.feature_names[j] for j in terms if np.isnan(reading[j])]
        return (
            f"reading has no number at {', '.join(missing)}, where the tree asks for one; leave it out, or use the "
            "filter, which can do without it"
        )

    def leaf_nodes(self, readings: NDArray[np.float64]) -> NDArray[np.intp]:
        """Return the preorder number of the leaf of every row of readings (n, n_features), shape (n,).

        Rows without a result get the number of nodes, one past the last.

        Raises
        ------
        DataError
            the rows have another length.
        """
        readings = np.ascontiguousarray(readings, dtype=np.float64)
        if readings.ndim != 2 or readings.shape[1] != len(self.feature_names):
            raise DataError(
                f"readings have shape {readings.shape}; expected (n, {len(self.feature_names)}), one column per feature"
            )
        found = np.empty(len(readings), dtype=np.intp)
        for first in range(0, len(readings), BLOCK):
            found[first : first + BLOCK] = self._route(readings[first : first + BLOCK])
        return found

    def labels(self, readings: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the class index of every row of readings (n, n_features), `REFUSED` where there is none, shape (n,).

        Raises
        ------
        DataError
            the rows have another length.
        """
        table = np.array([*self._labels, REFUSED], dtype=np.int64)
        return np.asarray(table[self.leaf_nodes(readings)])

    def _route(self, block: NDArray[np.float64]) -> NDArray[np.intp]:
        flat = block.ravel()
        first = np.arange(len(block), dtype=np.intp) * block.shape[1]
        node = np.zeros(len(block), dtype=np.intp)
        for _ in range(self._depth):
            total = self._totals(flat, first, node)
            threshold = self._thresholds.take(node)
            # 1 left, 2 right, 0 neither: NaN is on no side
            side = (total <= threshold).view(np.int8) + 2 * (total > threshold).view(np.int8)
            after = self._next.take(3 * node + side)
            if (side == 0).any():
                rows = np.flatnonzero((side == 0) & (self._n_terms.take(node) > 0))
                after[rows] = self._without_number(block, rows, node[rows], after[rows])
            node = after
        return node

    def _without_number(
        self, block: NDArray[np.float64], rows: NDArray[np.intp], node: NDArray[np.intp], after: NDArray[np.intp]
    ) -> NDArray[np.intp]:
        """Return the nodes after `node` for rows on neither side of a threshold: `after` unless they lack a reading."""
        n_terms = self._n_terms.take(node)
        lacks = np.zeros(len(rows), dtype=bool)
        for k, features in enumerate(self._features):
            lacks |= (k < n_terms) & np.isnan(block[rows, features.take(node)])
        adds = (n_terms > 1) & ~np.isnan(self._thresholds.take(node))  # infinity minus infinity goes right
        return np.where(lacks, self._missing.take(node), np.where(adds, self._next.take(3 * node + 2), after))

    def _totals(
        self, flat: NDArray[np.float64], first: NDArray[np.intp], node: NDArray[np.intp]
    ) -> NDArray[np.float64]:
        if not self._coefficients.size:
            return np.asarray(flat.take(first + self._features[0].take(node)))
        total = np.zeros(len(node))
        for features, coefficients in zip(self._features, self._coefficients, strict=True):
            weight = coefficients.take(node)
            with np.errstate(over="ignore", invalid="ignore"):  # beyond float64 is inf, as in `node`
                term = weight * flat.take(first + features.take(node))
                total += np.where(weight == 0.0, 0.0, term)  # a padded term may stand on a missing reading
        return total


def _levels(steps: Sequence[Step]) -> int:
    """Return the number of splits on the longest way."""
    level = [0] * len(steps)
    for k, (terms, _, _, left, right, _) in enumerate(steps):  # preorder: a node stands before its children
        if terms:
            level[left] = level[right] = level[k] + 1
    return max(level)

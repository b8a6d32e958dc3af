"""A tree compiled to flat steps, for streams: microseconds per reading; batches go the way of every prediction.

Same left rule as octmip.trees.nodes.tree to the last bit, and the same sides for missing readings (NaN). Where a split
on its way has no side for one, a reading has no result: `label` refuses it with a sentence; a batch, and every export,
returns `REFUSED`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.trees.nodes.prediction import predict
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, leaves, nodes, splits

REFUSED = -1
"""Result of a batch and of every export for a reading without a number where the tree asks for one."""

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
    """

    tree: Node
    feature_names: tuple[str, ...]
    _steps: tuple[Step, ...] = field(init=False, repr=False)
    _labels: tuple[int, ...] = field(init=False, repr=False)
    _positions: Node = field(init=False, repr=False)

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
        object.__setattr__(self, "_positions", _with_positions(self.tree, iter(range(self.n_leaves)), self.n_leaves))

    @property
    def n_leaves(self) -> int:
        """Number of leaves."""
        return len(leaves(self.tree))

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
        if isinstance(reading, np.ndarray):
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

    def leaf_index(self, readings: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the position of the leaf of every row of readings (n, n_features), leaves from the left, shape (n,).

        Rows without a result get the number of leaves, one past the last.

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
        return predict(self._positions, readings)

    def labels(self, readings: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the class index of every row of readings (n, n_features), `REFUSED` where there is none, shape (n,).

        Raises
        ------
        DataError
            the rows have another length.
        """
        table = np.array([*(leaf.label for leaf in leaves(self.tree)), REFUSED], dtype=np.int64)
        return np.asarray(table[self.leaf_index(readings)])


def _with_positions(node: Node, positions: Iterator[int], refused: int) -> Node:
    """Return a tree whose leaves have their positions for labels, and a leaf `refused` where a split has no side."""
    if isinstance(node, Leaf):
        return Leaf(next(positions))
    left, right = (_with_positions(side, positions, refused) for side in (node.left, node.right))
    if node.missing is not None:
        return replace(node, left=left, right=right)
    asked: Node = replace(node, left=left, right=right, missing="right")
    for feature in node.features:
        asked = Split(feature, None, Leaf(refused), asked, missing="left")
    return asked

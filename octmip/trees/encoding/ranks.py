"""Features as dense ranks, a problem as the native core holds it, and its tables of nodes as trees, there and back.

Ranks, not values, enter the core. Feature values of float64 become dense ranks 0, 1, ...; a cut "rank <= k" comes back
as the guarded midpoint of the k-th and (k+1)-th distinct value, so no float64 value is ever compared after rounding:

    values       0.5  0.5  1.5  4.0  4.0
    ranks          0    0    1    2    2
    cut 1 means   rank <= 1, threshold midpoint(1.5, 4.0) = 2.75

A feature that lacks readings is two columns of ranks, one after the other. In the first a missing reading ranks below
every other, so it goes left at every cut, and the lowest cut asks "is it missing?"; in the second it ranks above:

    values       0.5  NaN  1.5  4.0  NaN
    below          1    0    2    3    0        cut 1: 0.5 and missing left     cut 0: missing left
    above          0    3    1    2    3        cut 0: 0.5 left                 cut 2: missing right

A tree over the columns is a tree in which each split has a side for missing readings, and the other way round:
docs/theory/missing.md. All that searches, counts and proves does so over columns; `tree_from_rows` and
`rows_from_tree` translate. A cut of a column that ranks missing readings below the others (or above) is a split that
sends them left (right); the cut between missing readings and the others is the split that asks for nothing else.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TypedDict, final, overload

import numpy as np
from numpy.typing import NDArray

from octmip.trees import _native
from octmip.trees.encoding.costs import IntegerCosts
from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.reached import centred
from octmip.trees.nodes.tree import SIDES, HyperplaneSplit, Leaf, Node, Side, Split
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_values import refuse_missing


@dataclass(slots=True, eq=False)
class DistinctValues(Sequence[NDArray[np.float64]]):
    """The distinct values of each column, ascending, made when first asked for: a tree asks for few columns.

    Attributes
    ----------
    columns
        (n_samples, n_columns) what was ranked.
    table
        its dense ranks.
    n_values
        (n_columns,) how many distinct values each column has.
    """

    columns: NDArray[np.float64]
    table: _native.RankTable
    n_values: tuple[int, ...]
    _made: dict[int, NDArray[np.float64]] = field(default_factory=dict, repr=False)

    def __len__(self) -> int:
        return len(self.n_values)

    @overload
    def __getitem__(self, column: int) -> NDArray[np.float64]: ...
    @overload
    def __getitem__(self, column: slice) -> Sequence[NDArray[np.float64]]: ...
    def __getitem__(self, column: int | slice) -> NDArray[np.float64] | Sequence[NDArray[np.float64]]:
        if isinstance(column, slice):
            return [self[k] for k in range(len(self))[column]]
        column = range(len(self))[column]
        if column not in self._made:
            values = np.empty(self.n_values[column])
            values[self.table.column(column)] = self.columns[:, column]
            self._made[column] = values + 0.0  # of 0.0 and -0.0, which are equal, the first
        return self._made[column]

    def __iter__(self) -> Iterator[NDArray[np.float64]]:
        return (self[column] for column in range(len(self)))


@dataclass(frozen=True, slots=True, eq=False)
class Ranks:
    """Dense ranks of each column, and the distinct values behind them.

    Attributes
    ----------
    table
        the ranks as the native core holds them.
    values
        for each column its distinct values, ascending: ``features[i, j] == values[j][ranks[j, i]]``; what stands for
        missing readings is -inf in a column that ranks them below, inf in one that ranks them above.
    feature_of
        (n_columns,) the feature that each column reads; None: column j is feature j.
    missing
        (n_columns,) the side to which every cut of a column sends missing readings, None where none is missing.
    """

    table: _native.RankTable
    values: DistinctValues
    feature_of: tuple[int, ...] | None
    missing: tuple[Side | None, ...] | None

    @classmethod
    def of(
        cls,
        columns: NDArray[np.float64],
        feature_of: tuple[int, ...] | None = None,
        missing: tuple[Side | None, ...] | None = None,
    ) -> "Ranks":
        """Return the dense ranks of columns (n_samples, n_columns) without missing readings."""
        table, n_values = _native.dense_ranks(columns)
        return cls(table, DistinctValues(columns, table, tuple(n_values)), feature_of, missing)

    @property
    def ranks(self) -> NDArray[np.uint32]:
        """All ranks (n_columns, n_samples) uint32: a copy of the core's each time; `column` copies less."""
        return self.table.array()

    def column(self, column: int) -> NDArray[np.uint32]:
        """Return the ranks of one column (n_samples,)."""
        return self.table.column(column)

    @property
    def n_columns(self) -> int:
        """Number of columns."""
        return len(self.values)

    @property
    def n_values(self) -> tuple[int, ...]:
        """Number of distinct values of each column (n_columns,)."""
        return self.values.n_values

    def feature(self, column: int) -> int:
        """Return the feature that a column reads."""
        return column if self.feature_of is None else self.feature_of[column]

    def side(self, column: int) -> Side | None:
        """Return where the cuts of a column send missing readings; None where its feature lacks none."""
        return None if self.missing is None else self.missing[column]

    def columns_of(self, feature: int) -> tuple[int, ...]:
        """Return the columns that read a feature: itself, or one that ranks missing readings below and one above."""
        if self.feature_of is None:
            return (feature,)
        return tuple(column for column, read in enumerate(self.feature_of) if read == feature)


def rank_features(problem: Problem) -> Ranks:
    """Return the dense ranks of every feature of a problem, two columns for each that lacks readings."""
    samples = problem.samples
    with_missing = samples.features_with_missing if samples.takes_missing else ()
    if not with_missing:
        return Ranks.of(samples.features)
    n_columns = [2 if feature in with_missing else 1 for feature in range(samples.n_features)]
    feature_of = tuple(np.repeat(np.arange(samples.n_features), n_columns).tolist())
    missing = tuple(side for count in n_columns for side in (SIDES if count == 2 else (None,)))
    columns = samples.features[:, feature_of]
    for column, side in enumerate(missing):
        if side is not None:
            columns[np.isnan(columns[:, column]), column] = -np.inf if side == "left" else np.inf
    return Ranks.of(columns, feature_of, missing)


def native_problem(problem: Problem, ranks: Ranks, costs: IntegerCosts) -> _native.Problem:
    """Return the problem as the native core holds it, its features the columns of the ranks.

    Raises
    ------
    ProblemError
        splits are hyperplanes and readings are missing, of which the core knows nothing.
    """
    return _native.Problem(**native_arguments(problem, ranks, costs))


def native_arguments(problem: Problem, ranks: Ranks, costs: IntegerCosts) -> dict[str, Any]:
    """Return what the native core's problem is made of, as it can be sent to another process.

    Raises
    ------
    ProblemError
        splits are hyperplanes and readings are missing, of which the core knows nothing.
    """
    shape = problem.shape
    feature_of = [ranks.feature(column) for column in range(ranks.n_columns)]
    return {
        "ranks": ranks.table,
        "n_ranks": list(ranks.n_values),
        "labels": costs.rows.astype(np.uint32),
        "weights": costs.weights,
        "costs": costs.costs,
        "penalty": costs.penalty,
        "depth": shape.depth,
        "leaf_size": shape.leaf_size,
        "sensor_of_feature": shape.sensor_index[feature_of].tolist(),
        "sensor_cost": shape.sensor_costs.tolist(),
        "sensor_limit": shape.sensor_limit,
        "allowed": [shape.is_allowed((feature,)) for feature in feature_of],
        "planes": _planes(problem),
    }


def _planes(problem: Problem) -> dict[str, Any] | None:
    """Return data of hyperplane splits beside the ranks: values (n_samples, n_features) and the limits of a split."""
    shape = problem.shape
    if shape.max_split_size == 1:
        return None
    refuse_missing(problem.samples.n_missing, "hyperplanes add readings", "use split='axis', or fill them in")
    groups = shape.allowed_splits
    members = None if groups is None else [[int(feature) for feature in group] for group in groups]
    return {
        "values": np.ascontiguousarray(problem.samples.features),
        "split_size": shape.max_split_size,
        "groups": members,
        "integer_normals": shape.integer_normals,
    }


@final
class LeafRow(TypedDict):
    """A leaf of the native core's table."""

    label: int


@final
class SplitRow(TypedDict):
    """A split at a rank: as much and less goes left. `left` and `right` are the children's rows, further down."""

    feature: int
    cut: int
    left: int
    right: int


@final
class HyperplaneRow(TypedDict):
    """A split by a hyperplane, its terms (feature, coefficient)."""

    terms: list[tuple[int, float]]
    offset: float
    left: int
    right: int


NodeRow = LeafRow | SplitRow | HyperplaneRow
"""One node of the native core's table, in preorder, the root first."""


def tree_from_rows(rows: Sequence[NodeRow], ranks: Ranks) -> Node:
    """Return the tree that a native node table stands for, thresholds at guarded midpoints."""

    def build(index: int) -> Node:
        row = rows[index]
        if "label" in row:
            return Leaf(row["label"])
        left, right = build(row["left"]), build(row["right"])
        if "cut" in row:
            return cut_as_split(ranks, row["feature"], row["cut"], left, right)
        features, coefficients = zip(*sorted(row["terms"]), strict=True)
        return HyperplaneSplit(features, coefficients, row["offset"], left, right)

    return build(0)


def centred_tree(rows: Sequence[NodeRow], ranks: Ranks, features: NDArray[np.float64]) -> Node:
    """Return the tree that a native node table stands for, thresholds midway between the samples of their nodes."""
    return centred(tree_from_rows(rows, ranks), features)


def cut_as_split(ranks: Ranks, column: int, cut: int, left: Node, right: Node) -> Split:
    """Return the split that a cut of a column stands for, its threshold a guarded midpoint."""
    threshold = threshold_of_cut(ranks, column, cut)
    return Split(ranks.feature(column), threshold, left, right, missing=ranks.side(column))


def threshold_of_cut(ranks: Ranks, column: int, cut: int) -> float | None:
    """Return the guarded midpoint that a cut of a column stands for; None where it asks "is the reading missing?"."""
    values = ranks.values[column]
    low, high = float(values[cut]), float(values[cut + 1])
    return None if low == -np.inf or high == np.inf else midpoint(low, high)


def split_as_cut(ranks: Ranks, split: Split) -> tuple[int, int]:
    """Return the column and the cut of a split: the rank of the largest value on its left.

    A threshold outside the data's range is the nearest cut, or none: -1, or the last rank.
    """
    columns = ranks.columns_of(split.feature)
    column = next((column for column in columns if ranks.side(column) == split.missing), columns[0])
    values = ranks.values[column]
    if split.threshold is None:
        last = len(values) - 1
        # Where no reading is missing, or every one is, such a split parts nothing.
        has_gap = split.missing == ranks.side(column)
        return column, (0 if has_gap else -1) if split.missing == "left" else (last - 1 if has_gap else last)
    return column, int(np.searchsorted(values, split.threshold, side="right")) - 1


def rows_from_tree(tree: Node, ranks: Ranks) -> list[NodeRow]:
    """Return the native node table of a tree; a threshold outside the data's range becomes the nearest cut."""
    rows: list[NodeRow] = []

    def add(node: Node) -> int:
        index = len(rows)
        rows.append({"label": node.label if isinstance(node, Leaf) else 0})
        if isinstance(node, Leaf):
            return index
        left, right = add(node.left), add(node.right)
        if isinstance(node, Split):
            # Trees whose sides all hold samples (see `without_empty_sides`) have 0 <= cut < number of values - 1.
            feature, cut = split_as_cut(ranks, node)
            rows[index] = {"feature": feature, "cut": cut, "left": left, "right": right}
        else:
            terms = list(zip(node.features, node.coefficients, strict=True))
            rows[index] = {"terms": terms, "offset": node.offset, "left": left, "right": right}
        return index

    add(tree)
    return rows

"""Trees as recursive nodes, and the one place that says which way a sample goes.

The left rule: a sample x goes left when ``x[feature] <= threshold`` at a `Split`, and when
``sum_j coefficients[j] * x[features[j]] <= offset`` at a `HyperplaneSplit`, the products rounded to float64 and added
from the first feature to the last. Otherwise it goes right. Five values of one feature and a threshold between them:

    x          0.5  1.5  2.5  3.5  4.5
    threshold            2.5
    goes to    L    L    L    R    R

Missing readings (NaN) go to the side that the split names, `missing`; None, where training knew of none, refuses them.
A sample lacks a hyperplane's reading when it lacks any of its features. A `Split` without a threshold asks "is it
missing?" alone: every reading goes to the other side.

    x          0.5  NaN  2.5  3.5  NaN
    missing            left
    2.5 goes   L    L    L    R    L
    None goes  R    L    R    R    L
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TreeError
from octmip.input.messages import InWords
from octmip.trees.nodes.digits import exact

Side = Literal["left", "right"]
"""Where a split sends a missing reading."""
SIDES: tuple[Side, Side] = ("left", "right")
MOST_LEAVES, MOST_LINES = 16, 50
"""Of a tree as Python shows it: leaves that are spelled out, and lines."""


class _Called(InWords):
    __slots__ = ()

    def __repr__(self) -> str:
        """Return the call that makes the node; of a large tree how many leaves it has in their place."""
        n_leaves = len(leaves(cast("Node", self)))
        if n_leaves > MOST_LEAVES:
            return f"{type(self).__name__}(n_leaves={n_leaves})"
        given = [one for one in fields(cast("Node", self)) if one.init and getattr(self, one.name) != one.default]
        words = [f"{one.name}=" * bool(one.kw_only) + repr(getattr(self, one.name)) for one in given]
        return f"{type(self).__name__}({', '.join(words)})"

    def __str__(self) -> str:
        """Return the tree as indented lines, as many as a screen holds; features and classes by their index."""
        return "\n".join(first_lines(cast("Node", self)))


@dataclass(frozen=True, slots=True, repr=False)
class Leaf(_Called):
    """A prediction: `label` is the index of the class in `Samples.class_names`.

    >>> print(Leaf(1))
    class 1
    """

    label: int

    def __post_init__(self) -> None:
        if self.label < 0:
            raise TreeError(f"leaf label is {self.label}; expected the index of a class, 0 or more")


@dataclass(frozen=True, slots=True, repr=False)
class ValueLeaf(Leaf):
    """A predicted number, of a regression tree: `value`, plus ``coefficients @ x[features]`` in a linear leaf.

    >>> print(ValueLeaf(20.0, features=(3,), coefficients=(-0.5,)))
    20 - 0.5 x3
    """

    label: int = field(default=0, init=False)
    value: float
    features: tuple[int, ...] = ()
    coefficients: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        numbers = (self.value, *self.coefficients)
        if not all(np.isfinite(numbers)):
            raise TreeError(
                f"a leaf predicts {self.value} with coefficients {self.coefficients}; expected finite numbers"
            )
        is_ascending = all(a < b for a, b in zip(self.features, self.features[1:], strict=False))
        if len(self.features) != len(self.coefficients) or not is_ascending or min(self.features, default=0) < 0:
            raise TreeError(
                f"a linear leaf has features {self.features} and {len(self.coefficients)} coefficients; expected one "
                "coefficient for each feature, ascending indices, none twice"
            )


@dataclass(frozen=True, slots=True, repr=False)
class Split(_Called):
    """A threshold on one feature: left when ``x[feature] <= threshold``; without one, "is the reading missing?".

    >>> predict(Split(0, 2.5, Leaf(0), Leaf(1)), [[2.5], [3.0]])
    array([0, 1])
    """

    feature: int
    threshold: float | None
    left: "Node"
    right: "Node"
    missing: Side | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.feature < 0:
            raise TreeError(f"split feature is {self.feature}; expected the index of a feature, 0 or more")
        if self.threshold is not None and not np.isfinite(self.threshold):
            raise TreeError(f"threshold on feature {self.feature} is {self.threshold}; expected a finite number")
        _check_side(self.missing, f"feature {self.feature}")
        if self.threshold is None and self.missing is None:
            raise TreeError(
                f"the split on feature {self.feature} has neither a threshold nor a side for missing readings; "
                "expected one at least; give a threshold, or missing='left' or 'right'"
            )

    @property
    def features(self) -> tuple[int, ...]:
        """The one feature, as a tuple, so that both kinds of split read alike."""
        return (self.feature,)


@dataclass(frozen=True, slots=True, repr=False)
class HyperplaneSplit(_Called):
    """A hyperplane over `features` (ascending, none twice): left when ``coefficients @ x[features] <= offset``.

    >>> predict(HyperplaneSplit((0, 1), (1.0, -1.0), 0.0, Leaf(0), Leaf(1)), [[1, 2], [2, 1]])
    array([0, 1])
    """

    features: tuple[int, ...]
    coefficients: tuple[float, ...]
    offset: float
    left: "Node"
    right: "Node"
    missing: Side | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        _check_side(self.missing, f"features {self.features}")
        if not self.features or len(self.features) != len(self.coefficients):
            raise TreeError(
                f"hyperplane has {len(self.features)} features and {len(self.coefficients)} coefficients; "
                "expected one coefficient for each of at least one feature"
            )
        if self.features[0] < 0 or any(a >= b for a, b in zip(self.features, self.features[1:], strict=False)):
            raise TreeError(f"hyperplane features are {self.features}; expected ascending indices, none twice")
        if not all(np.isfinite((*self.coefficients, self.offset))) or 0.0 in self.coefficients:
            raise TreeError(
                f"hyperplane over features {self.features} has coefficients {self.coefficients} and offset "
                f"{self.offset}; expected finite numbers, no coefficient zero"
            )


Node = Leaf | Split | HyperplaneSplit


def _check_side(side: object, where: str) -> None:
    if side not in (None, *SIDES):
        raise TreeError(f"missing readings of {where} go to {side!r}; expected 'left', 'right' or None")


def goes_left(
    split: Split | HyperplaneSplit, features: NDArray[np.float64], rows: NDArray[np.int64] | slice = slice(None)
) -> NDArray[np.bool_]:
    """Return which of the `rows` of `features` (n_samples, n_features) go left at `split`, shape (n_rows,).

    Raises
    ------
    TreeError
        a reading that the split asks for is missing (NaN), and it has no side for it.
    """
    left, is_missing = _sides_of_readings(split, features, rows)
    if is_missing.any():
        if split.missing is None:
            raise _refused_gap(split, is_missing, rows)
        left[is_missing] = split.missing == "left"
    return left


def lacks_reading(
    split: Split | HyperplaneSplit, features: NDArray[np.float64], rows: NDArray[np.int64] | slice
) -> NDArray[np.bool_]:
    """Return which of the `rows` of `features` lack a reading that `split` asks for, shape (n_rows,)."""
    return np.asarray(np.isnan(np.stack([features[rows, feature] for feature in split.features])).any(axis=0))


def _sides_of_readings(
    split: Split | HyperplaneSplit, features: NDArray[np.float64], rows: NDArray[np.int64] | slice
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which rows go left by their readings, and which lack one."""
    # Only the columns that are asked for: gathering whole rows costs more than all else where features are many.
    if isinstance(split, Split):
        values = features[rows, split.feature]
        if split.threshold is None:
            return np.full(len(values), split.missing == "right"), np.isnan(values)
        return np.less_equal(values, np.float64(split.threshold)), np.isnan(values)  # of float32: not rounded
    total = np.zeros(len(features[rows, split.features[0]]))
    with np.errstate(over="ignore", invalid="ignore"):  # beyond float64 is inf; inf - inf is no number and goes right
        for feature, coefficient in zip(split.features, split.coefficients, strict=True):
            total += np.float64(coefficient) * features[rows, feature]
    is_number = np.isfinite(total).all()
    return total <= split.offset, np.zeros(len(total), dtype=bool) if is_number else lacks_reading(
        split, features, rows
    )


def _refused_gap(
    split: Split | HyperplaneSplit, is_missing: NDArray[np.bool_], rows: NDArray[np.int64] | slice
) -> TreeError:
    first = int(is_missing.argmax())
    row = first if isinstance(rows, slice) else int(rows[first])
    feature = f"feature {split.features[0]}" if len(split.features) == 1 else f"one of the features {split.features}"
    n_rows = int(is_missing.sum())
    return TreeError(
        f"row {row} lacks its reading of {feature} (NaN; {n_rows} such row{'s' * (n_rows != 1)} at this split), and "
        "the tree has no side for missing readings; expected a number; fill it in, or train with missing readings "
        "(Problem(..., takes_missing=True))"
    )


def leaf_index(tree: Node, features: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return for every row of `features` (n_samples, n_features) the position of its leaf in `leaves(tree)`."""
    index = np.zeros(len(features), dtype=np.int64)
    first = 0
    stack: list[tuple[Node, NDArray[np.int64]]] = [(tree, np.arange(len(features)))]
    while stack:  # preorder with left on top of the stack, so leaves are numbered from left to right
        node, rows = stack.pop()
        if isinstance(node, Leaf):
            index[rows] = first
            first += 1
        else:
            left = goes_left(node, features, rows)
            stack += [(node.right, rows[~left]), (node.left, rows[left])]
    return index


def predict(tree: Node, features: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the class index of every row of `features` (n_samples, n_features), shape (n_samples,)."""
    labels = np.array([leaf.label for leaf in leaves(tree)], dtype=np.int64)
    return labels[leaf_index(tree, features)]


def predict_values(
    tree: Node, features: NDArray[np.float64], reached: NDArray[np.int64] | None = None
) -> NDArray[np.float64]:
    """Return the number that a regression tree predicts for every row of `features`, shape (n_samples,).

    The products of a linear leaf are rounded to float64 and added from the first feature to the last. Whoever knows the
    leaf of every row gives it as `reached` (n_samples,).

    Raises
    ------
    TreeError
        a leaf predicts a class, not a number; or a prediction is beyond float64.
    """
    reached, values = leaf_index(tree, features) if reached is None else reached, np.zeros(len(features))
    for k, leaf in enumerate(leaves(tree)):
        if not isinstance(leaf, ValueLeaf):
            raise TreeError(f"leaf {k} (from the left) predicts a class; expected a regression tree, with numbers")
        rows = np.flatnonzero(reached == k)
        values[rows] = leaf.value
        with np.errstate(over="ignore", invalid="ignore"):
            for feature, coefficient in zip(leaf.features, leaf.coefficients, strict=True):
                values[rows] += np.float64(coefficient) * features[rows, feature]
    beyond = np.flatnonzero(~np.isfinite(values))
    if beyond.size:
        raise TreeError(
            f"the prediction for row {beyond[0]} is beyond float64 (leaf {reached[beyond[0]]} from the left); expected "
            "finite numbers; give leaves of smaller coefficients, or samples like those of training"
        )
    return values


def nodes(tree: Node) -> Iterator[Node]:
    """Yield every node in preorder: a node, its left subtree, its right subtree."""
    stack = [tree]
    while stack:
        node = stack.pop()
        yield node
        if not isinstance(node, Leaf):
            stack += [node.right, node.left]


def splits(tree: Node) -> list[Split | HyperplaneSplit]:
    """Return the splits in preorder."""
    return [node for node in nodes(tree) if not isinstance(node, Leaf)]


def leaves(tree: Node) -> list[Leaf]:
    """Return the leaves from left to right."""
    return [node for node in nodes(tree) if isinstance(node, Leaf)]


def depth(tree: Node) -> int:
    """Return the number of splits on the longest path from the root to a leaf (0 for a leaf)."""
    return 0 if isinstance(tree, Leaf) else 1 + max(depth(tree.left), depth(tree.right))


def n_splits(tree: Node) -> int:
    """Return the number of splits."""
    return len(splits(tree))


def complexity(tree: Node) -> int:
    """Return the number of features summed over the splits: what `Shape.leaf_penalty` is paid for.

    It is the number of splits of an axis-aligned tree. Source: Bertsimas & Dunn (2017), eq. 24 (OCT) and 36 (OCT-H).
    """
    return sum(len(split.features) for split in splits(tree))


def features_used(tree: Node) -> tuple[int, ...]:
    """Return the features that some split, or some linear leaf, reads, ascending."""
    read = (node.features for node in nodes(tree) if not isinstance(node, Leaf) or isinstance(node, ValueLeaf))
    return tuple(sorted(set().union(*read)))


def with_sides_for_missing(tree: Node, features: NDArray[np.float64], weights: NDArray[np.float64]) -> Node:
    """Return the tree with a side for missing readings at every split.

    Where rows of `features` (n_samples, n_features) lack the reading at its split, the side is the split's own.
    Elsewhere nothing was learnt of it, and it is the side with more of the `weights` (n_samples,), left of equals;
    so too where the split has none.
    """

    def sided(node: Node, rows: NDArray[np.int64]) -> Node:
        if isinstance(node, Leaf):
            return node
        left, is_missing = _sides_of_readings(node, features, rows)
        missing = node.missing
        if missing is None or not is_missing.any():
            weight = weights[rows]
            missing = "left" if weight[left & ~is_missing].sum() >= weight[~left & ~is_missing].sum() else "right"
        left[is_missing] = missing == "left"
        return replace(node, left=sided(node.left, rows[left]), right=sided(node.right, rows[~left]), missing=missing)

    return sided(tree, np.arange(len(features)))


def simplify(tree: Node) -> Node:
    """Return the tree without splits whose two sides are leaves of the same label (same predictions, fewer splits)."""
    if isinstance(tree, Leaf):
        return tree
    left, right = simplify(tree.left), simplify(tree.right)
    if isinstance(left, Leaf) and left == right:
        return left
    return replace(tree, left=left, right=right)


def prediction(leaf: Leaf, name: Callable[[int], str]) -> str:
    """Return what a leaf predicts on one line, features by their `name`, its numbers `exact`."""
    if not isinstance(leaf, ValueLeaf):
        return f"class {leaf.label}"
    terms = [exact(leaf.value)]
    for feature, coefficient in zip(leaf.features, leaf.coefficients, strict=True):
        terms.append(f"{'-' if coefficient < 0 else '+'} {exact(abs(coefficient))} {name(feature)}")
    return " ".join(terms)


def condition(split: Split | HyperplaneSplit, name: Callable[[int], str]) -> str:
    """Return the condition for going left on one line, features by their `name`, its numbers `exact`."""
    or_missing = " or missing" if split.missing == "left" else ""
    if isinstance(split, Split):
        if split.threshold is None:
            return f"{name(split.feature)} is {'' if or_missing else 'not '}missing"
        return f"{name(split.feature)} <= {exact(split.threshold)}{or_missing}"
    terms = ""
    for feature, coefficient in zip(split.features, split.coefficients, strict=True):
        sign = (" - " if coefficient < 0 else " + ") if terms else ("-" if coefficient < 0 else "")
        size = "" if abs(coefficient) == 1 else f"{exact(abs(coefficient))} "
        terms += f"{sign}{size}{name(feature)}"
    return f"{terms} <= {exact(split.offset)}{or_missing}"


def tree_lines(
    tree: Node, question: Callable[[Split | HyperplaneSplit], str], decision: Callable[[Leaf], str]
) -> list[str]:
    """Return a tree as indented lines, left before right; `decision` is called for the leaves from the left."""
    if isinstance(tree, Leaf):
        return [decision(tree)]
    left, right = (tree_lines(side, question, decision) for side in (tree.left, tree.right))
    return [f"if {question(tree)}", *(f"    {line}" for line in left), "else", *(f"    {line}" for line in right)]


def first_lines(tree: Node) -> list[str]:
    """Return a tree as indented lines, features and classes by their index; of a large one the first lines alone."""
    lines = tree_lines(tree, lambda split: condition(split, "x{}".format), lambda leaf: prediction(leaf, "x{}".format))
    if len(lines) <= MOST_LINES:
        return lines
    first = lines[:MOST_LINES]
    shown = sum(not line.strip().startswith(("if ", "else")) for line in first)
    more = f"... {len(leaves(tree)) - shown} more leaves; export_text() of an estimator has all, and octmip report"
    return [*first, more]

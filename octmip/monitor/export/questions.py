"""A tree in terms of the columns of the user's own table: what every export writes down in its language.

A tree reads features. A text column has many, one for each question, and a date is a number of days there. Whoever
receives an export has the column. So each split becomes a question about a column:

    NumberAsked   is the number of a column at most a threshold?
    TextAsked     is the text of a column among these?
    SumAsked      is a sum over columns at most an offset?

Each says where a missing cell goes. None means nowhere: `predict` refuses such a row, and an export has no answer.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TreeError
from octmip.formats.columns import Columns, Feature, FeatureNames
from octmip.formats.columns.column import Column
from octmip.input.messages import several
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Side, Split, ValueLeaf, features_used, leaves
from octmip.trees.question.shape import MAX_DEPTH


@dataclass(frozen=True, slots=True)
class NumberAsked:
    """Whether the number in `column` is at most `threshold`; without one, whether it is missing."""

    column: int
    threshold: float | None
    missing: Side | None


@dataclass(frozen=True, slots=True)
class TextAsked:
    """Whether the text in `column` is one of `left` or of `right`; `others`: where one goes that training had not."""

    column: int
    left: tuple[str, ...]
    right: tuple[str, ...]
    others: Side | None
    missing: Side | None

    def texts(self, side: Side) -> tuple[str, ...]:
        """Return the texts that go to a side."""
        return self.left if side == "left" else self.right


@dataclass(frozen=True, slots=True)
class Term:
    """A number that is added: `coefficient` times what the cell of `column` counts.

    Attributes
    ----------
    least, most
        a number beyond them counts as they do; None: no such end.
    counts
        of a text column, what each text counts; none of a column of numbers.
    others, missing
        what another text and a missing cell count; None: there is no sum.
    """

    coefficient: float
    column: int
    least: float | None = None
    most: float | None = None
    counts: tuple[tuple[str, float], ...] = ()
    others: float | None = None
    missing: float | None = None


@dataclass(frozen=True, slots=True)
class SumAsked:
    """Whether the sum of `terms`, from the first to the last, is at most `offset`; one that is no number is not."""

    terms: tuple[Term, ...]
    offset: float
    missing: Side | None


Asked = NumberAsked | TextAsked | SumAsked


@dataclass(frozen=True, slots=True)
class Answer:
    """What a leaf answers: the class's own value, or a number plus the sum of `terms`."""

    value: Any
    terms: tuple[Term, ...] = ()


@dataclass(frozen=True, slots=True)
class Fork:
    """A question and what follows from it."""

    asked: Asked
    left: "Part"
    right: "Part"


Part = Answer | Fork
ClassNames = Sequence[Any] | NDArray[Any] | None
"""The classes by their index, as an estimator's `classes_`; None of numbers, or for the indices themselves."""


@dataclass(frozen=True, slots=True, eq=False)
class OwnTree:
    """A tree over the columns of a table.

    Attributes
    ----------
    root
        its first question.
    columns
        all columns of the table that it was trained on, in their order.
    read
        positions of those that it reads.
    answers
        the values that it may answer: all classes, none of a tree of numbers.
    are_indices
        whether these are indices of classes that have no names.
    """

    root: Part
    columns: tuple[Column, ...]
    read: tuple[int, ...]
    answers: tuple[Any, ...]
    are_indices: bool = False

    @property
    def answers_text(self) -> bool:
        """Whether the answers are texts, not numbers or Booleans."""
        return isinstance(next(iter(self.answers), 0), str)


def own_tree(tree: Node, columns: Columns | Sequence[str], class_names: ClassNames = None) -> OwnTree:
    """Return a tree over the columns of a table.

    Parameters
    ----------
    columns
        how the columns became the features that the tree reads (`TreeFile.columns`, an estimator's `columns_`, or its
        `feature_names`, which know them), or other names where each feature is a column of numbers.
    class_names
        value of each class, in the order of the problem's; None: its index, from 0. Not read where leaves hold numbers.

    Raises
    ------
    TreeError
        the tree reads a feature or predicts a class without a name, has more than `MAX_DEPTH` levels, or has classes
        that are neither all texts, all numbers nor all Booleans.
    """
    _check_depth(tree)
    if isinstance(columns, FeatureNames):
        columns = columns.columns
    if not isinstance(columns, Columns):
        columns = Columns(tuple(Column(str(name), "number", True) for name in columns))
    places = tuple((k, feature) for k, column in enumerate(columns.columns) for feature in column.features)
    read = features_used(tree)
    if read and read[-1] >= len(places):
        raise TreeError(
            f"the tree reads feature {read[-1]} but feature_names has {len(places)} entries; expected at least "
            f"{read[-1] + 1}; name every feature of a reading, in its order"
        )
    is_number = any(isinstance(leaf, ValueLeaf) for leaf in leaves(tree))
    answers = () if is_number else _class_values(tree, class_names)
    writer = _Writer(columns.columns, places, answers)
    used = sorted({places[feature][0] for feature in read})
    return OwnTree(writer.part(tree), columns.columns, tuple(used), answers, class_names is None and not is_number)


def _class_values(tree: Node, class_names: ClassNames) -> tuple[Any, ...]:
    """Return class names as plain Python has them: texts, numbers or Booleans; without names their indices."""
    label = max(leaf.label for leaf in leaves(tree))
    if class_names is None:
        return tuple(range(label + 1))
    if label >= len(class_names):
        raise TreeError(
            f"the tree predicts class {label} but class_names has {len(class_names)} entries; expected at least "
            f"{label + 1}; name every class, in the order of the problem's"
        )
    values = tuple(name.item() if isinstance(name, np.generic) else name for name in class_names)
    kinds = {"number" if type(value) in (int, float) else type(value).__name__ for value in values}
    if len(kinds) > 1 or not kinds <= {"number", "str", "bool"} or not all(np.isfinite(_numbers(values))):
        raise TreeError(
            f"the classes are {several(values, 3)}; expected texts, finite numbers or Booleans alone, which every "
            "language can answer; train with such labels"
        )
    return values


def _numbers(values: tuple[Any, ...]) -> list[float]:
    return [value for value in values if isinstance(value, float)]


@dataclass(frozen=True, slots=True)
class _Writer:
    """Columns, the column and the question of each feature, and the answers of the classes."""

    columns: tuple[Column, ...]
    places: tuple[tuple[int, Feature], ...]
    answers: tuple[Any, ...]

    def part(self, node: Node) -> Part:
        if isinstance(node, ValueLeaf):
            terms = zip(node.coefficients, node.features, strict=True)
            return Answer(float(node.value), tuple(self.term(float(c), j) for c, j in terms))
        if isinstance(node, Leaf):
            return Answer(self.answers[node.label])
        asked = self.asked(node)
        if isinstance(asked, NumberAsked) and asked.threshold in (-math.inf, math.inf):  # it parts no rows
            return self.part(node.left if asked.missing == "left" else node.right)
        return Fork(asked, self.part(node.left), self.part(node.right))

    def asked(self, split: Split | HyperplaneSplit) -> Asked:
        if isinstance(split, HyperplaneSplit):
            terms = zip(split.coefficients, split.features, strict=True)
            return SumAsked(tuple(self.term(float(c), j) for c, j in terms), float(split.offset), split.missing)
        place, feature = self.places[split.feature]
        column = self.columns[place]
        if column.kind != "number":
            return self.text_asked(place, feature, split)
        threshold = None if split.threshold is None else float(split.threshold)
        if not column.is_doubled or threshold is None:
            return NumberAsked(place, threshold, split.missing)
        return _of_doubled(place, column, feature, threshold)

    def text_asked(self, place: int, feature: Feature, split: Split) -> TextAsked:
        """Return which texts go where: those of training by their answer or rank, others as `Column.encode` says."""
        column = self.columns[place]
        term = self.term(1.0, split.feature)

        def side(number: float | None) -> Side | None:
            if number is None:
                return None
            if split.threshold is None:
                return "right" if split.missing == "left" else "left"
            return "left" if number <= split.threshold else "right"

        sides = [(word, side(number)) for word, number in term.counts]
        lacks = column.kind == "order" and not column.is_doubled
        return TextAsked(
            place,
            tuple(word for word, goes in sides if goes == "left"),
            tuple(word for word, goes in sides if goes == "right"),
            side(term.others),
            split.missing if lacks else side(term.missing),
        )

    def term(self, coefficient: float, feature: int) -> Term:
        """Return what the cells of a feature's column count, as `Column.encode` has it."""
        place, item = self.places[feature]
        column = self.columns[place]
        missing = column.beyond[item.kind == "missing-right"] if column.is_doubled else None
        if column.kind == "number":
            least = column.least if item.kind == "missing-left" else None
            most = column.most if item.kind == "missing-right" else None
            return Term(coefficient, place, least, most, missing=missing)
        if column.kind == "order":
            ranks = tuple((word, float(k)) for k, word in enumerate(column.values))
            return Term(coefficient, place, counts=ranks, missing=missing)
        members = {"is": (item.value,), "is-missing": (None,), "among": item.members}[item.kind]
        counts = tuple((word, float(word in members)) for word in column.values)
        return Term(coefficient, place, None, None, counts, 0.0, float(None in members) if column.has_missing else None)


def _of_doubled(place: int, column: Column, feature: Feature, threshold: float) -> NumberAsked:
    """Return a split of a feature that places missing cells below or above the range of all numbers."""
    is_left = feature.kind == "missing-left"
    missing: Side = "left" if column.beyond[not is_left] <= threshold else "right"
    if (threshold >= column.least) if is_left else (threshold < column.most):
        return NumberAsked(place, threshold, missing)
    numbers: Side = "right" if is_left else "left"
    nowhere = -math.inf if numbers == "right" else math.inf
    return NumberAsked(place, nowhere if missing == numbers else None, missing)


def _check_depth(tree: Node) -> None:
    """Refuse a tree that is too deep, without recursion: it may be deeper than Python's stack."""
    level = [tree]
    for _ in range(MAX_DEPTH + 1):
        level = [side for node in level if not isinstance(node, Leaf) for side in (node.left, node.right)]
        if not level:
            return
    raise TreeError(
        f"the tree has more than {MAX_DEPTH} levels of splits; expected a depth that a problem can have, which "
        "compilers and databases hold too; find a tree with Problem(depth=...) of at most that"
    )

"""Columns: how the columns of any table become the features of a Problem, the same way in training and prediction.

`Columns.learn` looks at a table once; `encode` applies what it found to that table and to any later one. What was
encoded, and how, is said by `changes`; a column that cannot be used is refused, all of them in one error.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.columns.cells import Cells, read_cells
from octmip.formats.columns.column import CONTENT, MOST_LEVELS, Column, Feature
from octmip.formats.columns.times import complaint_of
from octmip.formats.columns.written import words_of
from octmip.input.cells import plain_number
from octmip.input.checked import ListOf, Record
from octmip.input.messages import MOST_NAME, shown
from octmip.trees.nodes.digits import exact
from octmip.trees.nodes.tree import Leaf, Node, Split, goes_left

Categories = Literal["yes-no", "subsets", "order", "refuse"]
Missing = Literal["either-side", "refuse"]
MOST_VALUES = 100
"""Different texts of a column that becomes yes/no questions."""
EMPTY = "has no value in any row; leave it out"
MOST_UNIQUE = 0.5
"""Share of rows with a text of their own, above which a text names the rows; in a part of a table every row has one."""
FEW_VALUES = 20
"""As few different texts never name the rows."""
HAS_DIGIT = re.compile("[0-9]").search
COLUMNS = Record({"columns": ListOf(CONTENT, least=1)}, closed=True)


class ColumnsError(DataError):
    """Columns that cannot become features; `reasons` has a sentence for each, with its cure."""

    def __init__(self, reasons: Mapping[str, str], n_columns: int) -> None:
        self.reasons = dict(reasons)
        listed = "; ".join(f"{shown(name)} {reason}" for name, reason in reasons.items())
        super().__init__(f"{len(reasons)} of {n_columns} columns cannot be used: {listed}")


class FeatureNames(tuple[str, ...]):
    """Names of features that know their `columns`: an export that is given the names alone speaks of the columns."""

    columns: "Columns"


@dataclass(frozen=True, slots=True)
class Columns:
    """How the columns of a table become features.

    Attributes
    ----------
    columns
        each column, in the order of the table.
    """

    columns: tuple[Column, ...]

    @classmethod
    def learn(
        cls,
        frame: pd.DataFrame,
        *,
        categories: Categories = "yes-no",
        missing: Missing = "either-side",
        doubled: bool = False,
        of_part: bool = False,
    ) -> Self:
        """Return how the columns of a table become features.

        Parameters
        ----------
        frame
            the columns to split on: numbers, booleans, text or pandas categories, cells missing or not.
        categories
            text becomes yes/no features, one per value ("yes-no") or one per set of values ("subsets"), its rank in
            alphabetical order or that of an ordered category ("order"), or is refused ("refuse"). An ordered category
            becomes its rank in the first two cases too.
        missing
            missing cells go to whichever side of a split is better ("either-side"), and no split reads a column without
            a value; or both are refused ("refuse").
        doubled
            a number or rank with missing cells becomes two complete features, for trees whose splits have no side for
            missing readings.
        of_part
            the frame may be a part of a table, as in cross-validation: texts may have lost most of their repetitions.

        Raises
        ------
        ColumnsError
            columns cannot be used; all of them are named.
        """
        found: list[Column] = []
        reasons: dict[str, str] = {}
        for name, series in zip(_names_of(frame), _series_of(frame), strict=True):
            try:
                cells = read_cells(series)
                if missing != "refuse" and cells.n_missing == len(frame):
                    found.append(Column(name, "empty", has_missing=True))
                    continue
                _refuse(cells, len(frame), categories, missing, 1 - 1 / len(frame) if of_part else MOST_UNIQUE)
                found.append(_column_of(name, cells, categories, doubled))
            except DataError as error:
                reasons[name] = str(error)
        if not (of_part or reasons) and all(column.kind == "empty" for column in found):
            reasons = {column.name: EMPTY for column in found}
        if reasons:
            raise ColumnsError(reasons, frame.shape[1])
        out = cls(tuple(found))
        out._check_names()
        return out

    def _check_names(self) -> None:
        names = self.feature_names
        twice = next((name for name in names if names.count(name) > 1), None) if len(set(names)) < len(names) else None
        if twice is not None:
            raise DataError(f"two features would both be called {shown(twice)}; rename a column")

    @property
    def features(self) -> tuple[Feature, ...]:
        """Every feature, in the order of the columns of `encode`."""
        return tuple(feature for column in self.columns for feature in column.features)

    @property
    def feature_names(self) -> "FeatureNames":
        """(n_features,) names: that of the column where nothing was encoded."""
        names = FeatureNames(feature.name for feature in self.features)
        names.columns = self
        return names

    @property
    def column_of_feature(self) -> tuple[str, ...]:
        """(n_features,) the column that each feature reads: `Shape.sensor_of_feature`, as one reading costs once."""
        return tuple(feature.column for feature in self.features)

    @property
    def names(self) -> tuple[str, ...]:
        """(n_columns,) names of the columns."""
        return tuple(column.name for column in self.columns)

    @property
    def lack_numbers(self) -> bool:
        """Whether some feature is NaN where a cell is missing: every split of a tree then has a side for such cells."""
        return any(column.lacks_numbers for column in self.columns)

    @property
    def is_plain(self) -> bool:
        """Whether every feature is its column as it stands, written as a plain number."""
        is_number = all(feature.kind == "number" for feature in self.features)
        return is_number and not any(column.form for column in self.columns)

    def encode(self, frame: pd.DataFrame, *, takes_missing: bool | None = None) -> NDArray[np.float64]:
        """Return the features of a table's rows, shape (n_rows, n_features), NaN where a number is missing.

        Columns are found by name, others are left alone. A text that training had not gets the answer "no" to each
        question for its value; `unseen` names such texts. Where every column is float32, so are the features.

        A tree that has a side for missing readings at every split takes missing cells in any column, NaN in its
        features where training had none: `takes_missing`, by default whether some column lacked numbers in training.

        Raises
        ------
        ColumnsError
            columns are missing or hold what they did not in training; all of them are named.
        """
        position = {name: k for k, name in enumerate(_names_of(frame))}
        takes_missing = self.lack_numbers if takes_missing is None else takes_missing
        blocks: list[NDArray[np.float64]] = []
        reasons: dict[str, str] = {}
        for column in self.columns:
            try:
                if column.name not in position:
                    raise DataError("is not in the table; spell it as in training")
                given = frame.iloc[:, position[column.name]]
                if column.kind == "empty":  # no split reads it
                    blocks.append(np.zeros((len(frame), 1), dtype=np.float32))
                    continue
                block = _encoded(column, read_cells(given, column.form), takes_missing)
                # What stands for a missing cell is no float32, and a sum that adds it must not depend on the table.
                is_single = given.dtype == np.float32 and not column.is_doubled
                blocks.append(block.astype(np.float32) if is_single else block)
            except DataError as error:
                reasons[column.name] = str(error)
        if reasons:
            raise ColumnsError(reasons, len(self.columns))
        return np.hstack(blocks)

    def refuse_missing_in_sums(self, cure: str) -> None:
        """Refuse numbers with missing cells where features are added, as a hyperplane does: the sum has no value.

        Raises
        ------
        DataError
            there are such columns; the sentence ends with `cure`.
        """
        lacking = [shown(c.name) for c in self.columns if c.has_missing and c.kind in ("number", "order")]
        if lacking:
            named = ", ".join(lacking[:5]) + (f" and {len(lacking) - 5} more" if len(lacking) > 5 else "")
            raise DataError(
                f"cells are missing in {named}; a hyperplane adds its features, and a sum with a missing value has "
                f"none; {cure}"
            )

    def unseen(self, frame: pd.DataFrame) -> tuple[str, ...]:
        """Return a sentence for each column of text with values that training had not."""
        found = []
        for column in self.columns:
            if column.values:
                words = column.words_of(read_cells(frame[column.name], column.form)).tolist()
                new = sorted(set(words) - {None, *column.values})
                if new:
                    rows = sum(word in new for word in words)
                    answer = (
                        "every question for a value is answered no" if column.asks_texts else "it counts as missing"
                    )
                    found.append(
                        f"{column.name} holds {shown(new[0])} ({len(new)} such values, {rows} rows), which training "
                        f"had not; {answer}"
                    )
        return tuple(found)

    def changes(self) -> tuple[str, ...]:
        """Return what was encoded, and how, as sentences; none where every feature is its column."""
        asked = [column for column in self.columns if column.kind == "values"]
        ranked = [column for column in self.columns if column.kind == "order"]
        lacking = [column for column in self.columns if column.has_missing and column.kind != "empty"]
        found = []
        if empty := [column for column in self.columns if column.kind == "empty"]:
            found.append(f"no split reads {_listed(empty)}, without a value in any row")
        if sets := [column for column in self.columns if column.kind == "subsets"]:
            found.append(f"a split may ask for any set of the texts in {_listed(sets)}")
        if asked:
            questions = sum(len(column.features) for column in asked)
            found.append(f"text in {_listed(asked)} became {questions} yes/no question{'s' * (questions != 1)}")
        if ranked:
            found.append(f"text in {_listed(ranked)} became its rank in the order of its values")
        for form in dict.fromkeys(column.form for column in self.columns if column.form):
            found.append(f"{_listed([c for c in self.columns if c.form == form])} read as {words_of(form)}")
        if lacking:
            found.append(f"cells are missing in {_listed(lacking)}; a split sends them to whichever side is better")
        return tuple(found)

    def left_words(self, split: Split, number: Callable[[float], str] = exact) -> str:
        """Return what holds for the rows that a split sends left, such as "age <= 40.5 or missing"."""
        item = self.features[split.feature]
        return self.column_of(item).left_words(item, split, number)

    def column_of(self, feature: Feature) -> Column:
        """Return the column that a feature reads."""
        return next(column for column in self.columns if column.name == feature.column)

    def with_written_cuts(self, tree: Node, features: NDArray[np.float64]) -> Node:
        """Return the tree with every date and duration that it asks for in the fewest fields.

        Parameters
        ----------
        tree
            parts the rows of `features` (n_rows, n_features), which go the same ways in the tree that is returned.
        """

        def moved(node: Node, rows: NDArray[np.int64]) -> Node:
            if isinstance(node, Leaf):
                return node
            goes = goes_left(node, features, rows)
            node = replace(node, left=moved(node.left, rows[goes]), right=moved(node.right, rows[~goes]))
            if not isinstance(node, Split) or node.threshold is None:
                return node
            values = features[rows, node.feature]
            below, above = values[values <= node.threshold], values[values > node.threshold]
            if not len(below) or not len(above):
                return node
            cut = self.column_of(self.features[node.feature]).cut_between(float(below.max()), float(above.min()))
            return node if cut is None else replace(node, threshold=cut)

        return moved(tree, np.arange(len(features))) if any(column.form for column in self.columns) else tree

    def to_json(self) -> dict[str, Any]:
        """Return the columns as a JSON object."""
        return {"columns": [column.to_json() for column in self.columns]}

    @classmethod
    def from_json(cls, content: object) -> Self:
        """Return the columns of a JSON object.

        Raises
        ------
        DataError
            it is none.
        """
        out = cls(tuple(Column.from_json(entry) for entry in COLUMNS.take(content)["columns"]))
        out._check_names()
        return out


def _names_of(frame: pd.DataFrame) -> list[str]:
    return [str(name) for name in frame.columns]


def _series_of(frame: pd.DataFrame) -> list["pd.Series[Any]"]:
    return [frame.iloc[:, k] for k in range(frame.shape[1])]  # by place: a frame may call two columns alike


def _listed(columns: list[Column]) -> str:
    names = [shown(column.name) for column in columns]
    more = f" and {len(names) - 6} more" if len(names) > 6 else ""
    return f"{len(names)} column{'s' * (len(names) != 1)} ({', '.join(names[:6])}{more})"


def _refuse(cells: Cells, n_rows: int, categories: Categories, missing: Missing, most_unique: float) -> None:
    """Refuse a column that the user wants refused, or that would not help."""
    if cells.n_missing == n_rows:
        raise DataError(EMPTY)
    if cells.n_missing and missing == "refuse":
        raise DataError(f"has {_missing(cells)}; fill in, or set missing to 'either-side'")
    if cells.is_text and categories == "refuse":
        raise DataError(f"holds text such as {shown(_odd(cells))}; encode it as numbers, or set categories")
    if not cells.is_text or cells.is_ordered:
        return
    n_values = len(cells.values)
    if n_values > FEW_VALUES and n_values > most_unique * n_rows:
        if times := complaint_of(cells.values):
            raise DataError(times)
        n_numbers = sum(map(_is_number, cells.values))
        if 2 * n_numbers > n_values:
            raise DataError(
                f"holds {n_numbers} different numbers, and texts such as {shown(_odd(cells))}; "
                "write a number or an empty cell for each of these, or leave it out"
            )
        read = "" if not all(map(HAS_DIGIT, cells.values)) else ", or write numbers plainly if it holds some"
        raise DataError(f"holds {n_values} different texts in {n_rows} rows, as names of rows do; leave it out{read}")
    n_levels = n_values + (cells.n_missing > 0)
    if categories == "subsets" and n_levels > MOST_LEVELS:
        raise DataError(
            f"holds {n_levels} different texts; expected at most {MOST_LEVELS}, of which every set is tried; merge "
            "values, leave it out, or set categories to 'yes-no' or 'order'"
        )
    if categories == "subsets" and sum(map(len, cells.values)) > MOST_NAME // 2:
        raise DataError(
            f"holds texts of {sum(map(len, cells.values))} characters in all; expected at most {MOST_NAME // 2}, as "
            "sets are named by them; shorten them"
        )
    if n_values > MOST_VALUES and categories == "yes-no":
        raise DataError(
            f"holds {n_values} different texts; expected at most {MOST_VALUES} yes/no questions; leave it out, merge "
            "values, or set categories to 'order'"
        )


def _is_number(text: str) -> bool:
    return plain_number(text.strip()) is not None


def _odd(cells: Cells) -> str:
    """Return a text of a column that is no number, where it has one."""
    return min(cells.values, key=_is_number)


def _missing(cells: Cells) -> str:
    return f"{cells.n_missing} missing cell{'s' * (cells.n_missing != 1)}"


def _column_of(name: str, cells: Cells, categories: Categories, doubled: bool) -> Column:
    has_missing, stored = cells.n_missing > 0, cells.stored
    is_doubled = doubled and has_missing
    if cells.is_text:
        kind: Literal["order", "subsets", "values"] = "subsets" if categories == "subsets" else "values"
        kind = "order" if cells.is_ordered or categories == "order" else kind
        is_doubled = is_doubled and kind == "order"
        return Column(name, kind, has_missing, values=cells.values, is_doubled=is_doubled, stored=stored)
    least, most = float(np.nanmin(cells.numbers)), float(np.nanmax(cells.numbers))
    column = Column(
        name, "number", has_missing, least, most, is_doubled=is_doubled, form=cells.form, zone=cells.zone, stored=stored
    )
    if is_doubled:
        _ = column.beyond  # raises where float64 has no room
    return column


def _encoded(column: Column, cells: Cells, takes_missing: bool) -> NDArray[np.float64]:
    if cells.n_missing and not (column.has_missing or takes_missing):
        raise DataError(f"has {_missing(cells)}, and had none in training; fill in, or train with some")
    if column.kind == "number" and cells.is_text and cells.n_missing < len(cells.words):
        raise DataError(f"holds text such as {shown(_odd(cells))}; expected numbers, as in training")
    return column.encode(cells, takes_missing=takes_missing)

"""The rows of a table: every column checked before it becomes numbers or labels.

Numbers of a text are read to the last bit: one that is off in the last place would end on the other side of a
threshold. Nothing but an empty cell and NaN counts as missing in a label, so that a class may be called "NA".
"""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, SupportsFloat, cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.columns.written import form_of, is_time, read_texts, unit_of
from octmip.formats.table.delimited import read_delimited, rows_in, without_blanks
from octmip.formats.table.layout import layout_of
from octmip.formats.table.parquet import read_parquet
from octmip.formats.table.source import Source, open_source
from octmip.formats.table.units import factor_between
from octmip.input.cells import (
    BEYOND,
    EXACT_INTEGERS,
    beyond_exact,
    is_missing_word,
    plain_number,
    text_by_number,
    truths_in,
)
from octmip.input.files import PathLike
from octmip.input.messages import MOST_NAME, several, shown

OTHERWISE = {
    "feature": ", or leave the column out with --drop",
    "target": "; if its words are classes, name the column by --label instead of --target",
}
"""What to do with a column that holds no numbers, by its purpose."""
NO_CLASS = (bytes, list, dict, np.ndarray)
"""Types of cells of Parquet that are no class."""
UNLABELLED = "--drop-unlabelled leaves such rows out"


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """The rows of a source, and where they came from so that errors can say it.

    Attributes
    ----------
    source
        of the table.
    frame
        the rows; its index is their place in the source, from 0.
    notes
        sentences on how the source was read.
    units
        columns and the units that a row under the header gives them.
    """

    source: Source
    frame: pd.DataFrame
    notes: tuple[str, ...]
    units: tuple[tuple[str, str], ...]

    @property
    def name(self) -> str:
        """The table as a sentence names it."""
        return self.source.name

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(str(name) for name in self.frame.columns)

    def refuse_other_units(self, wanted: Mapping[str, str]) -> None:
        """Raise unless the units that the table gives its columns are the wanted ones, where both say one.

        Raises
        ------
        DataError
            a column is in another unit.
        """
        for name, unit in self.units:
            if name in wanted and factor_between(unit, wanted[name]) != 1.0:
                raise DataError(
                    f"{self.name}: column {shown(name)} is in {unit!r}; expected {wanted[name]!r}; convert the column, "
                    "or correct its unit"
                )

    def place(self, row: int, column: str) -> str:
        """Return where a cell stands in the file, for a sentence about it."""
        is_text = self.source.format != "parquet"
        return f"{self.name}, {'line' if is_text else 'row'} {self.numbers_of_rows()[row]}, column {shown(column)}"

    def numbers_of_rows(self) -> tuple[int, ...]:
        """Return the line of the text on which each row begins; in a file of columns its number, from 1."""
        places = self.frame.index.tolist()
        if self.source.format == "parquet":
            return tuple(row + 1 for row in places)
        text, _ = self.source.text()
        lines = [row.number for row in rows_in(layout_of(self.name, text, self.source.format))]
        return tuple(lines[row] for row in places)

    def rows(self, is_chosen: NDArray[np.bool_]) -> "Table":
        """Return the table of the rows that are chosen (n_rows,)."""
        return replace(self, frame=self.frame[is_chosen])

    def with_plain_numbers(self, name: str) -> "Table":
        """Return the table with a column as whole numbers or numbers where missing cells had made it something else."""
        column = self.frame[name]
        if column.dtype.kind == "O" and all(isinstance(cell, str) and _is_number(cell) for cell in column):
            column = pd.to_numeric(column)
        column = column.infer_objects()
        if column.dtype.kind == "f" and (column == np.floor(column)).all() and column.abs().max() <= EXACT_INTEGERS:
            column = column.astype(np.int64)
        return replace(self, frame=self.frame.assign(**{name: column}))

    def column(self, name: str, purpose: str) -> "pd.Series[Any]":
        """Return a column by name.

        Raises
        ------
        DataError
            there is none of that name.
        """
        if name not in self.columns:
            raise DataError(
                f"{self.name} has no column {shown(name)}; expected the {purpose} among its {len(self.columns)} "
                f"columns: {several(self.columns)}; spell it as the header does"
            )
        return self.frame[name]

    def missing(self, name: str, purpose: str) -> NDArray[np.bool_]:
        """Return which cells of a column are missing, shape (n_rows,): empty, NaN, or a word for it among numbers.

        Raises
        ------
        DataError
            there is no such column.
        """
        column = self.column(name, purpose)
        is_missing = column.isna().to_numpy()
        if column.dtype.kind in "biuf":
            return is_missing
        cells = column[~is_missing]
        if not all(isinstance(value, Hashable) for value in cells):  # lists and objects are no words
            return is_missing
        words = {value for value in set(cells) if not _is_number(value)} - set(truths_in(cells) or ())
        if len(words) < column.nunique() and all(is_missing_word(str(word)) for word in words):
            is_missing = is_missing | column.isin(words).to_numpy()
        return is_missing

    def numbers(self, columns: Sequence[str], purpose: str = "feature") -> NDArray[np.float64]:
        """Return columns as finite numbers, shape (n_rows, len(columns)), float64; texts as `written` reads them.

        Raises
        ------
        DataError
            a column is missing, or a cell of it is empty, text, not finite, or an integer beyond 2^53.
        """
        out = np.empty((len(self.frame), len(columns)))
        for j, name in enumerate(columns):
            out[:, j] = self._numbers_of(name, self.column(name, purpose), purpose)
        return out

    def _numbers_of(self, name: str, column: "pd.Series[Any]", purpose: str) -> NDArray[np.float64]:
        self._refuse_empty(name, column, purpose)
        form = self.form(name, purpose)
        if form:
            texts = sorted(set(column))
            number = dict(zip(texts, read_texts(texts, form).tolist(), strict=True))
            return column.map(number).to_numpy(dtype=np.float64)
        given = column
        if column.dtype.kind not in "biuf":
            read = [plain_number(cell) if isinstance(cell, str) else None for cell in column]
            if None in read or not np.isfinite(np.array(read, dtype=np.float64)).all():
                raise DataError(self._complaint(name, column, purpose))
            column = pd.Series(read, column.index, dtype=np.float64)
        numbers = column.to_numpy(dtype=np.float64)
        row = beyond_exact(given, numbers)
        if row is not None:
            raise DataError(self._beyond(name, row, given))
        if not np.isfinite(numbers).all():
            row = int(np.isfinite(numbers).argmin())
            raise DataError(f"{self.place(row, name)}: {numbers[row]} is not finite; expected a finite number")
        return numbers

    def form(self, name: str, purpose: str) -> str | None:
        """Return the form of a column (`octmip.formats.columns.written`), None where its cells have none in common.

        Times are a target alone: no weight and no cost is one. The units of a model's numbers are those of its card.

        Raises
        ------
        DataError
            there is no such column, or its cells fit two forms with two meanings.
        """
        column = self.column(name, purpose)
        if column.dtype.kind in "biufmM" or not all(isinstance(text, str) for text in column):
            return None
        try:
            form = form_of(sorted(set(column)))
        except DataError as error:
            raise DataError(f"{self.name}, column {shown(name)} {error}") from error
        if not form or (is_time(form) and purpose != "target") or (unit_of(form) and purpose == "model"):
            return None
        return form

    def _complaint(self, name: str, column: "pd.Series[Any]", purpose: str) -> str:
        """Return a sentence about the first cell of a column that pandas could not take for numbers."""
        words = (row for row, value in enumerate(column) if not _is_number(value))
        row = next(words, None)
        if row is None and column.map(lambda value: isinstance(value, int)).all():
            row = max(range(len(column)), key=lambda k: abs(column.iloc[k]))  # whole numbers of more than 64 bits
            return self._beyond(name, row, column)
        leave_out = OTHERWISE.get(purpose, "")
        return (
            f"{self.place(row or 0, name)}: {shown(column.iloc[row or 0])} is no number, and a {purpose} holds numbers "
            f"only; encode it as numbers{leave_out}"
        )

    def _beyond(self, name: str, row: int, column: "pd.Series[Any]") -> str:
        return f"{self.place(row, name)}: {shown(int(column.iloc[row]))} is {BEYOND}"

    def labels(self, column: str, known: Sequence[Any] | None = None, purpose: str = "label") -> NDArray[Any]:
        """Return the label of each row, shape (n_rows,): whole numbers, numbers, booleans or text.

        Raises
        ------
        DataError
            the column is missing, a label is empty or says so, or (with `known`) was not seen at training.
        """
        values = self.column(column, purpose)
        self._refuse_empty(column, values, purpose)
        labels = values.to_numpy()
        if labels.dtype.kind not in "biuf":
            odd = next((row for row, value in enumerate(values) if isinstance(value, NO_CLASS)), None)
            if odd is not None:
                got = f"{shown(str(labels[odd]))} of type {type(labels[odd]).__name__}"
                raise DataError(f"{self.place(odd, column)}: {got}; expected a {purpose}; write it as a text")
            labels = np.array([str(value) for value in values], dtype=object)
            self._refuse_words(column, labels)
        if known is not None:
            if labels.dtype.kind in "biuf" and all(isinstance(name, str) for name in known):
                text = text_by_number(known, are_truths=labels.dtype.kind == "b")
                labels = np.array([text.get(float(label), label) for label in labels.tolist()], dtype=object)
            is_known = set(known).__contains__
            unseen = [row for row, label in enumerate(labels.tolist()) if not is_known(label)]
            if unseen:
                raise DataError(
                    f"{self.place(unseen[0], column)}: label {shown(labels.tolist()[unseen[0]])} was not seen at "
                    f"training ({len(unseen)} such row{'s' * (len(unseen) != 1)}); the tree knows {several(known)}; "
                    "give the right column"
                )
        return labels

    def _refuse_words(self, name: str, labels: NDArray[Any]) -> None:
        """Refuse a word that no page can bear, and "NA" among numbers or truths; among words it is a class."""
        lengths = [len(label) for label in labels]
        if max(lengths) > MOST_NAME:
            row = lengths.index(max(lengths))
            raise DataError(
                f"{self.place(row, name)}: {shown(labels[row])} has {max(lengths)} characters; expected at most "
                f"{MOST_NAME}; name every class by a word"
            )
        said = truths_in(labels)
        words = {label for label in set(labels) if not _is_number(label)} - set(said or ())
        rows = [row for row, label in enumerate(labels) if label in words]
        if 0 < len(rows) < len(labels) and all(map(is_missing_word, words)):
            others = "numbers" if said is None else "true and false"
            raise DataError(
                f"{self.place(rows[0], name)}: {shown(labels[rows[0]])} among {others} "
                f"({len(rows)} such row{'s' * (len(rows) != 1)}); expected a label in every row; "
                f"{UNLABELLED}, or name every class by a word"
            )

    def _refuse_empty(self, name: str, column: "pd.Series[Any]", purpose: str) -> None:
        empty = column.isna().to_numpy()
        if empty.any():
            cure = UNLABELLED if purpose == "label" else "fill it or drop the row"
            raise DataError(
                f"{self.place(int(empty.argmax()), name)}: the {purpose} is empty or NaN ({int(empty.sum())} such "
                f"rows); {cure}"
            )


def _is_number(value: object) -> bool:
    """Whether a cell is a number, of any size; "nan" is none."""
    if isinstance(value, str):
        number = plain_number(value)
        return number is not None and not math.isnan(number)
    try:
        return "_" not in str(value) and not math.isnan(float(cast(SupportsFloat, value)))
    except OverflowError:  # a whole number beyond float64
        return True
    except (TypeError, ValueError):
        return False


def read_table(path: PathLike, as_text: str | None = None, *, keeps_names: bool = False) -> Table:
    """Return the table of a file, or of standard input for "-".

    .csv and .tsv (UTF-8 or latin-1, one header line, either may be compressed: .gz) and .parquet. The column `as_text`
    is read as text (007 is no 7), and stays where pandas says that it names the rows. With `keeps_names` names of rows
    without a name above them are the column "".

    Raises
    ------
    DataError
        the table cannot be read, is empty, has no rows, names a column twice, or rows of unequal length.
    """
    source = open_source(path)
    notes: tuple[str, ...] = ()
    units: tuple[tuple[str, str], ...] = ()
    if source.format == "parquet":
        frame, notes = read_parquet(source, as_text, keeps_names)
        frame, padded = without_blanks(frame)  # a database fills texts of one width up
        notes += padded
    else:
        frame, layout, notes = read_delimited(source, as_text, keeps_names)
        units = tuple((name, unit) for name, unit in zip(layout.header, layout.units, strict=False) if name and unit)
    if frame.empty:
        raise DataError(
            f"{source.name} has {len(frame.columns)} columns and {len(frame)} rows; expected at least one row"
        )
    return Table(source, frame, notes, units)

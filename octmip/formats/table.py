"""Tables of samples from CSV and Parquet files: every column checked before it becomes numbers or labels.

Numbers of a CSV file are read to the last bit: one that is off in the last place would end on the other side of a
threshold. Nothing but an empty cell and NaN counts as missing, so that a class may be called "NA".
"""

import contextlib
import csv
import importlib
import io
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, SupportsFloat, cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError, needed_by
from octmip.formats.cells import CsvRows, plain_number
from octmip.formats.checked import MOST_NAME, several, shown
from octmip.formats.files import PathLike, check_readable, read_text

MISSING_WORDS = {"na", "n/a", "nan", "none", "null", "nil", "?", "-", "missing"}
EXACT_INTEGERS = 2**53  # beyond it float64 merges neighbouring integers
MOST_CELLS = 2**28  # of a Parquet file: two gigabytes as float64
# From 3.1 on pandas reads numbers exactly by default and warns of the option; before, its default may be off.
IS_EXACT = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
EXACT_NUMBERS: dict[str, Any] = {} if IS_EXACT else {"float_precision": "round_trip"}


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """The rows of a file, and where they came from so that errors can say it."""

    path: Path
    frame: pd.DataFrame

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(str(name) for name in self.frame.columns)

    def place(self, row: int, column: str) -> str:
        """Return where a cell stands in the file, for a sentence about it."""
        line = _line_of_row(self.path, row) if self.path.suffix == ".csv" else None
        return f"{self.path}, {f'line {line}' if line else f'row {row + 1}'}, column {shown(column)}"

    def column(self, name: str, purpose: str) -> "pd.Series[Any]":
        """Return a column by name.

        Raises
        ------
        DataError
            there is none of that name.
        """
        if name not in self.columns:
            is_otherwise_separated = len(self.columns) == 1 and bool({";", "\t"} & set(self.columns[0]))
            cure = "separate columns by commas" if is_otherwise_separated else "spell it as the header does"
            raise DataError(
                f"{self.path} has no column {shown(name)}; expected the {purpose} among its {len(self.columns)} "
                f"columns {several(self.columns)}; {cure}"
            )
        return self.frame[name]

    def numbers(self, columns: Sequence[str], purpose: str = "feature") -> NDArray[np.float64]:
        """Return columns as finite numbers, shape (n_rows, len(columns)), float64.

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
        if column.dtype.kind not in "biuf":
            raise DataError(self._complaint(name, column, purpose))
        if column.dtype.kind in "iu":
            is_beyond = ((column > EXACT_INTEGERS) | (column < -EXACT_INTEGERS)).to_numpy()
            if is_beyond.any():
                raise DataError(self._beyond(name, int(is_beyond.argmax()), column))
        numbers = column.to_numpy(dtype=np.float64)
        if not np.isfinite(numbers).all():
            row = int(np.isfinite(numbers).argmin())
            raise DataError(f"{self.place(row, name)}: {numbers[row]} is not finite; expected a finite number")
        return numbers

    def _complaint(self, name: str, column: "pd.Series[Any]", purpose: str) -> str:
        """Return a sentence about the first cell of a column that pandas could not take for numbers."""
        words = (row for row, value in enumerate(column) if not _is_number(value))
        row = next(words, None)
        if row is None and column.map(lambda value: isinstance(value, int)).all():
            row = max(range(len(column)), key=lambda k: abs(column.iloc[k]))  # whole numbers of more than 64 bits
            return self._beyond(name, row, column)
        leave_out = ", or leave the column out with --features" if purpose == "feature" else ""
        return (
            f"{self.place(row or 0, name)}: {shown(column.iloc[row or 0])} is no number, and a {purpose} holds numbers "
            f"only; encode it as numbers{leave_out}"
        )

    def _beyond(self, name: str, row: int, column: "pd.Series[Any]") -> str:
        return (
            f"{self.place(row, name)}: {shown(int(column.iloc[row]))} is beyond 2^53, where float64 merges "
            "neighbouring integers; subtract an offset first"
        )

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
            labels = np.array([str(value) for value in values], dtype=object)
            self._refuse_words(column, labels)
        if known is not None:
            is_known = set(known).__contains__
            unseen = [row for row, label in enumerate(labels.tolist()) if not is_known(label)]
            if unseen:
                raise DataError(
                    f"{self.place(unseen[0], column)}: label {shown(labels.tolist()[unseen[0]])} was not seen at "
                    f"training ({len(unseen)} such rows); the tree knows {several(known)}; give the right column"
                )
        return labels

    def _refuse_words(self, name: str, labels: NDArray[Any]) -> None:
        """Refuse a word that no page can bear, and "NA" among numbers; among words it is a class like any other."""
        lengths = [len(label) for label in labels]
        if max(lengths) > MOST_NAME:
            row = lengths.index(max(lengths))
            raise DataError(
                f"{self.place(row, name)}: {shown(labels[row])} has {max(lengths)} characters; expected at most "
                f"{MOST_NAME}; name every class by a word"
            )
        words = {label for label in set(labels) if not _is_number(label)}
        rows = [row for row, label in enumerate(labels) if label in words]
        if 0 < len(rows) < len(labels) and {word.lower() for word in words} <= MISSING_WORDS:
            raise DataError(
                f"{self.place(rows[0], name)}: {shown(labels[rows[0]])} among numbers ({len(rows)} such rows); drop "
                "the row, or name every class by a word"
            )

    def _refuse_empty(self, name: str, column: "pd.Series[Any]", purpose: str) -> None:
        empty = column.isna().to_numpy()
        if empty.any():
            raise DataError(
                f"{self.place(int(empty.argmax()), name)}: the {purpose} is empty or NaN ({int(empty.sum())} such "
                "rows); fill it or drop the row"
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


def read_table(path: PathLike) -> Table:
    """Return the table of a CSV (.csv, UTF-8, commas, one header line) or Parquet (.parquet) file.

    Raises
    ------
    DataError
        the file cannot be read, is empty, has no rows, names a column twice, or rows of unequal length.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".parquet"):
        raise DataError(f"{path} is neither .csv nor .parquet; expected a table in one of these")
    frame = _read_parquet(path) if path.suffix == ".parquet" else _read_csv(path)
    if frame.empty:
        raise DataError(f"{path} has {len(frame.columns)} columns and {len(frame)} rows; expected at least one row")
    return Table(path, frame)


def _read_csv(path: Path) -> pd.DataFrame:
    text = read_text(path)
    rows = _rows(text)
    try:
        header, first = next(rows, []), next((cells for cells in rows if cells), [])
    except csv.Error as error:
        raise DataError(f"{path}, line {rows.last}: {error}; expected cells separated by commas") from error
    _check_names(path, header)
    if "" in (name.strip() for name in header):
        place = [name.strip() for name in header].index("") + 1
        raise DataError(f"{path}, line 1: column {place} has no name; name it, or drop it if it only counts the rows")
    if len(first) > len(header):  # pandas would take the first column for an index
        raise DataError(f"{path}, line 2: {len(first)} cells but the header has {len(header)}; name every column")
    try:
        frame: pd.DataFrame = pd.read_csv(
            io.StringIO(text),
            **EXACT_NUMBERS,
            keep_default_na=False,
            na_values=["", "nan", "NaN"],
            low_memory=False,
        )
    except (ValueError, OverflowError) as error:  # pandas' own ParserError and EmptyDataError among them
        reason = str(error).strip().removeprefix("Error tokenizing data. C error: ")
        raise DataError(f"{path} is no table: {reason}; give every line as many cells as the header has") from error
    if list(frame.columns) != header:
        raise DataError(f"{path}, line 1: the header can be read in two ways; expected plain names; rename the columns")
    return frame


def _read_parquet(path: Path) -> pd.DataFrame:
    check_readable(path)
    with needed_by(f"{path}, a Parquet file,"):
        arrow, parquet = importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    try:
        with parquet.ParquetFile(path) as file:
            names = file.schema_arrow.names
            _check_names(path, names)
            _check_size(path, file.metadata.num_rows, len(names))
            index = _index_columns(file.schema_arrow.pandas_metadata)
            # The metadata's other promises are not asked for: they hold types of Python that a column would become.
            frame: pd.DataFrame = file.read().to_pandas(ignore_metadata=True)
    except DataError:
        raise
    except (arrow.ArrowException, ValueError, TypeError, LookupError, OSError, ArithmeticError, MemoryError) as error:
        reason = " ".join(str(error).split())[:300]
        raise DataError(f"{path} is no Parquet file that can be read ({reason}); was it written to the end?") from error
    return frame.drop(columns=[name for name in names if name in index])


def _index_columns(metadata: object) -> set[str]:
    """Return the columns in which pandas keeps the names of the rows: no column of the table."""
    found = metadata.get("index_columns") if isinstance(metadata, dict) else None
    return {name for name in found if isinstance(name, str)} if isinstance(found, list) else set()


def _check_size(path: Path, n_rows: int, n_columns: int) -> None:
    """Refuse a promise of more cells than memory has: Parquet stores a million equal cells in a few bytes."""
    if n_rows * n_columns > MOST_CELLS:
        raise DataError(
            f"{path} holds {n_rows} rows of {n_columns} columns; expected at most {MOST_CELLS} cells; drop columns"
        )


def _check_names(path: Path, header: Sequence[str]) -> None:
    """Refuse a name that stands twice, or that no page can bear."""
    twice, times = Counter(header).most_common(1)[0] if header else ("", 0)
    if times > 1:
        raise DataError(f"{path} has the column {shown(twice)} {times} times; give each its own name")
    longest = max(header, key=len, default="")
    if len(longest) > MOST_NAME:
        raise DataError(
            f"{path} has a column whose name has {len(longest)} characters ({shown(longest)}); expected at most "
            f"{MOST_NAME}; rename it"
        )


def _line_of_row(path: Path, row: int) -> int | None:
    """Return the line of a CSV file (1: header) on which a row ends: blank lines hold no row, quoted cells may span."""
    rows = _rows(read_text(path))
    rows_before = -1  # the header
    with contextlib.suppress(csv.Error):  # a cell that pandas takes and csv does not: the row is named by its number
        for cells in rows:
            if cells:
                if rows_before == row:
                    return rows.last
                rows_before += 1
    return None


def _rows(text: str) -> CsvRows:
    return CsvRows(enumerate(io.StringIO(text, newline=""), start=1))


def read_costs(path: PathLike, class_names: Sequence[Any]) -> NDArray[np.float64]:
    """Return the cost matrix of a CSV file, rows and columns in the order of `class_names`.

    The header names the predicted classes and the first column the true ones, in any order:

        true,healthy,damaged
        healthy,0,1
        damaged,10,0

    Raises
    ------
    DataError
        a class is missing, unknown or named twice, or a cost is no number.
    """
    table = read_table(path)
    first = table.columns[0]
    rows = [str(value) for value in table.labels(first)]
    wanted = [str(name) for name in class_names]
    for what, got in (("rows", rows), ("columns", list(table.columns[1:]))):
        if sorted(got) != sorted(wanted):
            raise DataError(f"{path} has {what} {several(got)}; expected each of the classes {several(wanted)} once")
    return table.numbers(wanted, "cost")[[rows.index(name) for name in wanted]]


@dataclass(frozen=True, slots=True)
class Sensors:
    """The sensor that each feature is read from, and the cost of each sensor."""

    of_feature: tuple[str, ...]
    cost: Mapping[str, float]


def read_sensors(path: PathLike, feature_names: Sequence[str]) -> Sensors:
    """Return the sensors of a CSV file: columns `sensor,cost`, or `feature,sensor,cost` where sensors give several.

    Without a column `feature` every feature is its own sensor. Rows of columns that are not used are skipped.

    Raises
    ------
    DataError
        a column or feature is missing or named twice, or one sensor has two costs.
    """
    table = read_table(path)
    column = "feature" if "feature" in table.columns else "sensor"
    names = [str(value) for value in table.labels(column, purpose=f"{column} name")]
    sensors = [str(value) for value in table.labels("sensor", purpose="sensor name")]
    costs = table.numbers(["cost"], "sensor cost")[:, 0].tolist()
    times = Counter(names)
    missing = [name for name in feature_names if times[name] != 1]
    if missing:
        raise DataError(
            f"{path} names the feature {shown(missing[0])} {times[missing[0]]} times; expected one row for each "
            "feature used"
        )
    found: dict[str, float] = {}
    of_feature = []
    for name in feature_names:
        sensor, cost = sensors[names.index(name)], costs[names.index(name)]
        if found.setdefault(sensor, cost) != cost:
            raise DataError(f"{path} gives sensor {shown(sensor)} two costs, {found[sensor]} and {cost}; expected one")
        of_feature.append(sensor)
    return Sensors(tuple(of_feature), MappingProxyType(found))

"""Tables of samples from CSV and Parquet files: every column checked before it becomes numbers or labels.

Numbers of a CSV file are read to the last bit: one that is off in the last place would end on the other side of a
threshold. Nothing but an empty cell and NaN counts as missing, so that a class may be called "NA".
"""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.files import PathLike, read_bytes, read_text

MISSING_WORDS = {"na", "n/a", "nan", "none", "null", "nil", "?", "-", "missing"}
EXACT_INTEGERS = 2**53  # beyond it float64 merges neighbouring integers
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
        return f"{self.path}, {f'line {line}' if line else f'row {row + 1}'}, column {column!r}"

    def column(self, name: str, purpose: str) -> "pd.Series[Any]":
        """Return a column by name.

        Raises:
            DataError: there is none of that name.
        """
        if name not in self.columns:
            shown = ", ".join(repr(column) for column in self.columns[:12]) + (
                ", ..." if len(self.columns) > 12 else ""
            )
            is_otherwise_separated = len(self.columns) == 1 and (";" in shown or "\\t" in shown)
            cure = "separate columns by commas" if is_otherwise_separated else "spell it as the header does"
            raise DataError(
                f"{self.path} has no column {name!r}; expected the {purpose} among its {len(self.columns)} columns "
                f"({shown}); {cure}"
            )
        return self.frame[name]

    def numbers(self, columns: Sequence[str], purpose: str = "feature") -> NDArray[np.float64]:
        """Return columns as finite numbers, shape (n_rows, len(columns)), float64.

        Raises:
            DataError: a column is missing, or a cell of it is empty, text, not finite, or an integer beyond 2^53.
        """
        out = np.empty((len(self.frame), len(columns)))
        for j, name in enumerate(columns):
            out[:, j] = self._numbers_of(name, self.column(name, purpose), purpose)
        return out

    def _numbers_of(self, name: str, column: "pd.Series[Any]", purpose: str) -> NDArray[np.float64]:
        self._refuse_empty(name, column, purpose)
        if column.dtype.kind not in "biuf":
            numbers = pd.to_numeric(column, errors="coerce").to_numpy(dtype=np.float64)
            row = int(np.isnan(numbers).argmax())
            leave_out = ", or leave the column out with --features" if purpose == "feature" else ""
            raise DataError(
                f"{self.place(row, name)}: {str(column.iloc[row])!r} is no number, and a {purpose} holds numbers only; "
                f"encode it as numbers{leave_out}"
            )
        if column.dtype.kind in "iu" and (column.abs() > EXACT_INTEGERS).any():
            row = int((column.abs() > EXACT_INTEGERS).to_numpy().argmax())
            raise DataError(
                f"{self.place(row, name)}: {column.iloc[row]} is beyond 2^53, where float64 no longer tells integers "
                "apart; subtract an offset first"
            )
        numbers = column.to_numpy(dtype=np.float64)
        if not np.isfinite(numbers).all():
            row = int(np.isfinite(numbers).argmin())
            raise DataError(f"{self.place(row, name)}: {numbers[row]} is not finite; expected a finite number")
        return numbers

    def labels(self, column: str, known: Sequence[Any] | None = None, purpose: str = "label") -> NDArray[Any]:
        """Return the label of each row, shape (n_rows,): whole numbers, numbers, booleans or text.

        Raises:
            DataError: the column is missing, a label is empty or says so, or (with `known`) was not seen at training.
        """
        values = self.column(column, purpose)
        self._refuse_empty(column, values, purpose)
        labels = values.to_numpy()
        if labels.dtype.kind not in "biuf":
            labels = np.array([str(value) for value in values], dtype=object)
            self._refuse_missing_among_numbers(column, labels)
        if known is not None:
            unseen = [row for row, label in enumerate(labels.tolist()) if label not in set(known)]
            if unseen:
                raise DataError(
                    f"{self.place(unseen[0], column)}: label {labels[unseen[0]]!r} was not seen at training "
                    f"({len(unseen)} such rows); the tree knows {list(known)}"
                )
        return labels

    def _refuse_missing_among_numbers(self, name: str, labels: NDArray[Any]) -> None:
        """Refuse "NA" in a column of numbers; in a column of words it is a class like any other."""
        is_text = pd.to_numeric(pd.Series(labels), errors="coerce").isna().to_numpy()
        if 0 < is_text.sum() < len(labels) and {str(label).lower() for label in labels[is_text]} <= MISSING_WORDS:
            row = int(is_text.argmax())
            raise DataError(
                f"{self.place(row, name)}: {labels[row]!r} among numbers ({int(is_text.sum())} such rows); drop the "
                "row, or name every class by a word"
            )

    def _refuse_empty(self, name: str, column: "pd.Series[Any]", purpose: str) -> None:
        empty = column.isna().to_numpy()
        if empty.any():
            raise DataError(
                f"{self.place(int(empty.argmax()), name)}: the {purpose} is empty or NaN ({int(empty.sum())} such "
                "rows); fill it or drop the row"
            )


def read_table(path: PathLike) -> Table:
    """Return the table of a CSV (.csv, UTF-8, commas, one header line) or Parquet (.parquet) file.

    Raises:
        DataError: the file cannot be read, is empty, has no rows, names a column twice, or rows of unequal length.
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
    reader = csv.reader(io.StringIO(text, newline=""))
    try:
        header, first = next(reader, []), next((cells for cells in reader if cells), [])
    except csv.Error as error:
        raise DataError(f"{path}, line {reader.line_num}: {error}; expected cells separated by commas") from error
    _refuse_twice(path, header)
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
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        reason = str(error).strip().removeprefix("Error tokenizing data. C error: ")
        raise DataError(f"{path} is no table: {reason}; give every line as many cells as the header has") from error
    return frame


def _read_parquet(path: Path) -> pd.DataFrame:
    read_bytes(path)  # its sentence about missing, unreadable and empty files
    try:
        frame = pd.read_parquet(path)
    except ImportError as error:
        raise DataError(f"{path} needs the package pyarrow to be read; install octmip[parquet]") from error
    except (ValueError, OSError) as error:
        reason = " ".join(str(error).split())
        raise DataError(f"{path} is no Parquet file that can be read ({reason}); was it written to the end?") from error
    _refuse_twice(path, [str(name) for name in frame.columns])
    return frame


def _refuse_twice(path: Path, header: Sequence[str]) -> None:
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise DataError(f"{path} has the column {twice[0]!r} {header.count(twice[0])} times; give each its own name")


def _line_of_row(path: Path, row: int) -> int | None:
    """Return the line of a CSV file (1: header) on which a row ends: blank lines hold no row, quoted cells may span."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file)
        rows_before = -1  # the header
        for cells in reader:
            if cells:
                if rows_before == row:
                    return reader.line_num
                rows_before += 1
    return None


def read_costs(path: PathLike, class_names: Sequence[Any]) -> NDArray[np.float64]:
    """Return the cost matrix of a CSV file, rows and columns in the order of `class_names`.

    The header names the predicted classes and the first column the true ones, in any order:

        true,healthy,damaged
        healthy,0,1
        damaged,10,0

    Raises:
        DataError: a class is missing, unknown or named twice, or a cost is no number.
    """
    table = read_table(path)
    first = table.columns[0]
    rows = [str(value) for value in table.labels(first)]
    wanted = [str(name) for name in class_names]
    for what, got in (("rows", rows), ("columns", list(table.columns[1:]))):
        if sorted(got) != sorted(wanted):
            raise DataError(f"{path} has {what} {got}; expected each of the classes {wanted} once")
    return table.numbers(wanted, "cost")[[rows.index(name) for name in wanted]]


@dataclass(frozen=True, slots=True)
class Sensors:
    """Which sensor each feature is read from, and what each sensor costs."""

    of_feature: tuple[str, ...]
    cost: dict[str, float]


def read_sensors(path: PathLike, feature_names: Sequence[str]) -> Sensors:
    """Return the sensors of a CSV file: columns `sensor,cost`, or `feature,sensor,cost` where sensors give several.

    Without a column `feature` every feature is its own sensor. Rows of columns that are not used are skipped.

    Raises:
        DataError: a column or feature is missing or named twice, or one sensor has two costs.
    """
    table = read_table(path)
    column = "feature" if "feature" in table.columns else "sensor"
    names = [str(value) for value in table.labels(column, purpose=f"{column} name")]
    sensors = [str(value) for value in table.labels("sensor", purpose="sensor name")]
    costs = table.numbers(["cost"], "sensor cost")[:, 0].tolist()
    missing = [name for name in feature_names if names.count(name) != 1]
    if missing:
        times = names.count(missing[0])
        raise DataError(
            f"{path} names the feature {missing[0]!r} {times} times; expected one row for each feature used"
        )
    found: dict[str, float] = {}
    of_feature = []
    for name in feature_names:
        sensor, cost = sensors[names.index(name)], costs[names.index(name)]
        if found.setdefault(sensor, cost) != cost:
            raise DataError(f"{path} gives sensor {sensor!r} two costs, {found[sensor]} and {cost}; expected one")
        of_feature.append(sensor)
    return Sensors(tuple(of_feature), found)

"""Historical readings, appended to simulated ones: a campaign's table, read in pieces.

A table has one row per reading: `load_factor`, a column for each damage parameter [fraction of stiffness lost], and one
for each gauge [microstrain at that load, compressive positive]. Other columns are left alone.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from femlib.checked import shown
from femlib.dataset.parquet import parquet_file
from femlib.dataset.storage import csv_pieces, floats
from femlib.errors import InputError

ROWS_AT_A_TIME = 8192


def history_pieces(
    source: str | Path | pd.DataFrame, name: str, parameters: Sequence[str], gauges: Sequence[str]
) -> Iterator[pd.DataFrame]:
    """Yield a table's columns load_factor, parameters and gauges as floats, some thousand rows at a time.

    Parameters
    ----------
    source : str, Path or DataFrame
        A .csv or .parquet file, or a table in memory.
    name : str
        What errors call it.
    parameters, gauges : sequence of str
        Columns to read.

    Raises
    ------
    InputError
        If a file cannot be read, a column is missing, a cell is empty or no number, or a loss is outside [0, 1).
    """
    columns = ["load_factor", *parameters, *gauges]
    first = 0
    for piece in _pieces(source, name, columns):
        missing = [column for column in columns if column not in piece.columns]
        if missing:
            raise InputError(f"{name} lacks the columns {missing}; expected load_factor, every parameter and gauge")
        yield _checked(piece[columns], first, name, parameters)
        first += len(piece)


def _pieces(source: str | Path | pd.DataFrame, name: str, columns: list[str]) -> Iterator[pd.DataFrame]:
    if isinstance(source, pd.DataFrame):
        yield from (source.iloc[k : k + ROWS_AT_A_TIME] for k in range(0, max(len(source), 1), ROWS_AT_A_TIME))
        return
    try:
        yield from _pieces_of_file(Path(source), columns)
    except InputError as error:
        raise InputError(f"{name}: {error}") from error


def _pieces_of_file(path: Path, columns: list[str]) -> Iterator[pd.DataFrame]:
    if path.suffix == ".parquet":
        with parquet_file(path) as file:
            kept = [column for column in columns if column in file.schema_arrow.names]
            batches = file.iter_batches(ROWS_AT_A_TIME, columns=kept)
            yield from (batch.to_pandas(ignore_metadata=True) for batch in batches)
    else:
        yield from csv_pieces(path, ROWS_AT_A_TIME)


def _checked(piece: pd.DataFrame, first: int, name: str, parameters: Sequence[str]) -> pd.DataFrame:
    numbers = pd.DataFrame({column: floats(piece[column]) for column in piece.columns})
    bad = ~np.isfinite(numbers.to_numpy())
    damage = numbers[list(parameters)].to_numpy()
    bad[:, 1 : 1 + len(parameters)] |= ~((damage >= 0.0) & (damage < 1.0))
    if bad.any():
        row, column = (int(k) for k in np.argwhere(bad)[0])
        raise InputError(
            f"{name} row {first + row} has {piece.columns[column]} = {_cell(piece, row, column)}; expected a finite "
            "load factor and strains, and losses of stiffness from 0 to below 1; complete or drop the row"
        )
    return numbers


def _cell(piece: pd.DataFrame, row: int, column: int) -> str:
    value = piece.iloc[row, column]
    return shown(value if isinstance(value, str) else str(value))

"""Historical readings, appended to simulated ones: a campaign's table, read in pieces.

A table has one row a reading: `load_factor`, a column for each damage parameter [fraction of stiffness lost], and one
for each gauge [microstrain at that load, compressive positive]. Other columns are left alone.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from femlib.dataset.disk import arrow
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
        if Path(source).suffix == ".parquet":
            _, parquet = arrow()
            with parquet.ParquetFile(source) as file:
                kept = [column for column in columns if column in file.schema_arrow.names]
                yield from (batch.to_pandas() for batch in file.iter_batches(ROWS_AT_A_TIME, columns=kept))
        else:
            with pd.read_csv(source, chunksize=ROWS_AT_A_TIME) as reader:
                yield from reader
    except (OSError, pd.errors.ParserError, ValueError) as error:
        raise InputError(
            f"{name} cannot be read ({error}); expected a .csv or .parquet table of readings; correct the path"
        ) from error


def _checked(piece: pd.DataFrame, first: int, name: str, parameters: Sequence[str]) -> pd.DataFrame:
    columns = {name: pd.to_numeric(piece[name], errors="coerce") for name in piece.columns}
    numbers = pd.DataFrame(columns).astype(np.float64)
    bad = ~np.isfinite(numbers.to_numpy())
    damage = numbers[list(parameters)].to_numpy()
    bad[:, 1 : 1 + len(parameters)] |= ~((damage >= 0.0) & (damage < 1.0))
    if bad.any():
        row, column = (int(k) for k in np.argwhere(bad)[0])
        raise InputError(
            f"{name} row {first + row} has {piece.columns[column]} = {piece.iloc[row, column]!r}; expected a finite "
            "load factor and strains, and losses of stiffness from 0 to below 1; complete or drop the row"
        )
    return numbers

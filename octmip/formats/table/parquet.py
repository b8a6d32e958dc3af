"""Parquet: a table read by pyarrow, without the types of Python that its metadata may promise."""

import importlib
import io

import pandas as pd

from octmip.errors import DataError, needed_by
from octmip.formats.table.names import check_names
from octmip.formats.table.source import Source
from octmip.input.cells import may_be_beyond
from octmip.input.files import check_readable
from octmip.input.messages import several

MOST_CELLS = 2**28  # two gigabytes as float64


def read_parquet(source: Source, named: str | None, keeps_names: bool = False) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return the table of a Parquet file, and a note on columns that are left out: those of the index of pandas.

    The column `named`, where there is one, stays.

    With `keeps_names` they are columns, called "" where they have no name of their own.

    Raises
    ------
    DataError
        pyarrow is not installed, or the file is damaged, too large or names a column twice.
    """
    is_plain = source.held is None and source.path.suffix != ".gz"
    if is_plain:
        check_readable(source.path)
    with needed_by(f"{source.name}, a Parquet file,"):
        arrow, parquet = importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    try:
        with parquet.ParquetFile(source.path if is_plain else io.BytesIO(source.content())) as file:
            names = file.schema_arrow.names
            check_names(source.name, names)
            _check_size(source.name, file.metadata.num_rows, len(names))
            index = _index_columns(file.schema_arrow.pandas_metadata)
            # The metadata's other promises are not asked for: they hold types of Python that a column would become.
            table = file.read()
            frame: pd.DataFrame = table.to_pandas(ignore_metadata=True)
            for k, name in enumerate(names):
                is_float = frame[name].dtype.kind == "f"  # for the sake of missing cells
                if is_float and arrow.types.is_integer(table.schema.types[k]) and may_be_beyond(frame[name]):
                    frame[name] = table.column(k).to_pandas(integer_object_nulls=True)
    except DataError:
        raise
    except (arrow.ArrowException, ValueError, TypeError, LookupError, OSError, ArithmeticError, MemoryError) as error:
        reason = " ".join(str(error).split())[:300]
        raise DataError(
            f"{source.name} is no Parquet file that can be read ({reason}); was it written to the end?"
        ) from error
    if keeps_names:
        return frame.rename(columns={"__index_level_0__": ""}), ()
    left_out = [name for name in names if name in index and name != named]
    own = [name for name in left_out if not name.startswith("__index_level_")]
    told = f"{several(own)} of {source.name} names the rows, as pandas says in it, and is left out"
    return frame.drop(columns=left_out), (told,) * bool(own)


def _index_columns(metadata: object) -> set[str]:
    """Return the columns in which pandas keeps the names of the rows: no column of the table."""
    found = metadata.get("index_columns") if isinstance(metadata, dict) else None
    return {name for name in found if isinstance(name, str)} if isinstance(found, list) else set()


def _check_size(source: str, n_rows: int, n_columns: int) -> None:
    """Refuse a promise of more cells than memory has: Parquet stores a million equal cells in a few bytes."""
    if n_rows * n_columns > MOST_CELLS:
        raise DataError(
            f"{source} holds {n_rows} rows of {n_columns} columns; expected at most {MOST_CELLS} cells; drop columns"
        )

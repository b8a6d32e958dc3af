"""Parquet files through pyarrow, an optional extra: opened to be read, and written a group of rows at a time."""

import importlib
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd

from femlib.checked import shown
from femlib.errors import InputError, needed_by
from femlib.files import regular_file

GROUP_ROWS = 65_536
"""Rows of a row group: the most that is held in memory while writing."""


def pyarrow_modules() -> tuple[Any, Any]:
    """Return the modules pyarrow and pyarrow.parquet, imported only where a Parquet file is asked for.

    Raises
    ------
    MissingExtraError
        If they are not installed.
    """
    with needed_by("a Parquet file"):
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")


@contextmanager
def parquet_file(path: Path) -> Iterator[Any]:
    """Open a Parquet file; whatever goes wrong until it is closed is an `InputError` of one sentence.

    Raises
    ------
    InputError
        If it is missing, no regular file, or not to be read.
    """
    pa, parquet = pyarrow_modules()
    failures = (pa.ArrowException, ValueError, TypeError, LookupError, OSError, ArithmeticError, MemoryError)
    with regular_file(path, "a Parquet file") as file:
        try:
            with parquet.ParquetFile(file) as found:
                twice, times = Counter(found.schema_arrow.names).most_common(1)[0]
                if times > 1:
                    raise InputError(f"{path} has the column {shown(twice)} {times} times; give each its own name")
                yield found
        except InputError:
            raise
        except failures as error:
            reason = " ".join(str(error).split())[:300]
            raise InputError(f"{path} cannot be read ({reason}); expected a Parquet file; write it again") from error


def write_groups(path: Path, tables: Iterator[pd.DataFrame], schema: Any) -> int:
    """Write tables one after the other in groups of `GROUP_ROWS` and return the number of their rows."""
    pa, parquet = pyarrow_modules()
    n_rows = n_held = 0
    held: list[Any] = []
    with parquet.ParquetWriter(path, schema) as writer:
        for table in tables:
            held.append(pa.Table.from_pandas(table, schema, preserve_index=False))
            n_held += len(table)
            while n_held >= GROUP_ROWS:
                joined = pa.concat_tables(held).unify_dictionaries()
                writer.write_table(joined.slice(0, GROUP_ROWS).combine_chunks(), row_group_size=GROUP_ROWS)
                held, n_held, n_rows = [joined.slice(GROUP_ROWS)], n_held - GROUP_ROWS, n_rows + GROUP_ROWS
        if n_held:
            writer.write_table(pa.concat_tables(held).unify_dictionaries().combine_chunks(), row_group_size=GROUP_ROWS)
    return n_rows + n_held

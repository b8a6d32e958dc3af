"""A streamed dataset on disk: Parquet rows beside a JSON side file, written and read in pieces."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from femlib.checked import names, taken, whole
from femlib.dataset.disk import arrow, checked_target, file_sha256, parquet_file, read_side, side_path
from femlib.errors import InputError, is_whole
from femlib.files import whole_file
from femlib.kept import ReadOnly

VERSION = "stream 1"
GROUP_ROWS = 65_536
"""Rows of a row group: what is held in memory while writing."""


@dataclass(frozen=True, slots=True, eq=False)
class StoredDataset:
    """A streamed dataset that was checked against its side file.

    Attributes
    ----------
    path : Path
        The Parquet file.
    n_rows : int
        Its rows.
    parameters, gauges : tuple of str
        Names of the columns of damage [fraction of stiffness lost] and of readings [microstrain].
    about : mapping
        The side file: seed, noise, model hash, units, states, loads.
    """

    path: Path
    n_rows: int
    parameters: tuple[str, ...]
    gauges: tuple[str, ...]
    about: Mapping[str, Any]

    def pieces(self, n_rows: int = GROUP_ROWS, columns: Sequence[str] | None = None) -> Iterator[pd.DataFrame]:
        """Yield the rows, at most `n_rows` at a time, all columns or those named.

        Raises
        ------
        InputError
            If a column is not in the file or `n_rows` is no whole number above 0.
        """
        if not is_whole(n_rows) or n_rows < 1:
            raise InputError(f"n_rows is {n_rows!r}; expected 1 or more rows at a time; correct it")
        with parquet_file(self.path) as file:
            unknown = [name for name in columns or () if name not in file.schema_arrow.names]
            if unknown:
                raise InputError(f"{self.path} has no columns {unknown}; expected among {file.schema_arrow.names}")
            for batch in file.iter_batches(n_rows, columns=None if columns is None else list(columns)):
                yield batch.to_pandas(ignore_metadata=True)

    def read(self, columns: Sequence[str] | None = None) -> pd.DataFrame:
        """Return all rows at once: for datasets that fit into memory.

        Raises
        ------
        InputError
            As `pieces`.
        """
        pieces = list(self.pieces(columns=columns))
        if not pieces:
            raise InputError(f"{self.path} has no rows; expected at least one; write the dataset again")
        return pd.concat(pieces, ignore_index=True)


def open_dataset(path: str | Path) -> StoredDataset:
    """Return a dataset that `stream_dataset` wrote.

    Raises
    ------
    InputError
        If a file is missing or broken, or the data file is not the one that its side file describes.
    """
    target = checked_target(path, (".parquet",))
    side, where = read_side(target, VERSION), str(side_path(target))
    n_rows = whole(taken(side, "rows", where), f"{where}: rows")
    parameters, gauges = (names(taken(side, name, where), f"{where}: {name}") for name in ("parameters", "gauges"))
    with parquet_file(target) as file:
        held, columns = file.metadata.num_rows, set(file.schema_arrow.names)
    missing = [name for name in (*parameters, *gauges) if name not in columns]
    if held != n_rows or missing:
        raise InputError(
            f"{target} has {held} rows and lacks the columns {missing[:12]}; expected {n_rows} rows of all columns "
            "that its side file names; write the dataset again"
        )
    return StoredDataset(target, n_rows, parameters, gauges, ReadOnly(side))


def store(path: str | Path, tables: Iterator[pd.DataFrame], side: dict[str, Any]) -> StoredDataset:
    """Write tables one after the other into one Parquet file, then its side file; both whole or not at all.

    Parameters
    ----------
    path : str or Path
        The Parquet file.
    tables : iterator of DataFrame
        Rows; they are asked for only once the path has proved writable.
    side : dict
        Content of the side file; names of parameters and gauges, from which the columns follow, are in it.

    Raises
    ------
    InputError
        If the path cannot be written to.
    """
    target = checked_target(path, (".parquet",))
    with whole_file(target) as rows_file, whole_file(side_path(target)) as side_file:
        n_rows = _write_groups(rows_file, tables, side["parameters"], side["gauges"])
        whole = {"version": VERSION, "data": target.name, "sha256": file_sha256(rows_file), "rows": n_rows} | side
        side_file.write_text(json.dumps(whole, indent=1) + "\n", encoding="utf-8")
    return open_dataset(target)


def _schema(pa: Any, parameters: Sequence[str], gauges: Sequence[str]) -> Any:
    words = pa.dictionary(pa.int32(), pa.string())
    fields = [("state", pa.int64()), *((name, pa.float64()) for name in parameters), ("load", words)]
    fields += [("load_factor", pa.float64()), ("is_train", pa.bool_()), ("source", words)]
    return pa.schema([*fields, *((name, pa.float64()) for name in gauges)])


def _write_groups(path: Path, tables: Iterator[pd.DataFrame], parameters: Sequence[str], gauges: Sequence[str]) -> int:
    """Write the rows in groups of `GROUP_ROWS` and return their number."""
    pa, parquet = arrow()
    schema = _schema(pa, parameters, gauges)
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

"""Paths of datasets, and the JSON side file that says what a data file is."""

import hashlib
import importlib
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray
from femlib.checked import shown, taken
from femlib.errors import InputError
from femlib.files import parsed_object, read_bytes, regular_file


def arrow() -> tuple[Any, Any]:
    """Return the modules pyarrow and pyarrow.parquet, an optional extra: asked for where Parquet is.

    Raises
    ------
    InputError
        If they are not installed.
    """
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise InputError("Parquet files need pyarrow, which is not installed; pip install 'octmip[parquet]'") from error


PIECE = 2**16
"""Bytes of a file that are read at once."""


@contextmanager
def parquet_file(path: Path) -> Iterator[Any]:
    """Open a Parquet file; what goes wrong until it is closed is one sentence.

    Raises
    ------
    InputError
        If it is missing, no regular file, or not to be read.
    """
    pa, parquet = arrow()
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


def csv_pieces(path: Path, n_rows: int, kind: type | None = None) -> Iterator[pd.DataFrame]:
    """Yield a CSV table, at most `n_rows` at a time, every cell as `kind` or as what it looks like.

    Raises
    ------
    InputError
        If it is missing, no regular file, not UTF-8, or no table.
    """
    with regular_file(path, "a CSV table") as file:
        try:
            with pd.read_csv(file, chunksize=n_rows, dtype=kind, low_memory=False) as reader:
                yield from reader
        except (ValueError, LookupError, OSError, OverflowError, MemoryError) as error:  # pandas' own among them
            reason = " ".join(str(error).split())[:300]
            raise InputError(f"{path} cannot be read ({reason}); expected a CSV table; repair the file") from error


def floats(column: "pd.Series[Any]") -> FloatArray:
    """Return a column as numbers (n,), NaN where a cell is none."""
    if column.dtype.kind in "biuf":
        return np.asarray(column.to_numpy(dtype=np.float64, na_value=np.nan))
    return np.array([_float(value) for value in column], dtype=np.float64)


def _float(value: Any) -> float:
    words = str(value)
    if not words.isascii() or "_" in words:  # Python takes 1_000, and digits of any script
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def checked_target(path: str | Path, endings: Sequence[str]) -> Path:
    """Return a path with one of the endings that is no folder.

    Raises
    ------
    InputError
        If the ending is another, the path is a folder, or it is Parquet and pyarrow is not installed.
    """
    target = Path(path)
    if target.suffix not in endings:
        raise InputError(f"dataset path {target} ends in {target.suffix!r}; expected {' or '.join(endings)}; rename it")
    if target.suffix == ".parquet":
        arrow()
    if target.is_dir():
        raise InputError(f"dataset path {target} is a folder; expected a file; add a name to it")
    return target


def side_path(target: Path) -> Path:
    """Return the path of a data file's side file."""
    return target.with_name(target.name + ".json")


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file, read piece by piece.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    with regular_file(path, "a dataset") as file:
        digest = hashlib.sha256()
        while piece := file.read(PIECE):
            digest.update(piece)
        return digest.hexdigest()


def read_side(target: Path, version: int | str) -> dict[str, Any]:
    """Return the side file of a data file, after checking that it is the one that it describes.

    Parameters
    ----------
    target : Path
        The data file.
    version : int or str
        What its entry `version` must be.

    Raises
    ------
    InputError
        If a file is missing or broken, or the data file has changed.
    """
    path = side_path(target)
    if not path.exists():
        raise InputError(f"{path} does not exist; expected the side file of {target.name}; write the dataset again")
    side = parsed_object(read_bytes(path, "a side file"), str(path), "a dataset's side file; write the dataset again")
    if side.get("version") != version:
        raise InputError(f"{path} is not a side file of version {version}; write the dataset again")
    if file_sha256(target) != taken(side, "sha256", str(path)):
        raise InputError(f"{target} is not the file its side file describes (another sha256); write the dataset again")
    return side

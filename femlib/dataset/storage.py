"""Datasets in files: CSV or Parquet beside a JSON side file, both written whole or not at all.

The side file has what the rows lack (seed, noise, model hash, units, mean strains) and the SHA-256 of the data file,
so that a data file that was changed or cut off is refused.
"""

import hashlib
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray, IntArray
from femlib.checked import names, number, rows, shown, taken, text, whole
from femlib.dataset.parquet import parquet_file, pyarrow_modules
from femlib.dataset.samples import Dataset, Recipe
from femlib.errors import InputError, frozen_ints
from femlib.files import parsed_object, read_bytes, regular_file, whole_file

PIECE_BYTES = 2**16
"""Bytes of a file that are hashed at once."""
VERSION = 1
LEAST_LOAD = 1e-9
ROWS_AT_A_TIME = 65_536
MOST_CELLS = 2**28
"""Numbers read at once, two gigabytes: Parquet promises a million equal cells in a few bytes."""
UNITS = {
    "features": "microstrain, compressive positive, divided by load_factor",
    "mu1_percent": "percent loss of stiffness",
    "mu2_percent": "percent loss of stiffness",
    "noise_variance": "microstrain^2 at load_factor, before the division",
}
_WRITERS: dict[str, Callable[[pd.DataFrame, Path], None]] = {
    ".csv": lambda table, path: table.to_csv(path, index=False, lineterminator="\n"),
    ".parquet": lambda table, path: table.to_parquet(path, index=False),
}


def write_dataset(data: Dataset, path: str | Path) -> None:
    """Write rows to `path` (.csv or .parquet) and the rest to the side file, named `path` with .json added.

    Columns: mu1_percent, mu2_percent, is_train (0 or 1), then one for each gauge.

    Raises
    ------
    InputError
        If the ending is another, or the folder cannot be written to.
    """
    target = checked_target(path, tuple(_WRITERS))
    table = pd.DataFrame(data.features, columns=list(data.gauges))
    table.insert(0, "mu1_percent", data.mu1)
    table.insert(1, "mu2_percent", data.mu2)
    table.insert(2, "is_train", data.is_train.astype(np.int64))

    def write(rows_file: Path) -> dict[str, Any]:
        _WRITERS[target.suffix](table, rows_file)
        return _side(data, target) | {"sha256": file_sha256(rows_file)}

    write_with_side(target, write)


def read_dataset(path: str | Path) -> Dataset:
    """Read a dataset that `write_dataset` wrote.

    Raises
    ------
    InputError
        If a file is missing or unreadable, or the data file is not the one that the side file describes.
    """
    target = checked_target(path, tuple(_WRITERS))
    side, where = read_side(target, VERSION), str(side_path(target))
    gauges = names(taken(side, "gauges", where), f"{where}: gauges")
    percent = frozen_ints(rows(taken(side, "states_percent", where), f"{where}: states_percent", 2), where, (-1, 2))
    means = rows(taken(side, "mean_features", where), f"{where}: mean_features", len(gauges))
    if len(means) != len(percent):
        raise InputError(
            f"{where} has {len(percent)} states_percent and {len(means)} mean_features; expected one each; write the "
            "dataset again"
        )
    table = _numbers(target, ("mu1_percent", "mu2_percent", "is_train", *gauges))
    return Dataset(
        table[:, 3:],
        _state_numbers(table[:, :2], percent, target),
        percent,
        means,
        gauges,
        table[:, 2] == 1.0,
        number(taken(side, "load_factor", where), f"{where}: load_factor", LEAST_LOAD, 1.0 / LEAST_LOAD),
        _recipe(taken(side, "recipe", where), f"{where}: recipe"),
        whole(taken(side, "seed", where), f"{where}: seed"),
        text(taken(side, "source", where), f"{where}: source"),
        text(taken(side, "model_hash", where), f"{where}: model_hash"),
    )


def _recipe(content: object, where: str) -> Recipe:
    return Recipe(
        whole(taken(content, "samples_per_state", where), f"{where}.samples_per_state", 1),
        number(taken(content, "noise_variance", where), f"{where}.noise_variance", 0.0),
        number(taken(content, "train_fraction", where), f"{where}.train_fraction", 0.0, 1.0),
    )


def _numbers(target: Path, columns: Sequence[str]) -> FloatArray:
    """Return columns of a data file as finite numbers (n, n_columns)."""
    if target.suffix == ".parquet":
        with parquet_file(target) as file:
            n_cells = file.metadata.num_rows * len(columns)
            if n_cells > MOST_CELLS:
                raise InputError(f"{target} holds {n_cells} cells; expected {MOST_CELLS} at most; split the dataset")
            kept = [column for column in columns if column in file.schema_arrow.names]
            table = file.read(columns=kept).to_pandas(ignore_metadata=True)
    else:  # as text, because the default parser may round the last bit; Python's conversion is exact
        table = pd.concat(list(csv_pieces(target, ROWS_AT_A_TIME, str)), ignore_index=True)
    missing = [column for column in columns if column not in table.columns]
    if missing:
        raise InputError(f"{target} lacks the columns {missing[:12]}; expected those of its side file; write it again")
    found = np.stack([floats(table[column]) for column in columns], axis=1)
    if not np.isfinite(found).all():
        row, column = (int(k) for k in np.argwhere(~np.isfinite(found))[0])
        got = shown(str(table[columns[column]].iloc[row]))
        raise InputError(f"{target} row {row} has {columns[column]} = {got}; expected finite numbers; write it again")
    return found


def _state_numbers(labels: FloatArray, percent: IntArray, target: Path) -> IntArray:
    """Return the number (n,) of each row's state among the states of the side file."""
    known = {tuple(state): k for k, state in enumerate(percent.tolist())}
    found = [known.get(tuple(state), -1) for state in labels.tolist()]
    if -1 in found:
        row = found.index(-1)
        raise InputError(
            f"{target} row {row} has the state {labels[row].tolist()}; expected one of the {len(known)} of its side "
            "file; write the dataset again"
        )
    return np.array(found, dtype=np.int64)


def _side(data: Dataset, target: Path) -> dict[str, Any]:
    return {
        "version": VERSION,
        "data": target.name,
        "rows": len(data.features),
        "seed": data.seed,
        "recipe": asdict(data.recipe),
        "noise_sd": data.noise_sd,
        "load_factor": data.load_factor,
        "source": data.source,
        "model_hash": data.model_hash,
        "units": UNITS,
        "gauges": list(data.gauges),
        "states_percent": data.states_percent.tolist(),
        "mean_features": data.mean_features.tolist(),
    }


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
        pyarrow_modules()
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
        while piece := file.read(PIECE_BYTES):
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
        raise InputError(f"{path} is no side file of version {version}; write the dataset again")
    if file_sha256(target) != taken(side, "sha256", str(path)):
        raise InputError(f"{target} is not the file its side file describes (another sha256); write the dataset again")
    return side


def write_with_side(target: Path, write: Callable[[Path], dict[str, Any]]) -> None:
    """Write a data file and its side file, both whole or not at all.

    Parameters
    ----------
    target : Path
        The data file.
    write : callable
        Fills the file whose path it is given with the rows, and returns the content of the side file.

    Raises
    ------
    InputError
        If the path cannot be written to.
    """
    with whole_file(target) as rows_file, whole_file(side_path(target)) as side_file:
        side = write(rows_file)
        side_file.write_text(json.dumps(side, indent=1) + "\n", encoding="utf-8")

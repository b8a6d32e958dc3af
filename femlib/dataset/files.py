"""Datasets on disk: CSV or Parquet beside a JSON side file, each written whole or not at all.

The side file has what the rows lack (seed, noise, model hash, units, mean strains) and the SHA-256 of the data file,
so that a data file that was changed or cut off is refused.
"""

import hashlib
import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from femlib.dataset.samples import Dataset, Recipe
from femlib.errors import InputError

VERSION = 1
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
_READERS: dict[str, Callable[[Path], pd.DataFrame]] = {
    # as text, because the default parser may round the last bit; numpy's conversion is exact
    ".csv": lambda path: pd.read_csv(path, dtype=str),
    ".parquet": pd.read_parquet,
}


def write_dataset(data: Dataset, path: str | Path) -> None:
    """Write rows to `path` (.csv or .parquet) and the rest to the side file, named `path` with .json added.

    Columns: mu1_percent, mu2_percent, is_train (0 or 1), then one for each gauge.

    Raises
    ------
    InputError
        If the ending is another, or the folder cannot be written to.
    """
    target = _checked_path(path)
    table = pd.DataFrame(data.features, columns=list(data.gauges))
    table.insert(0, "mu1_percent", data.mu1)
    table.insert(1, "mu2_percent", data.mu2)
    table.insert(2, "is_train", data.is_train.astype(np.int64))
    _write_whole(target, lambda temporary: _WRITERS[target.suffix](table, temporary))
    side = json.dumps(_side(data, target), indent=1) + "\n"
    _write_whole(_side_path(target), lambda temporary: temporary.write_text(side, encoding="utf-8"))


def read_dataset(path: str | Path) -> Dataset:
    """Read a dataset that `write_dataset` wrote.

    Raises
    ------
    InputError
        If a file is missing or unreadable, or the data file is not the one that the side file describes.
    """
    target = _checked_path(path)
    side = _read_side(target)
    if _sha256(target) != side["sha256"]:
        raise InputError(f"{target} is not the file its side file describes (another sha256); write the dataset again")
    table = _READERS[target.suffix](target)
    states_percent = np.array(side["states_percent"], dtype=np.int64)
    number = {tuple(row): k for k, row in enumerate(states_percent.tolist())}
    labels = table[["mu1_percent", "mu2_percent"]].to_numpy(dtype=np.int64)
    return Dataset(
        table[side["gauges"]].to_numpy(dtype=np.float64),
        np.array([number[tuple(row)] for row in labels.tolist()], dtype=np.int64),
        states_percent,
        np.array(side["mean_features"], dtype=np.float64),
        tuple(side["gauges"]),
        table["is_train"].to_numpy(dtype=np.int64) == 1,
        side["load_factor"],
        Recipe(**side["recipe"]),
        side["seed"],
        side["source"],
        side["model_hash"],
    )


def _side(data: Dataset, target: Path) -> dict[str, Any]:
    return {
        "version": VERSION,
        "data": target.name,
        "sha256": _sha256(target),
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


def _read_side(target: Path) -> dict[str, Any]:
    path = _side_path(target)
    try:
        side = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(
            f"{path} does not exist; expected the side file of {target.name}; write the dataset again"
        ) from error
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path} is not JSON ({error}); expected a dataset's side file; write the dataset again"
        ) from error
    if not isinstance(side, dict) or side.get("version") != VERSION:
        raise InputError(f"{path} is not a side file of version {VERSION}; write the dataset again")
    return side


def _side_path(target: Path) -> Path:
    return target.with_name(target.name + ".json")


def _checked_path(path: str | Path) -> Path:
    target = Path(path)
    if target.suffix not in _WRITERS:
        raise InputError(f"dataset path {target} ends in {target.suffix!r}; expected .csv or .parquet; rename it")
    return target


def _sha256(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}); expected a dataset; correct the path") from error


def _write_whole(target: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file beside `target`, then rename it: the target is whole or absent."""
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=target.suffix)
    except OSError as error:
        raise InputError(
            f"{target} cannot be written ({error.strerror}); expected a writable folder; create it"
        ) from error
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)

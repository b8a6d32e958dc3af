"""Datasets on disk: CSV or Parquet beside a JSON side file, each written whole or not at all.

The side file has what the rows lack (seed, noise, model hash, units, mean strains) and the SHA-256 of the data file,
so that a data file that was changed or cut off is refused.
"""

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from femlib.dataset.disk import checked_target, file_sha256, read_side, side_path
from femlib.dataset.samples import Dataset, Recipe
from femlib.files import whole_file

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
    target = checked_target(path, tuple(_WRITERS))
    table = pd.DataFrame(data.features, columns=list(data.gauges))
    table.insert(0, "mu1_percent", data.mu1)
    table.insert(1, "mu2_percent", data.mu2)
    table.insert(2, "is_train", data.is_train.astype(np.int64))
    with whole_file(target) as rows_file, whole_file(side_path(target)) as side_file:
        _WRITERS[target.suffix](table, rows_file)
        side = _side(data, target) | {"sha256": file_sha256(rows_file)}
        side_file.write_text(json.dumps(side, indent=1) + "\n", encoding="utf-8")


def read_dataset(path: str | Path) -> Dataset:
    """Read a dataset that `write_dataset` wrote.

    Raises
    ------
    InputError
        If a file is missing or unreadable, or the data file is not the one that the side file describes.
    """
    target = checked_target(path, tuple(_WRITERS))
    side = read_side(target, VERSION)
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

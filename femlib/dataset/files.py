"""Datasets on disk: CSV or Parquet beside a JSON side file, each written whole or not at all.

The side file has what the rows lack (seed, noise, model hash, units, mean strains) and the SHA-256 of the data file,
so that a data file that was changed or cut off is refused.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray, IntArray
from femlib.checked import names, number, rows, shown, taken, text, whole
from femlib.dataset.disk import (
    checked_target,
    csv_pieces,
    file_sha256,
    floats,
    parquet_file,
    read_side,
    side_path,
)
from femlib.dataset.samples import Dataset, Recipe
from femlib.errors import InputError, frozen_ints
from femlib.files import whole_file

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

"""The reader of twins' files, a table with its card, as the fuzz of files tries them."""

import contextlib
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.readers.file_reader import Reader
from benchmarks.readers.mangled_arrays import mangled_parquet
from benchmarks.readers.mangling import Generator, mangled_csv, mangled_json
from octmip.errors import OctmipError
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.doors.opening import table_twin

CARD = {
    "readings": {"strain": "microstrain", "tip": "mm"},
    "loads": ["load_factor"],
    "states": ["mu1"],
    "parameters": {"stiffness": [1.0, 0.8, 1.2, "1"]},
}


def make_table_twin(suffix: str) -> Callable[[int, Path], None]:
    """Return what writes a regular grid of readings and its card."""

    def make(number: int, folder: Path) -> None:
        rng = np.random.default_rng([95, number])
        grid = [(s, m, load) for s in (0.8, 1.0, 1.2) for m in (0.0, 0.5) for load in (1.0, 2.0)]
        frame = pd.DataFrame(grid, columns=["stiffness", "mu1", "load_factor"])
        frame = frame.assign(strain=rng.normal(size=len(grid)).round(3), tip=rng.normal(size=len(grid)).round(3))
        path = folder / f"twin{suffix}"
        frame.to_csv(path, index=False) if suffix == ".csv" else frame.to_parquet(path)
        (folder / f"{path.name}.json").write_text(json.dumps(CARD))

    return make


def read_table_twin(suffix: str) -> Callable[[Generator, Path], None]:
    """Return what opens a table as a twin and asks it inside and outside its rows."""

    def read(rng: Generator, folder: Path) -> None:
        _ask(table_twin(folder / f"twin{suffix}"))

    return read


def _ask(twin: FunctionTwin) -> None:
    for state in ({}, {"mu1": 0.5}, {"mu1": 1e300}):
        for load in (1.0, -1e308):
            with contextlib.suppress(OctmipError):
                assert np.isfinite(twin.predict(state, load)).all()


TWINS = {
    "twin, table .csv": Reader(make_table_twin(".csv"), "twin.csv", mangled_csv, read_table_twin(".csv")),
    "twin, table .parquet": Reader(
        make_table_twin(".parquet"), "twin.parquet", mangled_parquet, read_table_twin(".parquet")
    ),
    "twin, card": Reader(make_table_twin(".csv"), "twin.csv.json", mangled_json, read_table_twin(".csv")),
}

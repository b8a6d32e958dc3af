"""MAT files of versions 5 and 7.3 by pymatreader: series beside a vector of times in the same structure.

A structure has times where it holds a vector "time" or "t", or a sampling rate "fs", or lies in one that has such a
vector, as Simulink saves it. Every vector of that length is a channel, and so is every column or row of a matrix.
"""

import functools
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError, needed_by
from octmip.input.messages import several
from octmip.recordings.readers.clock import TIMES, doubts, seconds_in, times_among
from octmip.recordings.recording import Channel, Floats, Recording

with needed_by("a recording of MAT"):
    from pymatreader import read_mat

RATES = ("fs", "samplerate", "sample_rate")


def read(path: Path) -> Recording:
    """Return the series of a file as STRUCTURE/NAME; columns and rows are counted from 1 as NAME/1."""
    found = dict(_channels(read_mat(str(path)), ""))
    if not found:
        raise DataError(
            f"{path}: no structure holds series beside their times; expected a vector called {several(TIMES, 3)}, or "
            f"a rate {RATES[0]!r}, among them; save it with them"
        )
    loaders = {name: functools.partial(Channel, name, "", *pair) for name, pair in found.items()}
    return Recording("MAT", loaders, notes=doubts(time for time, _ in found.values()))


def _channels(
    structure: Mapping[str, Any], before: str, outer: Floats | None = None
) -> Iterator[tuple[str, tuple[Floats, Any]]]:
    """Yield the series of a structure with their times; `outer` are those of the structure in which it lies."""
    parts = (
        (f"{key}/{k + 1}", one) for key, own in structure.items() if isinstance(own, list) for k, one in enumerate(own)
    )
    arrays = {
        key: np.squeeze(own) for key, own in (*structure.items(), *parts) if isinstance(own, np.ndarray) and own.size
    }
    arrays = {key: array for key, array in arrays.items() if array.dtype.kind in "biuf" and array.ndim in (1, 2)}
    lower = {key.lower(): key for key in structure}
    named = times_among(dict.fromkeys(arrays, ""))
    rates = (structure[lower[name]] for name in RATES if name in lower)
    rate = next((float(own) for own in rates if isinstance(own, int | float | np.integer | np.floating)), 0.0)
    clock = seconds_in(named, "", arrays.pop(named)) if named else None if rate else outer
    for key, array in arrays.items():
        time = clock if clock is not None else np.arange(max(array.shape)) / rate if rate else None
        if time is None or time.ndim != 1 or len(time) not in array.shape:
            continue
        if array.ndim == 1:
            yield f"{before}{key}", (time, array)
        else:
            columns = array if len(array) == len(time) else array.T
            yield from ((f"{before}{key}/{k + 1}", (time, column)) for k, column in enumerate(columns.T))
    for key, value in structure.items():
        if isinstance(value, Mapping):
            yield from _channels(value, f"{before}{key}/", clock)

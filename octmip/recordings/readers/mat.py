"""MAT files of versions 5 and 7.3 by pymatreader: series beside a vector of times in the same structure.

A structure has times where it holds a vector "time" or "t", or a sampling rate "fs". Every vector of that length, and
every column of a matrix with so many rows, is a channel.
"""

import functools
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError, needed_by
from octmip.gap.campaign.columns import doubt_of
from octmip.input.messages import several
from octmip.recordings.recording import Channel, Floats, Recording

with needed_by("a recording of MAT"):
    from pymatreader import read_mat

TIMES, RATES = ("time", "t", "timestamp"), ("fs", "samplerate", "sample_rate")


def read(path: Path) -> Recording:
    """Return the series of a file as STRUCTURE/NAME; columns are counted from 1 as NAME/1."""
    found = dict(_channels(read_mat(str(path)), ""))
    if not found:
        raise DataError(
            f"{path}: no structure holds series beside their times; expected a vector called {several(TIMES)}, or a "
            f"rate {RATES[0]!r}, among them; save it with them"
        )
    doubts = {doubt for time, _ in found.values() if (doubt := doubt_of(time))}
    told = tuple(f"Times are read as seconds; they may count {doubt}: save them in seconds." for doubt in doubts)
    loaders = {name: functools.partial(Channel, name, "", *pair) for name, pair in found.items()}
    return Recording("MAT", loaders, notes=told)


def _channels(structure: Mapping[str, Any], before: str) -> Iterator[tuple[str, tuple[Floats, Any]]]:
    arrays = {key: np.squeeze(value) for key, value in structure.items() if isinstance(value, np.ndarray)}
    lower = {key.lower() if len(key) > 1 else key: key for key in structure}  # T is a temperature
    named = next((lower[name] for name in TIMES if name in lower and lower[name] in arrays), None)
    rates = (structure[lower[name]] for name in RATES if name in lower)
    rate = next((float(own) for own in rates if isinstance(own, int | float | np.integer | np.floating)), 0.0)
    for key, array in arrays.items():
        if key == named or array.dtype.kind not in "biuf" or not array.size:
            continue
        time = arrays[named] if named else np.arange(len(np.atleast_1d(array))) / rate if rate else None
        if time is None or time.ndim != 1 or array.ndim not in (1, 2) or len(array) != len(time):
            continue
        if array.ndim == 1:
            yield f"{before}{key}", (time, array)
        else:
            yield from ((f"{before}{key}/{k + 1}", (time, array[:, k])) for k in range(array.shape[1]))
    for key, value in structure.items():
        if isinstance(value, Mapping):
            yield from _channels(value, f"{before}{key}/")

"""UFF58 by pyuff: functions of time, each with an abscissa of its own, which a text writes with six digits."""

import functools
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import needed_by
from octmip.formats.table.units import factor_between
from octmip.recordings.readers.clock import seconds_in
from octmip.recordings.recording import Channel, Floats, Recording, told_apart

with needed_by("a recording of UFF58"):
    import pyuff

TIME_RESPONSE, GENERAL, TIME = (0, 1), (0, 1), 17
"""Types of functions, and of abscissas, that may be series of time; an abscissa of no known kind counts where the
function is a time response."""
EVEN, HEAD_LINES = 1, 13
WIDTHS = {(2, 0): (78, (13, 13)), (2, 1): (78, (13,)), (4, 0): (66, (13, 20)), (4, 1): (80, (20,))}
"""Of a line and of a pair of time and number, or of a number, by the types of the ordinate and of the spacing."""


def read(path: Path) -> Recording:
    """Return the time responses of a file by their first line of text, or by node and direction."""
    file = pyuff.UFF(str(path))
    sets = [(k, file.read_sets(k, header_only=True)) for k, kind in enumerate(file.get_set_types()) if kind == 58]
    series = [(k, one) for k, one in sets if _is_of_time(one)]
    names = [_text(one, "id1") or f"node {one['rsp_node']} direction {one['rsp_dir']}" for _, one in series]
    labels = told_apart(names, [f"{name}#{k + 1}" for name, (k, _) in zip(names, series, strict=True)])
    many = "1 function that is" if len(sets) == len(series) + 1 else f"{len(sets) - len(series)} functions that are"
    notes = (f"Left out: {many} no time response.",) * (len(sets) > len(series))

    def loaded(label: str, k: int, one: dict[str, Any]) -> Channel:
        found = None if one["binary"] else _columns(path, file, k, one)
        if found is None:
            whole = file.read_sets(k)
            found = whole["x"], whole["data"]
        times, values = found
        if one["abscissa_spacing"] == EVEN:  # its step has more digits than their sum
            times = one["abscissa_min"] + one["abscissa_inc"] * np.arange(len(values))
        unit = _text(one, "abscissa_axis_units_lab")
        times = seconds_in("of the abscissa", unit if factor_between(unit, "s") is not None else "s", times)
        return Channel(label, _text(one, "ordinate_axis_units_lab"), times, values)

    loaders = {label: functools.partial(loaded, label, *pair) for label, pair in zip(labels, series, strict=True)}
    return Recording("UFF58", loaders, notes=notes)


def _columns(path: Path, file: Any, k: int, one: dict[str, Any]) -> tuple[Floats, Floats] | None:
    """Return times and real numbers of a text whose lines are all full; None of another, which pyuff reads."""
    size, widths = WIDTHS.get((one["ord_data_type"], one["abscissa_spacing"]), (0, (1,)))
    first, last = file._block_ind[k]
    with path.open("rb") as stream:
        stream.seek(first)
        lines = stream.read(last - first + 1).splitlines()[HEAD_LINES:]
    text = b"".join(lines)
    if any(len(line) != size for line in lines[:-1]) or len(text) % sum(widths):
        return None
    cells = np.frombuffer(text, dtype=[(str(k), f"S{width}") for k, width in enumerate(widths)])
    try:
        found = [cells[name].astype(np.float64) for name in cells.dtype.names or ()]
    except ValueError:
        return None
    return found[0], found[-1]


def _is_of_time(one: dict[str, Any]) -> bool:
    kind, axis = one["func_type"], one["abscissa_spec_data_type"]
    return kind in TIME_RESPONSE and (axis == TIME or (axis in GENERAL and kind == 1))


def _text(one: dict[str, Any], key: str) -> str:
    text = str(one.get(key, "")).strip()
    return "" if text == "NONE" else text

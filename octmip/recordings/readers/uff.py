"""UFF58 by pyuff: functions of time, each with an abscissa of its own, which a text writes with six digits."""

import functools
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import needed_by
from octmip.recordings.recording import Channel, Floats, Recording

with needed_by("a recording of UFF58"):
    import pyuff

TIME_RESPONSE, GENERAL, TIME = (0, 1), (0, 1), 17
"""Types of functions, and of abscissas, that may be series of time; an abscissa of no known kind counts where the
function is a time response."""
EVEN = 1


def read(path: Path) -> Recording:
    """Return the time responses of a file by their first line of text, or by node and direction."""
    file = pyuff.UFF(str(path))
    sets = [file.read_sets(k) for k, kind in enumerate(file.get_set_types()) if kind == 58]
    series = [one for one in sets if _is_of_time(one)]
    names = [_text(one, "id1") or f"node {one['rsp_node']} direction {one['rsp_dir']}" for one in series]
    labels = [name if names.count(name) == 1 else f"{name}#{k + 1}" for k, name in enumerate(names)]
    left_out = len(sets) - len(series)
    others = (
        "1 function that is no time response is"
        if left_out == 1
        else f"{left_out} functions that are no time responses are"
    )
    notes = (f"{others} left out.",) if left_out else ()
    loaders = {
        label: functools.partial(Channel, label, _text(one, "ordinate_axis_units_lab"), _time(one), one["data"])
        for label, one in zip(labels, series, strict=True)
    }
    return Recording("UFF58", loaders, notes=notes)


def _is_of_time(one: dict[str, Any]) -> bool:
    kind, axis = one["func_type"], one["abscissa_spec_data_type"]
    return kind in TIME_RESPONSE and (axis == TIME or (axis in GENERAL and kind == 1))


def _text(one: dict[str, Any], key: str) -> str:
    text = str(one.get(key, "")).strip()
    return "" if text == "NONE" else text


def _time(one: dict[str, Any]) -> Floats:
    """Return the times: of even spacing from its step, which has more digits than their sum."""
    even = one["abscissa_spacing"] == EVEN
    time = one["abscissa_min"] + one["abscissa_inc"] * np.arange(len(one["data"])) if even else one["x"]
    return np.asarray(time, dtype=np.float64)

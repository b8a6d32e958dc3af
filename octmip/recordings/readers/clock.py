"""Which series of a file holds the times of the others, and how many seconds its numbers are."""

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from octmip.errors import DataError
from octmip.formats.table.units import factor_between, unit_behind
from octmip.gap.campaign.columns import OWN, TIME, doubt_of
from octmip.input.messages import shown
from octmip.recordings.recording import Floats

TIMES = (*OWN[TIME], "timestamps", "x_value", "t")
"""How files call times, in any case, with a unit behind or none."""


def times_among(units: Mapping[str, str]) -> str | None:
    """Return the first of some names, with their units, that is one of times; None where none is."""
    return next((name for name, unit in units.items() if _is_time(name, unit)), None)


def _is_time(name: str, unit: str) -> bool:
    own, behind = unit_behind(name)
    own, unit = own.strip(), unit or behind
    if len(own) == 1:  # T is a temperature, and so is t in degC
        return own in TIMES and (not unit or factor_between(unit, "s") is not None)
    return own.lower() in TIMES


def seconds_in(name: str, unit: str, times: ArrayLike) -> Floats:
    """Return times (n,) in a unit, that behind their name where it is "", as seconds.

    Raises
    ------
    DataError
        they are no numbers, or the unit is none of time.
    """
    numbers, unit = np.asarray(times), unit or unit_behind(name)[1]
    factor = factor_between(unit, "s") if unit else 1.0
    if numbers.dtype.kind not in "iuf" or factor is None:
        what = "are no numbers" if factor is not None else f"are in {shown(unit)}"
        raise DataError(f"times {shown(name)} {what}; expected seconds, or numbers in a unit such as ms; convert them")
    return np.asarray(numbers * factor, dtype=np.float64)


def doubts(clocks: Iterable[Floats]) -> tuple[str, ...]:
    """Return a sentence for each unit in which times (n,) without one may count instead of seconds."""
    found = dict.fromkeys(doubt for time in clocks if (doubt := doubt_of(time)))
    return tuple(f"Times are read as seconds; they may count {doubt}: save them in seconds." for doubt in found)

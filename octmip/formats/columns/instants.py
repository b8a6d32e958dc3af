"""Dates, times and durations of a tree as text, and the cuts between two of them that need the fewest fields.

A tree compares days since 1970-01-01 (UTC) as float64, `days_of`. A text is right when comparing instants with it
parts them as the tree does. Every whole nanosecond has its days, so a text is one of those that have the days of the
cut: the one of fewest fields. A cut between two neighbouring dates of the training is put where that is short:

    neighbours                                            cut
    2024-03-01               2024-03-02                   2024-03-01
    2024-03-01 10:00:00.320  2024-03-01 10:00:00.340      2024-03-01 10:00:00.33
    2024-03-01 07:00         2024-03-05 19:30             2024-03-04

Instants less than a microsecond apart may share their days, and then no tree parts them.
"""

import datetime
import math
import zoneinfo
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.digits import exact

SECOND = 10**9
DAY = 86400 * SECOND
"""Nanoseconds."""
GRAINS = (DAY, 60 * SECOND, *(SECOND // 10**digits for digits in range(10)))
"""The fields of a text, and the digits of its seconds, as nanoseconds."""
MOST_DAYS = 1e11
"""Farther from 1970 there is no calendar."""


def days_of(ticks: NDArray[np.integer[Any]], per_day: int) -> NDArray[np.float64]:
    """Return the days of instants (n,) that are counted in ticks since 1970, the same for every length of a tick."""
    days, rest = np.divmod(ticks, per_day)
    return days + rest / per_day


def date_text(days: float, zone: str) -> str:
    """Return an instant as ISO 8601 has it, in the fewest fields; with a zone its offset from UTC stands behind.

    Parameters
    ----------
    days
        since 1970-01-01, UTC.
    zone
        of the clock: "" for a clock without a zone, an offset (+02:00) or a name (Europe/Berlin).
    """
    if abs(days) > MOST_DAYS:
        return f"day {exact(days)}"
    offset = _offset(days, zone)
    first, last = instants_of(days)
    day, clock = divmod(_roundest(first + offset, last + offset), DAY)
    text = str(np.datetime64(day, "D"))
    if clock or zone:
        text += f" {_clock(clock, least=2)}"
    return text + (_offset_text(offset) if zone else "")


def duration_text(days: float) -> str:
    """Return a duration in the fewest fields: 3 days, 3 days 02:00:00, 00:05:12.3; of a negative one a minus before."""
    if abs(days) > MOST_DAYS:
        return f"{exact(days)} days"
    instant = _roundest(*instants_of(days))
    day, clock = divmod(abs(instant), DAY)
    sign, plural = "-" if instant < 0 else "", "" if day == 1 else "s"
    whole = f"{day} day{plural}" if day or not clock else ""
    return sign + " ".join(part for part in (whole, _clock(clock, least=3) if clock else "") if part)


def cut_between(low: float, high: float, zone: str = "") -> float:
    """Return the days of the instant of fewest fields between two neighbours: ``low <= cut < high``.

    Where both are whole in a field, such as midnight, so is the cut, and it may be `low` itself; else it lies in the
    middle third.
    """
    offset = _offset(low, zone)
    before, after = (_roundest(*instants_of(days)) + offset for days in (low, high))
    middle = (before + after) // 2
    for grain in GRAINS:
        cut = middle // grain * grain
        if before % grain or after % grain:
            cut = min(cut, cut + grain, key=lambda instant: abs(instant - middle))
            if 6 * abs(cut - middle) > after - before:
                continue
        found = _days(cut - offset)
        return found if low <= found < high else low
    return low


def _days(instant: int) -> float:
    day, clock = divmod(instant, DAY)
    return day + clock / DAY


def instants_of(days: float) -> tuple[int, int]:
    """Return the first and the last nanosecond of these days; where none has them, the last one before, twice."""
    near: int = math.floor(Fraction(days) * DAY)
    reach = 2 + math.ceil(math.ulp(days) * DAY)
    first = _first(lambda instant: _days(instant) >= days, near - reach, near + reach)
    last = _first(lambda instant: _days(instant) > days, near - reach, near + reach) - 1
    return min(first, last), last


def _first(holds: Callable[[int], bool], low: int, high: int) -> int:
    """Return the first instant from which on a condition holds, by halving."""
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def _roundest(first: int, last: int) -> int:
    """Return the instant of fewest fields from `first` to `last`."""
    return next(last // grain * grain for grain in GRAINS if last // grain * grain >= first)


def _clock(clock: int, least: int) -> str:
    """Return a time of day in `least` fields or more: 10:05, 10:05:12, 10:05:12.3."""
    minutes, rest = divmod(clock, 60 * SECOND)
    text = f"{minutes // 60:02d}:{minutes % 60:02d}"
    if not rest and least == 2:
        return text
    seconds, part = divmod(rest, SECOND)
    return f"{text}:{seconds:02d}" + (f".{part:09d}".rstrip("0") if part else "")


def zone_of(zone: datetime.tzinfo | str | None) -> str:
    """Return the name of a time zone as a column keeps it: "" for none, a name that is known, or an offset."""
    if zone is None:
        return ""
    if isinstance(zone, str) or _is_known(str(zone)):
        return str(zone)
    offset = datetime.datetime(1970, 1, 1, tzinfo=zone).utcoffset() or datetime.timedelta(0)
    return _offset_text(offset // datetime.timedelta(seconds=1) * SECOND)


def _is_known(name: str) -> bool:
    try:
        zoneinfo.ZoneInfo(name)
    except (ValueError, OSError, zoneinfo.ZoneInfoNotFoundError):
        return False
    return True


def _offset(days: float, zone: str) -> int:
    """Return how far the clocks of a zone are ahead of UTC at an instant, in nanoseconds; 0 where it is not known."""
    if zone[:1] in ("+", "-"):
        hours, minutes = zone[1:].split(":")
        return int(zone[0] + "1") * (60 * int(hours) + int(minutes)) * 60 * SECOND
    if not zone or not _is_known(zone):
        return 0
    try:
        instant = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC) + datetime.timedelta(days=days)
        offset = instant.astimezone(zoneinfo.ZoneInfo(zone)).utcoffset()
    except OverflowError:  # no calendar of Python's
        return 0
    return (offset or datetime.timedelta(0)) // datetime.timedelta(seconds=1) * SECOND


def _offset_text(offset: int) -> str:
    minutes = abs(offset) // (60 * SECOND)
    return f"{'-' if offset < 0 else '+'}{minutes // 60:02d}:{minutes % 60:02d}"

"""Dates, times and durations of a tree as text, and the cuts between two of them that need the fewest fields.

A tree compares days since 1970-01-01 (UTC) as float64, `days_of`. The text of a cut is the last instant that goes left,
so comparing instants with it parts all of them as the tree does. A cut between two neighbouring dates of the training
is put where its text is short:

    neighbours                                            cut
    2024-03-01               2024-03-02                   2024-03-01
    2024-03-01 10:00:00.320  2024-03-01 10:00:00.340      2024-03-01 10:00:00.33
    2024-03-01 07:00         2024-03-05 19:30             2024-03-04

Float64 tells microseconds apart until the year 2148. Instants between two of them may share their days, and then no
tree parts them; but none shares those of the microsecond before it, or the text of a cut there would need nine digits.
"""

import datetime
import math
import zoneinfo
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.digits import exact

MICROSECOND, SECOND = 10**3, 10**9
DAY = 86400 * SECOND
"""Nanoseconds."""
GRAINS: tuple[int, ...] = (DAY, 60 * SECOND, *(SECOND // 10**digits for digits in range(10)))
"""The fields of a text, and the digits of its seconds, as nanoseconds."""
MOST_DAYS = 1e11
"""Farther from 1970 there is no calendar."""


def days_of(ticks: NDArray[np.integer[Any]], per_day: int) -> NDArray[np.float64]:
    """Return the days of instants (n,) that are counted in ticks since 1970, the same for every length of a tick."""
    return _joined(*np.divmod(ticks, per_day), per_day)


def _joined(days: NDArray[np.int64], rest: NDArray[np.int64], per_day: int) -> NDArray[np.float64]:
    found = days + rest / per_day
    if per_day < DAY:
        return found
    beyond = rest % MICROSECOND
    return np.where(beyond, np.maximum(found, np.nextafter(days + (rest - beyond) / per_day, np.inf)), found)


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
    day, clock = divmod(last_instant(days) + offset, DAY)
    text = str(np.datetime64(day, "D"))
    if clock or zone:
        text += f" {_clock(clock, least=2)}"
    return text + (_offset_text(offset) if zone else "")


def duration_text(days: float) -> str:
    """Return a duration in the fewest fields: 3 days, 3 days 02:00:00, 00:05:12.3; of a negative one a minus before."""
    if abs(days) > MOST_DAYS:
        return f"{exact(days)} days"
    instant = last_instant(days)
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
    before, after = last_instant(low) + offset, last_instant(high) + offset
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
    day, rest = divmod(instant, DAY)  # of Python: no int64 holds the nanoseconds of the year 2263
    return float(_joined(np.array([day]), np.array([rest]), DAY)[0])


def last_instant(days: float) -> int:
    """Return the last nanosecond that has these days or fewer, by halving."""
    near, reach = math.floor(Fraction(days) * DAY), 2 * MICROSECOND + math.ceil(2 * math.ulp(days) * DAY)
    low, high = near - reach, near + reach  # of these two, low has no more days and high has more
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _days(middle) <= days else (low, middle)
    return low


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

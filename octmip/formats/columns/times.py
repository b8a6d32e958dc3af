"""Times as people and programs write them: dates with or without a time of day, and durations.

A form is the order in which a column's dates name year, month and day; a time of day and a zone may stand in any of
its cells. All forms and what they mean stand in docs/howto/text-and-missing.md. Without a zone a time is UTC.

| form | written |
|---|---|
| `%Y-%m-%d` | ISO 8601: 2025-03-04, 20250304T1009Z, week 2025-W10-2, ordinal 2025-063, 2025-03, 2025-Q1 |
| `%Y/%m/%d`, `%d.%m.%Y`, `%d/%m/%Y`, `%m/%d/%Y`, `%d-%m-%Y`, `%m-%d-%Y` | numbers in that order |
| `%d %b %Y` | the month by its name, in any order: 4 Mar 2025, March 4, 2025, Tue Mar  4 10:09:00 2025 |
| `days` | a time of day or a duration: 10:09:26.5, 3:09 PM, 1 days 02:03:04, PT5M12.3S |
"""

import re
import unicodedata
from collections.abc import Callable, Iterable, Sequence
from datetime import date
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.columns.instants import days_of
from octmip.formats.columns.spellings import (
    AFTER_OFFSET,
    AFTERNOON,
    DAYS,
    DURATIONS,
    HALF,
    ISO,
    LOOKS,
    MINUTES,
    MONTHS,
    PATTERNS,
    PLAIN,
    SHORT_YEAR,
    TIME_FIRST,
    TIMES,
    WEEKDAY,
    WEEKDAYS,
    ZONE,
    ZONE_NAME,
)
from octmip.input.messages import shown

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
DAY = pd.Timedelta(days=1)
NANOSECONDS = 86_400 * 10**9
"""In a day."""
MOST_DAYS = 106_000
"""Days from 1970 whose nanoseconds an int64 holds."""
EPOCH = date(1970, 1, 1).toordinal()


def read_times(series: "pd.Series[Any]") -> Floats:
    """Return the days since 1970-01-01 (UTC) of dates and times that pandas holds, NaN where missing, shape (n,)."""
    return days_in(pd.to_datetime(series, utc=True))


def days_in(spans: "pd.Series[Any]") -> Floats:
    """Return the days of durations, or of dates since 1970-01-01 (UTC), NaN where missing, shape (n,)."""
    ticks = spans.astype(np.int64).to_numpy()
    return np.where(spans.isna(), np.nan, days_of(ticks, DAY // pd.Timedelta(1, spans.dt.unit)))


def zone_in(texts: Sequence[str]) -> str:
    """Return the offset from UTC in dates; "UTC" where they have several, "" without any."""
    found = {zone[1] for text in texts if (zone := ZONE.search(AFTER_OFFSET.sub(r"\1", text.strip())))}
    return "" if not found else f"{one[:3]}:{one[-2:]}" if len(found) == 1 and (one := found.pop()) != "Z" else "UTC"


def time_form_of(texts: Sequence[str]) -> str | None:
    """Return the form of different texts (n,) that all are times; None where they are not.

    Raises
    ------
    DataError
        they are times that can be read in two ways, or in none; the sentence begins behind the name of the column.
    """
    if not all(any(c.isdigit() for c in text) for text in texts):
        return None
    if all(SHORT_YEAR.fullmatch(text) for text in texts) and len(texts):
        raise DataError(
            f"holds dates whose years have two digits, such as {shown(texts[0])}; expected four digits; write "
            "2025-03-04"
        )
    if all(MINUTES.fullmatch(text) for text in texts) and len(texts):
        raise DataError(
            f"holds {shown(texts[0])}, which may be minutes and seconds or hours and minutes; write 0:05:12.3"
        )
    forms = time_forms_of(texts)
    if any("%d/%m" in form or "%d-%m" in form for form in forms) and any(
        "%m/%d" in form or "%m-%d" in form for form in forms[1:]
    ):
        raise DataError(
            f"holds dates such as {shown(texts[0])}, and in every cell either number may be the month; expected one "
            "that may not; write them as 2025-03-14"
        )
    if not forms and len(texts) and all(map(_has_zone_name, texts)):
        raise DataError(
            f"holds {shown(texts[0])}, whose zone is a name that may stand for two offsets; write 2025-03-14 "
            "15:09:26+01:00"
        )
    return forms[0] if forms else None


def time_forms_of(texts: Sequence[str]) -> list[str]:
    """Return every form that all of the texts have."""
    return [form for form in TIMES if texts and instants_of(texts, form) is not None]


def _has_zone_name(text: str) -> bool:
    """Whether a text is a time but for the name of its zone."""
    found = ZONE_NAME.search(text)
    is_half = found is not None and found["name"].upper() in ("AM", "PM")
    return found is not None and not is_half and is_time_text(text[: found.start("name")])


def complaint_of(texts: Iterable[str]) -> str:
    """Return what keeps texts that mostly look like times from being read as such; "" where they look like words."""
    texts = list(texts)
    odd = [text for text in texts if not LOOKS.search(text)]
    if 2 * len(odd) > len(texts) or not texts:
        return ""
    form = next((form for form in TIMES if _parsed(next(t for t in texts if t not in odd), form)), "")
    wrong = next((text for text in texts if not (form and _parsed(text, form))), texts[0])
    return f"holds {shown(wrong)} among times; write every time as 2025-03-14 15:09:26.5+01:00, or clear the cell"


def read_time_texts(texts: Sequence[str], form: str) -> Floats | None:
    """Return the days (n,) of texts of one form, None where one is not of it.

    Raises
    ------
    DataError
        two instants would be one number; the sentence begins behind the name of the column.
    """
    parts = instants_of(texts, form)
    if parts is None:
        return None
    days, rest = parts
    if not (rest % 1000).any():
        return days_of(days * (NANOSECONDS // 1000) + rest // 1000, NANOSECONDS // 1000)
    if np.abs(days).max() > MOST_DAYS:
        return None
    found = days_of(days * NANOSECONDS + rest, NANOSECONDS)
    if len(np.unique(found)) < len(set(zip(days.tolist(), rest.tolist(), strict=True))):
        raise DataError(
            "holds times so close together that days since 1970 merge them in float64; subtract the first one, and "
            "give the rest as numbers"
        )
    return found


def instants_of(texts: Sequence[str], form: str) -> tuple[Integers, Integers] | None:
    """Return whole days since 1970-01-01 (n,) and nanoseconds of the day (n,) of texts of one form, None as above."""
    if texts and not _parsed(texts[0], form):  # most columns of text fail at the first cell
        return None
    if form == ISO and len(texts) > MANY and (read := _plain_iso(texts)) is not None:
        return read
    found = []
    for text in texts:
        part = _parsed(text, form)
        if part is None:
            return None
        found.append(part)
    pairs = np.array(found, dtype=np.int64).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1]


MANY = 1000
"""Texts from which on pandas, which knows the plain spellings of ISO 8601 alone, is asked first."""


def plain_instants_of(column: "pd.Series[Any]") -> tuple[Integers, Integers] | None:
    """Return days and nanoseconds as `instants_of`, form ISO, of a column; None where a cell is not plain ISO 8601."""
    if len(column) <= MANY or not isinstance(column.dtype, pd.StringDtype) or column.isna().any():
        return None
    if not PLAIN.fullmatch(column.iloc[0]) or not column.str.fullmatch(PLAIN.pattern).all():
        return None
    return _stamped(column)


def _plain_iso(texts: Sequence[str]) -> tuple[Integers, Integers] | None:
    return _stamped(pd.Series(list(texts))) if all(map(PLAIN.fullmatch, texts)) else None


def _stamped(column: "pd.Series[Any]") -> tuple[Integers, Integers] | None:
    stamps = pd.to_datetime(column, format="ISO8601", errors="coerce", utc=True)
    if stamps.isna().any():
        return None
    per_day = DAY // pd.Timedelta(1, stamps.dt.unit)
    days, rest = np.divmod(stamps.astype(np.int64).to_numpy(), per_day)
    return days, rest * (NANOSECONDS // per_day)


def _parsed(text: str, form: str) -> tuple[int, int] | None:
    """Return whole days since 1970-01-01 and nanoseconds of the day of one text; None where it is not of the form."""
    text = AFTER_OFFSET.sub(r"\1", unicodedata.normalize("NFKC", text))  # narrow blanks before AM and PM
    text = HALF.sub(lambda found: f"{found['clock']} {'pm' if found['half'] in AFTERNOON else 'am'}", text)
    if form == DAYS:
        return _first(_duration, (pattern.fullmatch(text) for pattern in DURATIONS))
    weekday = WEEKDAY.match(text)
    text = text[weekday.end() :] if weekday else text
    swapped = TIME_FIRST.fullmatch(text)
    text = f"{swapped['date']} {swapped['time']}" if swapped else text
    found = _first(_instant, (pattern.fullmatch(text) for pattern in PATTERNS[form]))
    if weekday and found and (found[0] + EPOCH - 1) % 7 != WEEKDAYS.index(weekday["a"][:3].lower()):
        return None
    return found


def _first(
    read: Callable[[dict[str, str | None]], tuple[int, int] | None], matches: Iterable[re.Match[str] | None]
) -> tuple[int, int] | None:
    found = next((match for match in matches if match is not None), None)
    if found is None:
        return None
    try:
        return read(found.groupdict())
    except ValueError:  # no such day
        return None


def _instant(part: dict[str, Any]) -> tuple[int, int] | None:
    clock = _clock(part)
    if clock is None:
        return None
    zone = part.get("z")
    digits = re.sub(r"\D", "", zone or "0")
    minutes = int(digits) * 60 if len(digits) <= 2 else int(digits[:-2]) * 60 + int(digits[-2:])
    offset = minutes * 60 * 10**9 * (-1 if zone and zone.startswith("-") else 1)
    days, rest = divmod(clock - offset, NANOSECONDS)
    return _day(part) - EPOCH + days, rest


def _day(part: dict[str, Any]) -> int:
    """Return the number of a day, 1 for 0001-01-01; ValueError where there is none."""
    year = int(part["Y"])
    if part.get("V"):
        return date.fromisocalendar(year, int(part["V"]), int(part["u"] or 1)).toordinal()
    if part.get("j"):
        day = date(year, 1, 1).toordinal() + int(part["j"]) - 1
        if date.fromordinal(day).year != year:
            raise ValueError(part["j"])
        return day
    month = 3 * int(part["q"]) - 2 if part.get("q") else _month(part)
    return date(year, month, int(part.get("d") or 1)).toordinal()


def _month(part: dict[str, Any]) -> int:
    name = part.get("b")
    if name is None:
        return int(part["m"])
    return MONTHS.get(name.lower(), 0)  # there is no month 0


def _clock(part: dict[str, Any]) -> int | None:
    """Return the nanoseconds of a time of day, up to 24:00, 0 where none is written; None where there is none such."""
    hours, minutes, seconds = (int(part.get(key) or part.get(f"{key}3") or part.get(f"{key}4") or 0) for key in "HMS")
    fraction = int((part.get("f") or part.get("f3") or "0").ljust(9, "0"))
    half = (part.get("p") or part.get("p2") or "").lower()
    if half and not 1 <= hours <= 12:
        return None
    hours = hours % 12 + 12 * (half == "p") if half else hours
    total = (hours * 3600 + minutes * 60 + seconds) * 10**9 + fraction
    return total if minutes < 60 and seconds < 60 and total <= NANOSECONDS else None


def _duration(part: dict[str, Any]) -> tuple[int, int] | None:
    if part.get("p") or part.get("p2"):
        clock = _clock(part)
        return None if clock is None or part.get("D") or part.get("minus") else (0, clock)
    hours, minutes, seconds = (int(part.get(key) or 0) for key in "HMS")
    is_clock = "p" in part and part["H"] is not None
    if is_clock and (minutes >= 60 or seconds >= 60):
        return None
    clock = (hours * 3600 + minutes * 60 + seconds) * 10**9 + int((part.get("f") or "0").ljust(9, "0"))
    days, sign = int(part.get("D") or 0), -1 if part.get("minus") else 1
    total = sign * days * NANOSECONDS + (clock if part.get("plus") else sign * clock)
    return divmod(total, NANOSECONDS)


def is_time_text(text: str) -> bool:
    """Whether a text is a time in some form."""
    return any(_parsed(text.strip(), form) is not None for form in TIMES)


def past_midnight(seconds: Floats) -> tuple[Floats, str]:
    """Return times of day (n_rows,) that fall at midnight alone as times that rise, and that; others as they are."""
    known, day = np.isfinite(seconds), NANOSECONDS / 1e9
    own = seconds[known]
    falls = np.diff(own, prepend=own[:1]) < -day / 2
    risen = own + day * np.cumsum(falls)
    if not falls.any() or own.min() < 0.0 or own.max() > day or (np.diff(risen) < 0.0).any():
        return seconds, ""
    out = seconds.copy()
    out[known] = risen
    return out, f" They pass midnight {int(falls.sum())} time{'s' * (int(falls.sum()) != 1)}, and go on."

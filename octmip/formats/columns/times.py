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
from octmip.input.messages import shown

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
ISO, DAYS, NAMED = "%Y-%m-%d", "days", "%d %b %Y"
DATES = (ISO, "%Y/%m/%d", "%Y.%m.%d", "%d.%m.%Y", "%d/%m/%Y", "%m/%d/%Y", "%d-%m-%Y", "%m-%d-%Y", NAMED)
TIMES = (*DATES, DAYS)
"""Every form of a time."""
DAY = pd.Timedelta(days=1)
NANOSECONDS = 86_400 * 10**9
"""In a day."""
EPOCH = date(1970, 1, 1).toordinal()
MONTHS = {"jan": 1, "feb": 2, "mar": 3, "apr": 4, "may": 5, "jun": 6, "jul": 7, "aug": 8, "sep": 9, "oct": 10} | {
    "nov": 11, "dec": 12, "mär": 3, "mrz": 3, "mai": 5, "okt": 10, "dez": 12
}  # fmt: skip
WEEKDAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_MONTH = r"(?P<b>[A-Za-zä]{3,9})\.?"
_CLOCK = (
    r"(?P<H>\d{1,2})(?::(?P<M>\d{2})(?::(?P<S>\d{2})(?:[.,](?P<f>\d{1,9}))?)?(?:\s*(?P<p>[AaPp])\.?[Mm]\.?)?"
    r"|\s*(?P<p2>[AaPp])\.?[Mm]\.?)"
)
_COMPACT = r"(?P<H3>\d{2})(?:(?P<M3>\d{2})(?:(?P<S3>\d{2})(?:[.,](?P<f3>\d{1,9}))?)?)?"
_ZONE = r"(?:\s*(?:Z|(?:UTC|GMT|UT)?(?P<z>[+-]\d{1,2}(?::?\d{2})?)|UTC|GMT|UT)(?:\s*\(\w+\))?)?"
_AFTER = rf"(?:(?:[T_:]|,?\s+)(?:{_CLOCK})|[T_](?:{_COMPACT})){_ZONE}"
_WEEKDAY = re.compile(r"(?P<a>Mon|Tue|Wed|Thu|Fri|Sat|Sun)[a-z]*\.?,?\s+", re.IGNORECASE)
_CTIME = re.compile(rf"{_MONTH}\s+(?P<d>\d{{1,2}})\s+(?:{_CLOCK})(?:{_ZONE}\s+)(?P<Y>\d{{4}})")
_ZONE_NAME = re.compile(r"\d\s*(?P<name>\[?[A-Z][A-Za-z]+(?:/[A-Z][A-Za-z_]+)*\]?)$")
_LOOKS = re.compile(rf"\d:\d\d|\d{{1,4}}([-/.])\d{{1,2}}\1\d{{1,4}}|\d.{{0,2}}\b(?:{'|'.join(MONTHS)})", re.IGNORECASE)
SHORT_YEAR = re.compile(r"(?:\d{1,2}([/-])\d{1,2}\1\d{2}|\d{2}\.\d{2}\.\d{2})(?:[T\s,].*)?")
MINUTES = re.compile(r"\d{1,2}:\d{2}[.,]\d+")


def _dated(*patterns: str) -> tuple[re.Pattern[str], ...]:
    return tuple(re.compile(f"{pattern}(?:{_AFTER})?") for pattern in patterns)


_Y, _m, _d = r"(?P<Y>\d{4})", r"(?P<m>\d{1,2})", r"(?P<d>\d{1,2})"
_PATTERNS = {
    ISO: (
        *_dated(r"(?P<Y>\d{4})-(?P<m>\d{2})-(?P<d>\d{2})", r"(?P<Y>\d{4})-?W(?P<V>\d{2})(?:-?(?P<u>[1-7]))?"),
        re.compile(rf"(?P<Y>\d{{4}})(?P<m>\d{{2}})(?P<d>\d{{2}}){_AFTER.replace('[T_](', '[T_ -](')}"),
        *_dated(r"(?P<Y>\d{4})-(?P<j>\d{3})"),
        re.compile(r"(?P<Y>\d{4})-(?P<m>\d{2})"),
        re.compile(r"(?P<Y>\d{4})-?Q(?P<q>[1-4])"),
    ),
    "%Y/%m/%d": _dated(f"{_Y}/{_m}/{_d}"),
    "%Y.%m.%d": _dated(rf"{_Y}\.{_m}\.{_d}\.?"),
    "%d.%m.%Y": _dated(rf"{_d}\.\s?{_m}\.\s?{_Y}"),
    "%d/%m/%Y": _dated(f"{_d}/{_m}/{_Y}"),
    "%m/%d/%Y": _dated(f"{_m}/{_d}/{_Y}"),
    "%d-%m-%Y": _dated(f"{_d}-{_m}-{_Y}"),
    "%m-%d-%Y": _dated(f"{_m}-{_d}-{_Y}"),
    NAMED: (
        *_dated(
            rf"{_d}(?:st|nd|rd|th|\.)?[\s/-]?\s?{_MONTH},?[\s/-]?{_Y}",
            rf"{_MONTH}\s+{_d}(?:st|nd|rd|th)?,?\s+{_Y}",
            rf"{_Y}[\s-]{_MONTH}[\s-]{_d}",
        ),
        _CTIME,
    ),
}
_FIRST = re.compile(rf"(?P<time>(?:{_CLOCK}){_ZONE})\s+(?P<date>\S*\d{{4}}\S*|\d.*[a-z].*\d{{4}})")
"""A time of day before its date."""
_DURATIONS = (
    re.compile(rf"(?P<minus>-)?(?:(?P<D>\d+)\s*(?:days?|d)[,\s]\s*)?(?P<plus>\+)?(?:{_CLOCK.replace('1,2', '1,6')})"),
    re.compile(r"(?P<minus>-)?(?P<D>\d+)\s*days?"),
    re.compile(
        r"(?P<minus>-)?P(?=[\dT])(?:(?P<D>\d+)D)?"
        r"(?:T(?=\d)(?:(?P<H>\d+)H)?(?:(?P<M>\d+)M)?(?:(?P<S>\d+)(?:[.,](?P<f>\d{1,9}))?S)?)?"
    ),
)


def read_times(series: "pd.Series[Any]") -> Floats:
    """Return the days since 1970-01-01 (UTC) of dates and times that pandas holds, NaN where missing, shape (n,).

    Raises
    ------
    DataError
        two instants would be one number.
    """
    stamps = pd.to_datetime(series, utc=True)
    return _days_of(stamps - pd.Timestamp(0, tz="UTC"))


def read_durations(series: "pd.Series[Any]") -> Floats:
    """Return the days of durations that pandas holds, NaN where missing, shape (n,).

    Raises
    ------
    DataError
        two durations would be one number.
    """
    return _days_of(pd.to_timedelta(series))


def _days_of(spans: "pd.Series[Any]") -> Floats:
    """Return spans as days: the same float64 in whatever unit pandas counts them."""
    unit = np.timedelta64(1, "D") // np.timedelta64(1, spans.dt.unit) if hasattr(spans.dt, "unit") else NANOSECONDS
    is_missing = spans.isna().to_numpy()
    counts = spans.to_numpy().astype(np.int64)
    return np.where(is_missing, np.nan, _days(*np.divmod(np.where(is_missing, 0, counts), int(unit)), int(unit)))


def _days(whole: Integers, rest: Integers, unit: int) -> Floats:
    """Return whole days and rests counted in `unit` parts of a day as one number each.

    Raises
    ------
    DataError
        float64 would merge two of them.
    """
    days = whole + rest / unit
    if (rest * 1.0 % (unit / 86_400e6) != 0.0).any():  # parts of a microsecond, some of which float64 has no room for
        order = np.lexsort((rest, whole))
        is_apart = (np.diff(whole[order]) != 0) | (np.diff(rest[order]) != 0)
        if ((np.diff(days[order]) == 0.0) & is_apart).any():
            raise DataError(
                "holds instants so close together that days since 1970 merge them in float64; subtract the first, and "
                "give the difference as a number"
            )
    return np.asarray(days, dtype=np.float64)


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
    forms = [form for form in TIMES if texts and instants_of(texts, form) is not None]
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


def _has_zone_name(text: str) -> bool:
    """Whether a text is a time but for the name of its zone."""
    found = _ZONE_NAME.search(text)
    return found is not None and is_time_text(text[: found.start("name")])


def complaint_of(texts: Iterable[str]) -> str:
    """Return what keeps texts that mostly look like times from being read as such; "" where they look like words."""
    texts = list(texts)
    odd = [text for text in texts if not _LOOKS.search(text)]
    if 2 * len(odd) > len(texts) or not texts:
        return ""
    form = next((form for form in TIMES if _parsed(next(t for t in texts if t not in odd), form)), "")
    wrong = next((text for text in texts if not (form and _parsed(text, form))), texts[0])
    return f"holds {shown(wrong)} among times; write every time as 2025-03-14 15:09:26.5+01:00, or clear the cell"


def read_time_texts(texts: Sequence[str], form: str) -> Floats | None:
    """Return the days (n,) of texts of one form, None where one is not of it."""
    parts = instants_of(texts, form)
    return None if parts is None else _days(*parts, NANOSECONDS)


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
_PLAIN = re.compile(r"\d{4}-\d{2}-\d{2}(?:[T ]\d{2}:\d{2}(?::\d{2}(?:\.\d{1,9})?)?(?:Z|[+-]\d{2}:?\d{2})?)?")


def _plain_iso(texts: Sequence[str]) -> tuple[Integers, Integers] | None:
    if not all(map(_PLAIN.fullmatch, texts)):
        return None
    stamps = pd.to_datetime(pd.Series(list(texts)), format="ISO8601", errors="coerce", utc=True)
    if stamps.isna().any():
        return None
    counts = stamps.dt.tz_localize(None).to_numpy()
    days = counts.astype("datetime64[D]")
    rest = counts - days
    step = NANOSECONDS // int(np.timedelta64(1, "D") // np.timedelta64(1, np.datetime_data(counts.dtype)[0]))
    return days.astype(np.int64), rest.astype(np.int64) * step


def _parsed(text: str, form: str) -> tuple[int, int] | None:
    """Return whole days since 1970-01-01 and nanoseconds of the day of one text; None where it is not of the form."""
    text = unicodedata.normalize("NFKC", text)  # narrow blanks before AM and PM
    if form == DAYS:
        return _first(_duration, (pattern.fullmatch(text) for pattern in _DURATIONS))
    weekday = _WEEKDAY.match(text)
    text = text[weekday.end() :] if weekday else text
    swapped = _FIRST.fullmatch(text)
    text = f"{swapped['date']} {swapped['time']}" if swapped else text
    found = _first(_instant, (pattern.fullmatch(text) for pattern in _PATTERNS[form]))
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


def _instant(part: dict[str, str | None]) -> tuple[int, int] | None:
    clock = _clock(part)
    if clock is None:
        return None
    zone = part.get("z")
    digits = re.sub(r"\D", "", zone or "0")
    minutes = int(digits) * 60 if len(digits) <= 2 else int(digits[:-2]) * 60 + int(digits[-2:])
    offset = minutes * 60 * 10**9 * (-1 if zone and zone.startswith("-") else 1)
    days, rest = divmod(clock - offset, NANOSECONDS)
    return _day(part) - EPOCH + days, rest


def _day(part: dict[str, str | None]) -> int:
    """Return the number of a day, 1 for 0001-01-01; ValueError where there is none."""
    year = int(part["Y"] or 0)
    if part.get("V"):
        return date.fromisocalendar(year, int(part["V"] or 1), int(part["u"] or 1)).toordinal()
    if part.get("j"):
        day = date(year, 1, 1).toordinal() + int(part["j"] or 1) - 1
        if date.fromordinal(day).year != year:
            raise ValueError(part["j"])
        return day
    month = 3 * int(part["q"] or 1) - 2 if part.get("q") else _month(part)
    return date(year, month, int(part.get("d") or 1)).toordinal()


def _month(part: dict[str, str | None]) -> int:
    name = part.get("b")
    if name is None:
        return int(part["m"] or 1)
    full = pd.Timestamp(2000, MONTHS.get(name[:3].lower(), 1), 1).month_name().lower()
    is_known = name.lower() in (full, full[:3], "sept", *_GERMAN)
    return MONTHS.get(name[:3].lower(), 0) if is_known else 0  # there is no month 0


_GERMAN = ("januar", "februar", "märz", "mär", "mrz", "mai", "juni", "juli", "oktober", "okt", "dezember", "dez")


def _clock(part: dict[str, str | None]) -> int | None:
    """Return the nanoseconds of a time of day, up to 24:00, 0 where none is written; None where there is none such."""
    hours, minutes, seconds = (int(part.get(key) or part.get(f"{key}3") or 0) for key in "HMS")
    fraction = int((part.get("f") or part.get("f3") or "0").ljust(9, "0"))
    half = (part.get("p") or part.get("p2") or "").lower()
    if half and not 1 <= hours <= 12:
        return None
    hours = hours % 12 + 12 * (half == "p") if half else hours
    total = (hours * 3600 + minutes * 60 + seconds) * 10**9 + fraction
    return total if minutes < 60 and seconds < 60 and total <= NANOSECONDS else None


def _duration(part: dict[str, str | None]) -> tuple[int, int] | None:
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

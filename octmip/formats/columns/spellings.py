"""Patterns of the ways in which dates, times of day, zones and durations are written (`octmip.formats.columns.times`).

Groups: Y, m, d year, month and day; V, u week and its day; j day of the year; q quarter; b name of the month; H, M, S,
f hours, minutes, seconds and their fraction (H3 to f3 without colons); p, p2 AM or PM; z offset from UTC; D days.
"""

import re

ISO, DAYS, NAMED = "%Y-%m-%d", "days", "%d %b %Y"
DATES = (ISO, "%Y/%m/%d", "%Y.%m.%d", "%d.%m.%Y", "%d/%m/%Y", "%m/%d/%Y", "%d-%m-%Y", "%m-%d-%Y", NAMED)
TIMES = (*DATES, DAYS)
"""Every form of a time."""
MONTHS = {"jan": 1, "feb": 2, "mar": 3, "apr": 4, "may": 5, "jun": 6, "jul": 7, "aug": 8, "sep": 9, "oct": 10} | {
    "nov": 11, "dec": 12, "mär": 3, "mrz": 3, "mai": 5, "okt": 10, "dez": 12
}  # fmt: skip
WEEKDAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_MONTH = r"(?P<b>[A-Za-zä]{3,9})\.?"
CLOCK = (
    r"(?P<H>\d{1,2})(?::(?P<M>\d{2})(?::(?P<S>\d{2})(?:(?:[.,]|:(?=\d{3}\b))(?P<f>\d{1,9}))?)?(?:\s*(?P<p>[AaPp])\.?[Mm]\.?)?"
    r"|\s*(?P<p2>[AaPp])\.?[Mm]\.?)"
)
_COMPACT = r"(?P<H3>\d{2})(?:(?P<M3>\d{2})(?:(?P<S3>\d{2})(?:[.,](?P<f3>\d{1,9}))?)?)?"
_ZONE = r"(?:\s*(?:Z|(?:UTC|GMT|UT)?(?P<z>[+-]\d{1,2}(?::?\d{2})?)|UTC|GMT|UT)(?:\s*\(\w+\))?)?"
_AFTER = rf"(?:(?:[T_:]|,?\s+)(?:{CLOCK})|[T_](?:{_COMPACT})){_ZONE}"
WEEKDAY = re.compile(r"(?P<a>Mon|Tue|Wed|Thu|Fri|Sat|Sun)[a-z]*\.?,?\s+", re.IGNORECASE)
CTIME = re.compile(rf"{_MONTH}\s+(?P<d>\d{{1,2}})\s+(?:{CLOCK})(?:{_ZONE}\s+)(?P<Y>\d{{4}})")
ZONE_NAME = re.compile(r"\d\s*(?P<name>\[?[A-Z][A-Za-z]+(?:/[A-Z][A-Za-z_]+)*\]?)$")
LOOKS = re.compile(rf"\d:\d\d|\d{{1,4}}([-/.])\d{{1,2}}\1\d{{1,4}}|\d.{{0,2}}\b(?:{'|'.join(MONTHS)})", re.IGNORECASE)
SHORT_YEAR = re.compile(r"(?:\d{1,2}([/-])\d{1,2}\1\d{2}|\d{2}\.\d{2}\.\d{2})(?:[T\s,].*)?")
MINUTES = re.compile(r"\d{1,2}:\d{2}[.,]\d+")


def _dated(*patterns: str) -> tuple[re.Pattern[str], ...]:
    return tuple(re.compile(f"{pattern}(?:{_AFTER})?") for pattern in patterns)


_Y, _m, _d = r"(?P<Y>\d{4})", r"(?P<m>\d{1,2})", r"(?P<d>\d{1,2})"
PATTERNS = {
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
        CTIME,
    ),
}
TIME_FIRST = re.compile(rf"(?P<time>(?:{CLOCK}){_ZONE})\s+(?P<date>\S*\d{{4}}\S*|\d.*[a-z].*\d{{4}})")
"""A time of day before its date."""
DURATIONS = (
    re.compile(rf"(?P<minus>-)?(?:(?P<D>\d+)\s*(?:days?|d)[,\s]\s*)?(?P<plus>\+)?(?:{CLOCK.replace('1,2', '1,6')})"),
    re.compile(r"(?P<minus>-)?(?P<D>\d+)\s*days?"),
    re.compile(
        r"(?P<minus>-)?P(?=[\dT])(?:(?P<D>\d+)D)?"
        r"(?:T(?=\d)(?:(?P<H>\d+)H)?(?:(?P<M>\d+)M)?(?:(?P<S>\d+)(?:[.,](?P<f>\d{1,9}))?S)?)?"
    ),
)
PLAIN = re.compile(r"\d{4}-\d{2}-\d{2}(?:[T ]\d{2}:\d{2}(?::\d{2}(?:\.\d{1,9})?)?(?:Z|[+-]\d{2}:?\d{2})?)?")
ZONE = re.compile(r":\d\d(?:[.,]\d+)?\s*(?:UTC|GMT)?(Z|[-+]\d\d:?\d\d)$")
"""An offset behind a time of day."""
AFTER_OFFSET = re.compile(r"(Z|[-+]\d\d:?\d\d)(?: [A-Z]{3,5}|\[[A-Za-z_]+(?:/[A-Za-z_+-]+)*\])$")
"""The name of a zone behind its offset, as Java and Go write it: +01:00[Europe/Berlin], +0200 CEST."""
GERMAN = ("januar", "februar", "märz", "mär", "mrz", "mai", "juni", "juli", "oktober", "okt", "dezember", "dez")

"""Patterns of the ways in which dates, times of day, zones and durations are written (`octmip.formats.columns.times`).

Groups: Y, m, d year, month and day; V, u week and its day; j day of the year; q quarter; b name of the month; H, M, S,
f hours, minutes, seconds and their fraction (H3 to f3 without colons, H4 to S4 between points); p, p2 AM or PM;
z offset from UTC; D days.
"""

import re

ISO, DAYS, NAMED = "%Y-%m-%d", "days", "%d %b %Y"
DATES = (ISO, "%Y/%m/%d", "%Y.%m.%d", "%d.%m.%Y", "%d/%m/%Y", "%m/%d/%Y", "%d-%m-%Y", "%m-%d-%Y", NAMED)
TIMES = (*DATES, DAYS)
"""Every form of a time."""
_YEARS = (
    "january february march april may june july august september october november december",
    "januar februar märz april mai juni juli august september oktober november dezember",
    "janvier février mars avril mai juin juillet août septembre octobre novembre décembre",
    "enero febrero marzo abril mayo junio julio agosto septiembre octubre noviembre diciembre",
    "gennaio febbraio marzo aprile maggio giugno luglio agosto settembre ottobre novembre dicembre",
    "janeiro fevereiro março abril maio junho julho agosto setembro outubro novembro dezembro",
    "januari februari maart april mei juni juli augustus september oktober november december",
    "januar februar marts april maj juni juli august september oktober november december",
    "januari februari mars april maj juni juli augusti september oktober november december",
    "januar februar mars april mai juni juli august september oktober november desember",
    "tammikuuta helmikuuta maaliskuuta huhtikuuta toukokuuta kesäkuuta heinäkuuta elokuuta syyskuuta lokakuuta "
    "marraskuuta joulukuuta",
    "jan feb mar apr may jun jul aug sep oct nov dec",
    "ene fev mär avr mai juin juil ago sept okt nov dez",
    "gen févr mrz abr mag giu lug août set ott nov dic",
    "janv feb mrt apr mei jun jul aug sep out nov déc",
    "jan feb mar apr maj jun jul aug sep okt nov des",
)
MONTHS = {name: number for year in _YEARS for number, name in enumerate(year.split(), start=1)}
"""Months by name in English, German, French, Spanish, Italian, Portuguese, Dutch, Danish, Swedish, Norwegian and
Finnish, and as these are cut short."""
WEEKDAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_SOME = "jan|feb|mar|apr|may|jun|jul|aug|sep|oct|nov|dec|mär|mrz|mai|okt|dez"  # 2 set, 3 out are no dates
_MONTH = r"(?P<b>[A-Za-zà-ÿ]{3,12})\.?"
CLOCK = (
    r"(?P<H>\d{1,2})(?::(?P<M>\d{2})(?::(?P<S>\d{2})(?:(?:[.,]|:(?=\d{3}\b))(?P<f>\d{1,9}))?)?(?:\s*(?P<p>[AaPp])\.?\s?[Mm]\.?)?"
    r"|\s*(?P<p2>[AaPp])\.?\s?[Mm]\.?)"
)
_COMPACT = r"(?P<H3>\d{2})(?:(?P<M3>\d{2})(?:(?P<S3>\d{2})(?:[.,](?P<f3>\d{1,9}))?)?)?"
_ZONE = r"(?:\s*(?:Z|(?:UTC|GMT|UT)?(?P<z>[+-]\d{1,2}(?::?\d{2})?)|UTC|GMT|UT)(?:\s*\(\w+\))?)?"
_DOTTED = r"(?:klo\.?\s+|kl\.?\s+)?(?P<H4>\d{1,2})\.(?P<M4>\d{2})(?:\.(?P<S4>\d{2}))?"
_AFTER = rf"(?:(?:[T_:]|,?\s+)(?:{CLOCK})|[T_](?:{_COMPACT})|,?\s+{_DOTTED}){_ZONE}"
WEEKDAY = re.compile(r"(?P<a>Mon|Tue|Wed|Thu|Fri|Sat|Sun)[a-z]*\.?,?\s+", re.IGNORECASE)
CTIME = re.compile(rf"{_MONTH}\s+(?P<d>\d{{1,2}})\s+(?:{CLOCK})(?:{_ZONE}\s+)(?P<Y>\d{{4}})")
ZONE_NAME = re.compile(r"\d\s*(?P<name>\[?[A-Z][A-Za-z]+(?:/[A-Z][A-Za-z_]+)*\]?)$")
LOOKS = re.compile(rf"\d:\d\d|\d{{1,4}}([-/.])\d{{1,2}}\1\d{{1,4}}|\d.{{0,2}}\b(?:{_SOME})", re.IGNORECASE)
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
        *_dated(rf"{_Y}[年년]\s?{_m}[月월]\s?{_d}[日일]"),
    ),
    "%Y/%m/%d": _dated(f"{_Y}/{_m}/{_d}"),
    "%Y.%m.%d": _dated(rf"{_Y}\.\s?{_m}\.\s?{_d}\.?"),
    "%d.%m.%Y": _dated(rf"{_d}\.\s?{_m}\.\s?{_Y}"),
    "%d/%m/%Y": _dated(f"{_d}/{_m}/{_Y}"),
    "%m/%d/%Y": _dated(f"{_m}/{_d}/{_Y}"),
    "%d-%m-%Y": _dated(f"{_d}-{_m}-{_Y}"),
    "%m-%d-%Y": _dated(f"{_m}-{_d}-{_Y}"),
    NAMED: (
        *_dated(
            rf"{_d}(?:st|nd|rd|th|er|\.)?[\s/-]?\s?(?:de )?{_MONTH},?[\s/-]?(?:de )?{_Y}",
            rf"{_MONTH}\s+{_d}(?:st|nd|rd|th)?,?\s+{_Y}",
            rf"{_Y}[\s-]{_MONTH}[\s-]{_d}",
        ),
        CTIME,
    ),
}
HALF = re.compile(r"(?P<half>오전|오후|午前|午後|上午|下午)\s*(?P<clock>\d{1,2}:\d{2}(?::\d{2})?)")
AFTERNOON = ("오후", "午後", "下午")
"""The half of a day before its time, as Excel writes it in Korea, Japan and China."""
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

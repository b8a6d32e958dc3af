"""Numbers as people write them: dates, per cent, money, digits in groups. All cells of a column have one form.

| form | written | read as |
|---|---|---|
| that of a time (`octmip.formats.columns.times`) | 2025-03-04, 4 Mar 2025, also with a time of day; 10:09:26 | days |
| `1,000.5` | 1,000.50 or 1 000.50 | 1000.5 |
| `1.000,5` | 1.000,50 or 2,5 | 1000.5, 2.5 |
| one of these two and a sign or unit, such as `1,000.5$`, `1,000.5%`, `1,000.5mm` | $1,000.50, 5 %, 5 mm | 1000.5, 5 |

A zero may stand without the sign of the others. Beside other numbers (5.00) and 5.00- are below zero. A column that
fits two forms with two meanings is refused: 03/04/2025 where every cell may be day/month or month/day, and 1,234 where
every comma may group digits or begin decimals. Of money the comma before three digits groups them, since amounts have
two decimals.
"""

import re
import unicodedata
from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.columns.spellings import DATES, DAYS, TIMES
from octmip.formats.columns.times import read_time_texts, time_form_of
from octmip.input.cells import BEYOND, is_beyond
from octmip.input.messages import shown

Floats = NDArray[np.float64]
UNIT = r"°?[^\W\d_]{1,5}(?:[/·*][^\W\d_]{1,5})?[²³]?|°"
"""A unit behind a number; a longer word may be anything."""
FEW = 2
"""Different numbers that a word may stand behind and be no unit: 2wd, 4wd."""
NUMBER_PART = re.compile(
    r"(?P<minus>[-+]?)\s*(?P<before>[^\w\s%.,'+-]?)\s*(?P<digits>[0-9][0-9.,' \u00a0\u202f]*?)"
    rf"\s*(?P<after>{UNIT}|[^\w\s.,'+-]?)"
)
BELOW = re.compile(r"(?P<sign>[^\w\s()+-]?)\s*\((?P<a>[^()+-]*[0-9][^()+-]*)\)|(?P<b>[^()+-]*[0-9][^()+-]*?)\s*-")
"""A number below zero as accountants and SAP write it."""
ACCOUNTED_ZERO = re.compile(r" [^\w\s]?\s*- {2,}")
"""A zero as Excel's accounting formats write it, between blanks."""
DIGITS = {  # no group begins with a zero: 0,945 has decimals
    "1,000.5": r"(?:[1-9][0-9]{0,2}(?:[,' \u00a0\u202f][0-9]{3})+|[1-9][0-9]?(?:,[0-9]{2})+,[0-9]{3}|[0-9]+)"
    r"(?:\.[0-9]%s)?",
    "1.000,5": r"(?:[1-9][0-9]{0,2}(?:[.' \u00a0\u202f][0-9]{3})+|[0-9]+)(?:,[0-9]%s)?",
}

FORMS = rf"^(|{'|'.join(map(re.escape, TIMES))}|({'|'.join(map(re.escape, DIGITS))})({UNIT}|[^\w\s]?))$"
"""Every form, and "" for plain numbers, as a pattern."""


def form_of(texts: Sequence[str]) -> str | None:
    """Return the form of different texts (n,); None where they have none and are words.

    Raises
    ------
    DataError
        they fit two forms with two meanings, or mix signs; the sentence begins behind the name of the column.
    """
    stripped = [text.strip() for text in texts]
    if not stripped or not all(any(c.isdigit() for c in text) for text in stripped):
        return None
    form = time_form_of(stripped)
    if form is not None:
        return form
    numbers = {form: read for form in _numeric_forms(stripped) if (read := _read(stripped, form)) is not None}
    if len(numbers) == 2:
        one, other = numbers.values()
        for text, grouped, decimal in zip(stripped, one.tolist(), other.tolist(), strict=True):
            if grouped != decimal:
                raise DataError(
                    f"holds {shown(text)}, which may be {grouped:.15g} or {decimal:.15g}, and no cell shows whether "
                    "the comma or the point begins decimals; write the numbers without marks between groups of digits"
                )
    return next(iter(numbers), None)


def read_texts(texts: Sequence[str], form: str) -> Floats:
    """Return the numbers (n,) of texts of a form.

    Raises
    ------
    DataError
        a text is not of it; the sentence begins behind the name of the column.
    """
    stripped = [text.strip() for text in texts]
    read = _read(stripped, form)
    if read is None:
        wrong = next(text for text in stripped if _read([text], form) is None)
        raise DataError(f"holds {shown(wrong)}; expected {words_of(form)}, as in training; write it so")
    return read


def is_date(form: str) -> bool:
    """Whether a form is that of dates."""
    return form in DATES


def is_time(form: str) -> bool:
    """Whether a form is that of dates, times of day or durations."""
    return form in TIMES


def unit_of(form: str) -> str:
    """Return what numbers of different forms must share to be compared: dates are days, amounts are plain numbers."""
    if is_time(form):
        return "date" if is_date(form) else form
    return "" if _is_money(form[7:]) else form[7:]


def words_of(form: str) -> str:
    """Return what a form means, for a sentence."""
    if not form:
        return "plain numbers or text"
    if form == DAYS:
        return "times of day or durations in days (6:00 is 0.25)"
    if is_date(form):
        example = pd.Timestamp(2025, 3, 14).strftime(form)
        return f"dates (14 March 2025: {example}), in days since 1970-01-01"
    style, sign = form[:7], form[7:]
    if sign == "%":
        return f"per cent (5% is 5, and {style} is 1000.5)"
    kind = "amounts" if _is_money(sign) else "numbers"
    return f"{kind}{f' in {sign}' if sign else ''} ({style} is 1000.5)"


def _read(texts: Sequence[str], form: str) -> Floats | None:
    """Return the numbers of texts that all have a form, None where one has not."""
    return read_time_texts(texts, form) if is_time(form) else _numbers(texts, form[:7], form[7:])


def _numeric_forms(texts: Sequence[str]) -> tuple[str, ...]:
    if all(map(BELOW.fullmatch, texts)):  # (1), (2) are no numbers below zero, nor are grades such as 3-
        return ()
    parts = [NUMBER_PART.fullmatch(_signed(text)) for text in texts]
    signs = {_sign(part) for part in parts if part is not None and not _is_zero(part)} or {""}
    if None in parts or not all(sign in ("", "%") or _is_unit(sign) or _is_money(sign) for sign in signs):
        return ()
    if any(map(_is_unit, signs)) and (len(signs) > 1 or len(texts) <= FEW):
        return ()
    if len(signs) > 1:
        named = " and ".join(sorted(sign or "none" for sign in signs))
        raise DataError(f"holds numbers with different signs ({named}); expected one sign in every cell; write it so")
    return tuple(style + sign for style in DIGITS for sign in signs)


def _signed(text: str) -> str:
    """Return a number with its minus before it, and the apostrophe of a Swiss keyboard between its groups."""
    text = text.replace("\u2019", "'")
    below = BELOW.fullmatch(text)
    return text if below is None else f"-{below['sign'] or ''}{below['a'] or below['b']}"


def _is_unit(sign: str) -> bool:
    return re.fullmatch(UNIT, sign) is not None


def _is_money(sign: str) -> bool:
    return len(sign) == 1 and unicodedata.category(sign) == "Sc"


def _sign(part: re.Match[str]) -> str:
    return part["before"] or part["after"]


def _is_zero(part: re.Match[str]) -> bool:
    """Whether a number is a zero without a sign, which is nothing in every unit: 0 beside $5."""
    return not _sign(part) and not set(part["digits"]) - set("0.,")


def _numbers(texts: Sequence[str], style: str, sign: str) -> Floats | None:
    pattern = re.compile(DIGITS[style] % ("{1,2}" if _is_money(sign) else "+"))
    out = []
    for text in texts:
        part = NUMBER_PART.fullmatch(_signed(text))
        own_sign = part is not None and (_sign(part) == sign or _is_zero(part))
        if part is None or not own_sign or not pattern.fullmatch(part["digits"]):
            return None
        digits = re.sub(r"[' \u00a0\u202f]", "", part["digits"])
        plain = digits.replace(",", "") if style == "1,000.5" else digits.replace(".", "").replace(",", ".")
        if is_beyond(plain):
            raise DataError(f"holds {shown(text)}, {BEYOND}, or leave it out")
        out.append(float(part["minus"] + plain))
        if np.isinf(out[-1]):
            raise DataError(f"holds {shown(text)}, which is too large for float64; correct it, or leave it out")
    return np.array(out)

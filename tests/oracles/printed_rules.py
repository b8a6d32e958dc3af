"""A tree as people read it, applied to the cells of a table: what the words say, whatever the tree holds.

Nothing here comes from octmip: Python's `float` reads numbers, pandas dates, and durations are fractions of seconds.
"""

import datetime
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import pandas as pd

Row = Mapping[str, Any]
SAID = re.compile(r"(?P<sign>-?)(?:(?P<days>\d+) days?)? ?(?:(?P<clock>\d\d:\d\d:\d\d)(?P<part>\.\d+)?)?")
POWERS = str.maketrans("\u2212\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079", "--0123456789")


def answers(words: str, rows: Sequence[Row]) -> list[str]:
    """Return what the indented lines of a tree answer for each row: the text of its leaf."""
    lines = words.splitlines()
    return [_answer(lines, 0, row) for row in rows]


def _answer(lines: Sequence[str], depth: int, row: Row) -> str:
    """Return the answer of the lines, the first of which stands at a depth."""
    first = lines[0][4 * depth :]
    if not first.startswith("if "):
        return re.sub(r" {4}\(\d+ samples?(, \d+ wrong)?\)$", "", first)
    middle = next(k for k, line in enumerate(lines) if line == " " * 4 * depth + "else")
    return _answer(lines[1:middle] if holds(first[3:], row) else lines[middle + 1 :], depth + 1, row)


def holds(condition: str, row: Row) -> bool:
    """Return whether a condition holds for a row, such as "age <= 40.5 or missing", "-2 a + b <= 3", "c is not red"."""
    text = condition.translate(POWERS).replace("≤", "<=").removesuffix("?")
    if " <= " in text:
        left, right = text.split(" <= ")
        cut = right.removesuffix(" or missing")
        if left in row:
            return right != cut if row[left] is None else row[left] <= value_of(cut, row[left])
        total = _sum(left, row)
        return right != cut if total is None else total <= number(cut)
    if found := re.fullmatch(r"(\S+) (not )?in \{(.*)\}", text):
        members = [None if member == "missing" else member for member in found[3].split(", ")]
        return (row[found[1]] in members) != bool(found[2])
    name, _, rest = text.partition(" is ")
    wanted, is_not = rest.removeprefix("not "), rest.startswith("not ")
    if " or before it" in wanted:  # in the order of the alphabet
        last = wanted.replace(" or before it", "").removesuffix(" or missing")
        return wanted.endswith(" or missing") if row[name] is None else row[name] <= last
    members = [None if member == "missing" else member for member in wanted.split(" or ")]
    return (row[name] in members) != is_not


def value_of(text: str, like: Any) -> Any:
    """Return the value that a text says, to be compared with one like another."""
    if isinstance(like, pd.Timestamp | datetime.date):
        return pd.Timestamp(text)
    if isinstance(like, Fraction):
        return _duration(text)
    return number(text)


def number(text: str) -> float:
    """Return a number as a page or a program writes it: 1,700,000.5, 1e-30, 1 times a power of ten."""
    return float(text.translate(POWERS).replace(",", "").replace(" ", "").replace("\u00d710", "e"))


def _duration(text: str) -> Fraction:
    found = SAID.fullmatch(text)
    assert found, text
    hours, minutes, seconds = map(int, (found["clock"] or "00:00:00").split(":"))
    size = 86400 * int(found["days"] or 0) + 3600 * hours + 60 * minutes + seconds + Fraction(found["part"] or 0)
    return -size if found["sign"] else size


def _sum(terms: str, row: Row) -> float | None:
    """Return the sum of terms such as "-2 a + b - 0.5 c"; None where one of them is missing."""
    total = 0.0
    for term in re.sub(r"(^| )([-+]) ?", r"\n\2", terms).strip().split("\n"):
        *size, name = term.removeprefix("+").split()
        sign, name = (-1.0, name[1:]) if name.startswith("-") else (1.0, name)
        if row[name] is None:
            return None
        total += (number("".join(size)) if size else sign) * float(row[name])
    return total

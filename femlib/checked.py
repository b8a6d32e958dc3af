"""Values of files: checked numbers, names, lists and arrays, with one sentence where a value is not as expected.

Each function takes the value and where it stands ("data.csv.json: seed"), and returns it as its kind.
"""

import math
import re
from collections.abc import Mapping
from typing import Any

from femlib.errors import InputError

MOST_WHOLE = 2**63 - 1
MOST_NAME = 1000
"""Characters of a name."""
SHOWN = 60
"""Characters of a value that a message shows."""
_FORTRAN = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[eEdD]([+-]?\d{1,4})|([+-]\d{1,4}))?")
"""A number and its exponent, which needs no letter where it has a sign."""


def shown(value: object) -> str:
    """Return a value as a message can show it: short, on one line, nothing that a terminal would obey."""
    if isinstance(value, int) and abs(value) >= 10**SHOWN:
        return f"a whole number of more than {SHOWN} digits"
    if isinstance(value, list | tuple | dict) and value:
        return f"{'an object' if isinstance(value, dict) else 'a list'} of {len(value)}"
    words = repr(value[: SHOWN + 1] if isinstance(value, str) else value)
    return words if len(words) <= SHOWN else f"{words[:SHOWN]}..."


def _refused(value: object, where: str, expected: str) -> InputError:
    return InputError(f"{where} is {shown(value)}; expected {expected}; write the file again")


def taken(content: object, name: str, where: str) -> Any:
    """Return an entry of an object.

    Raises
    ------
    InputError
        If it is no object or has no such entry.
    """
    if not isinstance(content, Mapping):
        raise _refused(content, where, "an object")
    if name not in content:
        raise InputError(f"{where} lacks the entry {name!r}; expected it among the others; write the file again")
    return content[name]


def fortran_number(word: str) -> float:
    """Return a number as Fortran programs write it: 1.5, 1.5E3, 1.5D+3, and 1.5+103, where no letter has room.

    Raises
    ------
    ValueError
        If it is none; a number that is not finite is none.
    """
    found = _FORTRAN.fullmatch(word.strip())
    number = float(f"{found[1]}e{found[2] or found[3] or 0}") if found else math.inf
    if not math.isfinite(number):
        raise ValueError(f"{shown(word)} is no finite number")
    return number


def reason_of(error: Exception) -> str:
    """Return why a word is no number of its kind, without Python's own words."""
    return re.sub(r"invalid literal for int\(\) with base 10: (.*)", r"\1 is no whole number", str(error))


def whole(value: object, where: str, low: int = 0, high: int = MOST_WHOLE) -> int:
    """Return a whole number from `low` to `high`; InputError if it is none."""
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise _refused(value, where, f"a whole number from {low} to {high}")
    return value


def text(value: object, where: str, most: int = MOST_NAME) -> str:
    """Return a text of at most `most` characters; InputError if it is none."""
    if not isinstance(value, str) or len(value) > most:
        raise _refused(value, where, f"a text of at most {most} characters")
    return value


def names(value: object, where: str, least: int = 1) -> tuple[str, ...]:
    """Return a list of at least so many different names; InputError if it is none."""
    if not isinstance(value, list) or len(value) < least:
        raise _refused(value, where, f"a list of at least {least} names")
    found = tuple(text(entry, f"{where}[{k}]") for k, entry in enumerate(value))
    if len(set(found)) < len(found):
        raise InputError(f"{where} names something twice; expected every name once; write the file again")
    return found

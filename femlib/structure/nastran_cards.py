"""Cards of a Nastran bulk data file: small, large and free fields, continuations, included files.

Source: MSC Nastran Quick Reference Guide (2020), Bulk Data Entries. pyNastran 1.4.1 would be the reader, but asks for
numpy before 2; meshio 5.3.5 ends at the first field that it does not expect. The tests hold what pyNastran reads.
"""

import re
from collections.abc import Iterator
from pathlib import Path

from femlib.checked import fortran_number
from femlib.errors import InputError
from femlib.structure.deck_lines import lines_of

SMALL, LARGE = 8, 16
"""Columns of a field."""
NAMED = (
    re.compile(r'\$HMNAME PROP\S*\s+(?P<id>\d+)\s*"(?P<name>[^"]+)"'),  # HyperMesh
    re.compile(r"\$ANSA_NAME_COMMENT;(?P<id>\d+);P(?:SHELL|COMPG?|BAR|BARL|BEAM|BEAML|ROD);(?P<name>[^;]+);"),
    re.compile(r'\$ Pset: "(?P<name>[^"]+)" will be imported as: "\w+\.(?P<id>\d+)"'),  # Patran
    re.compile(r"\$ Femap Property (?P<id>\d+) : (?P<name>.*\S)"),
)
"""Comments by which mesh programs name the properties."""


class Card:
    """One bulk data entry.

    Attributes
    ----------
    name : its name in capitals.
    fields : its fields from the second on, without those of continuations' names; "" where one is blank.
    """

    __slots__ = ("fields", "name")

    def __init__(self, name: str, fields: list[str]) -> None:
        self.name, self.fields = name, fields

    def text(self, number: int) -> str:
        """Return a field by the number that the guide gives it: 2 is the first behind the name."""
        place = number - 2 - 2 * ((number - 2) // 10)  # fields 10 and 11, 20 and 21 join lines
        return self.fields[place] if place < len(self.fields) else ""

    def whole(self, number: int, default: int = 0) -> int:
        """Return a field as a whole number; ValueError if it is none."""
        word = self.text(number)
        return int(word) if word else default

    def real(self, number: int, default: float = 0.0) -> float:
        """Return a field as a number; ValueError if it is none."""
        word = self.text(number)
        return fortran_number(word) if word else default


def cards_of(path: Path) -> tuple[list[Card], dict[int, str], bool]:
    """Return the cards of a file's bulk data, the names of properties in its comments, and whether gmsh rounded them.

    Raises
    ------
    InputError
        If a file cannot be read or is no text, files include each other, or a line continues no card.
    """
    lines = list(lines_of(path, "nastran", _included))
    names = {int(found["id"]): found["name"].strip() for line in lines for own in NAMED if (found := own.match(line))}
    is_rounded = lines[:1] == ["$ Created by Gmsh"] and not any(line.startswith("GRID*") for line in lines)
    cards: list[Card] = []
    for line in _bulk([line.partition("$")[0].rstrip() for line in lines]):
        name, fields = _fields(line)
        if name:
            cards.append(Card(name, fields))
        elif cards:
            own = cards[-1].fields
            own += [""] * (-len(own) % len(fields)) + fields
        else:
            raise InputError(f"{path}: {line.strip()[:40]!r} continues no card; expected one before it; write it again")
    return cards, names, is_rounded


def _included(line: str, rest: Iterator[str]) -> tuple[str, str]:
    """Return a line, or the file that it includes."""
    if not re.match(r"\s*INCLUDE\b", line, re.IGNORECASE):
        return line or " ", ""
    named = line.strip()[7:].strip(" =")
    while named[:1] in ("'", '"') and named.count(named[0]) < 2 and (more := next(rest, None)) is not None:
        named += more.strip()  # a long name goes on in the next line
    return "", named.partition("$")[0].strip(" '\"")


def _bulk(lines: list[str]) -> list[str]:
    """Return the lines of bulk data: behind BEGIN BULK, or all of a file that has none, up to ENDDATA."""
    begin = next((k for k, line in enumerate(lines) if re.match(r"\s*BEGIN[\s,]*BULK", line, re.IGNORECASE)), None)
    control = [k for k, line in enumerate(lines) if re.match(r"\s*CEND\b", line, re.IGNORECASE)]
    first = begin if begin is not None else control[0] if control else -1
    end = next((k for k, line in enumerate(lines) if k > first and re.match(r"\s*ENDDATA", line, re.IGNORECASE)), None)
    return [line for line in lines[first + 1 : end] if line.strip()]


def _fields(line: str) -> tuple[str, list[str]]:
    """Return the name of a line's card, "" where it continues one, and its eight or four fields."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        width = 4 if words[0].endswith("*") or words[0].startswith("*") else 8
    else:
        line = line.expandtabs(SMALL)
        head, width = line[:SMALL], 4 if "*" in line[:SMALL] else 8
        size = LARGE if width == 4 else SMALL
        words = [head.strip(), *(line[SMALL + size * k : SMALL + size * (k + 1)].strip() for k in range(width))]
    name, fields = words[0].upper().rstrip("* "), words[1 : width + 1]
    return "" if not name or name[0] in "+*" else name, fields + [""] * (width - len(fields))

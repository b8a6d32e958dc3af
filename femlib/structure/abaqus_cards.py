"""Cards of an Abaqus or CalculiX deck, with those of included files in their place, and what its elements are."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from femlib.structure.deck_lines import lines_of

KINDS = {
    "quad": r"S4|S4R|S4RS|S4RSW|S4R5|S4T|S4RT|CPS4[RI]?|M3D4R?",
    "triangle": r"S3|S3R|S3RS|S3T|S3RT|STRI3|US3|CPS3|M3D3",
    "quad8": r"S8|S8R|S8R5|S8RT|CPS8R?|M3D8R?",
    "quad9": r"S9R5|M3D9R?",
    "triangle6": r"STRI65|S6|CPS6M?|M3D6",
    "line": r"B[23][13](H|R|OSH?)?|T[23]D2[HT]?|PIPE[23]1H?|U1|FRAME[23]D",
    "line3": r"B[23]2(H|R|OSH?)?|T[23]D3[HT]?|PIPE[23]2H?",
}
"""Kind of an element, as meshio names it, by Abaqus's and CalculiX's types; sources: Abaqus Keywords Guide (2016),
Elements index; CalculiX CrunchiX USER'S MANUAL 2.20, section 6.2."""
BY_MESHIO = {
    "CAX4P": "quad",
    "R3D3": "triangle",
    "S8R5": "quad8",
    "S9R5": "quad9",
    "CPE6": "triangle6",
    "B33H": "line3",
}
"""Kind of an element in a deck that meshio 5.3.5 wrote, which names shells after other elements."""
APART = {
    "MASS": "masses", "ROTARYI": "rotary inertias", "SPRING[12A]": "springs", "DASHPOT[12A]": "dampers",
    "GAPUNI|GAP.*|DCOUP3D|CONN[23]D2|ITT.*": "joints", "R3D[34]|R2D2|RB[23]D2|RAX2": "rigid elements",
    "SFM3D.*": "surfaces without stiffness", "HEATCAP": "heat capacities",
}  # fmt: skip
"""What is no shell and no line, by its type: it is left out and said; its nodes bear the name of its set."""
WIDTHS = {"quad": 4, "triangle": 3, "quad8": 8, "quad9": 9, "triangle6": 6, "line": 2, "line3": 3}
WORDS = ("GENERATE", "INTERNAL", "UNSORTED", "COMPOSITE")
"""Options without a value that may stand first in a keyword's second line."""
COMMA = r',(?=(?:[^"]*"[^"]*")*[^"]*$)'
"""A comma that stands in no quoted name."""
MIDDLE = {"line3": (0, 2, 1)}
"""Places of the ends and of the middle in a row of the deck, where the middle does not stand last."""


@dataclass(frozen=True, slots=True)
class Card:
    """One keyword with its data.

    Attributes
    ----------
    keyword : str
        In capitals, without the star, one blank between its words.
    options : mapping
        Values by option in capitals; "" where an option has none.
    rows : tuple of tuple of str
        Data lines, split at commas.
    """

    keyword: str
    options: Mapping[str, str]
    rows: tuple[tuple[str, ...], ...]


def kind_of(element_type: str, is_by_meshio: bool) -> tuple[str, str]:
    """Return the kind of an element type and, where it is left out of a mesh, what it is; "" for the other."""
    own = element_type.upper()
    if is_by_meshio and own in BY_MESHIO:
        return BY_MESHIO[own], ""
    kind = next((name for name, types in KINDS.items() if re.fullmatch(types, own)), "")
    return kind, "" if kind else next((words for types, words in APART.items() if re.fullmatch(types, own)), "")


def cards_of(path: Path) -> list[Card]:
    """Return the cards of a deck and of the files that it includes.

    Raises
    ------
    InputError
        If a file cannot be read or is no text, or files include each other.
    """
    cards: list[tuple[str, dict[str, str], list[tuple[str, ...]]]] = []
    is_open = False
    for line in lines_of(path, "abaqus", _included):
        parts = re.split(COMMA, line) if '"' in line else line.split(",")
        words = tuple(part.replace('"', "").strip() for part in parts)
        is_open = is_open and not line.startswith("*") and ("=" in line or words[0].upper() in WORDS)
        if line.startswith("*"):
            cards.append((" ".join(words[0][1:].upper().split()), {}, []))
        if line.startswith("*") or is_open:
            pairs = (word.partition("=") for word in words[0 if is_open else 1 :] if word)
            cards[-1][1].update({k.strip().upper(): v.strip() for k, _, v in pairs})
            is_open = not words[-1]  # a comma at its end: the next line has more options
        elif cards:
            cards[-1][2].append(words)
    return [Card(keyword, options, tuple(rows)) for keyword, options, rows in cards]


def _included(line: str, rest: Iterator[str]) -> tuple[str, str]:
    """Return a line that is no comment, and the file that it names: *NODE and others may name one beside *INCLUDE."""
    line = line.strip()
    if line.startswith("**"):
        return "", ""
    named = re.search(r"^\*.*[,\s]INPUT\s*=\s*\"?([^,\"]+)", line, re.IGNORECASE)
    is_only_that = re.match(r"\*\s*INCLUDE\b", line, re.IGNORECASE)
    return "" if is_only_that else line, named[1].strip() if named else ""

"""The words of a tree for readers: numbers, names, and each split as a question that is answered by yes or no."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from octmip.formats.columns import Columns, Feature
from octmip.input.names import shortened, shown
from octmip.interfaces.report.tree.letters import is_whole
from octmip.trees.nodes.digits import grouped
from octmip.trees.nodes.tree import HyperplaneSplit, Split

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS, TIMES, DASH = "\u2212", "\u00d7", "\u2013"
DIGITS, MOST_DIGITS = 6, 12
LONGEST_NAME = 80
"""Characters of a name on the page; the tree in words has it whole."""
ROOM = 208
"""Longest line of a box [px]."""
Card = tuple[Any, ...]
"""A key figure: its name, the figure, words below it, and its style where it has one."""


def figure(value: float | None, digits: int = DIGITS) -> str:
    """Return a number for readers: so many digits at most, thousands apart, powers of ten as such, a dash for none."""
    if value is None or not math.isfinite(value):
        return DASH
    if value == 0:
        return "0"
    size = abs(value)
    if 1e-4 <= size < 1e15:
        whole = round(value)
        is_whole = value == whole or size >= 10**digits
        text = f"{whole:,}" if is_whole else _without_exponent(value, digits)
        return text.replace("-", MINUS)
    return _power(value, digits)


def compact(value: float, largest: float = 1e9) -> str:
    """Return a number for a narrow place: of the `largest` or more four digits and a power of ten, without a break."""
    return figure(value) if not math.isfinite(value) or abs(value) < largest else _power(value, 4).replace(" ", "")


def _power(value: float, digits: int) -> str:
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    short = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"{short} {TIMES} 10{str(int(exponent)).translate(SUPERSCRIPT)}".replace("-", MINUS)


def _without_exponent(value: float, digits: int) -> str:
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:,.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def number(value: float) -> str:
    """Return a number that decides, to its last digit: thousands apart, powers of ten as such."""
    mantissa, _, exponent = grouped(value).partition("e")
    power = f" {TIMES} 10{str(int(exponent)).translate(SUPERSCRIPT)}" if exponent else ""
    return f"{mantissa}{power}".replace("-", MINUS)


def answered(value: float) -> str:
    """Return the number of a leaf, whole to twelve digits, which prices are; a longer one, as means are, is cut."""
    text = number(value)
    return text if sum(character.isdigit() for character in text) <= MOST_DIGITS else f"≈ {figure(value, DIGITS + 3)}"


def differs(value: float) -> str:
    """Return a difference of two trees as a cell of a table."""
    return "nothing" if value == 0 else f"{figure(value, 4)}" if value > 0 else f"{figure(value, 4)} (better)"


def percent(share: float) -> str:
    """Return a share as percent, to a tenth where it is 1 % or more; a dash where there is none."""
    value = 100 * share
    if not math.isfinite(value):
        return DASH
    return f"{figure(round(value, 1), 4) if value >= 1 else figure(value, 2)} %"


def counted(value: int, noun: str, nouns: str = "") -> str:
    """Return a number with its noun: 1 error, 2 errors, 1,000 samples."""
    return f"{value:,} {noun if value == 1 else nouns or noun + 's'}"


def listed(words: Sequence[str], most: int = 8) -> str:
    """Return words in a sentence: a, b and c; those beyond `most` are counted."""
    kept = list(words) if len(words) <= most else [*words[: most - 1], f"{len(words) - most + 1} more"]
    return kept[0] if len(kept) == 1 else f"{', '.join(kept[:-1])} and {kept[-1]}" if kept else "nothing"


def short_name(name: object, longest: int = LONGEST_NAME, among: Iterable[object] = ()) -> str:
    """Return a name as it stands in a sentence; a very long one is cut so that it is none of the others `among` it."""
    text = str(name)
    if len(text) <= longest:
        return shown(text)
    return shown(shortened([*map(str, among), text], lambda part: len(part) <= longest)[text])


def short_names(names: Iterable[object], longest: int = 40) -> list[str]:
    """Return names for the cells of one table, very long ones cut so that they stay different."""
    texts = [str(name) for name in names]
    found = shortened(texts, lambda text: len(text) <= longest)
    return [shown(found[text]) for text in texts]


def _fits(text: str, line: str, written: Callable[[str], str]) -> bool:
    return len(text) <= LONGEST_NAME and is_whole(written(line.format(shown(text))), ROOM)


@lru_cache(maxsize=64)
def _boxed_names(names: tuple[str, ...], line: str, written: Callable[[str], str]) -> dict[str, str]:
    return shortened(names, lambda text: _fits(text, line, written))


@dataclass(frozen=True, slots=True)
class Wording:
    """Names that the words of a tree are made of.

    Attributes
    ----------
    features, classes
        names of the problem.
    columns
        how columns of the table became the features; None where every feature is its column.
    units
        of the columns' values, by column.
    written
        a line of a drawing as its target can write it.
    """

    features: Sequence[str]
    classes: Sequence[Any]
    columns: Columns | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    written: Callable[[str], str] = str

    def short(self, name: object) -> str:
        """Return a name of a column, class or text in a sentence, apart from all others."""
        return shown(name) if len(str(name)) <= LONGEST_NAME else short_name(name, LONGEST_NAME, self._names())

    def boxed(self, name: object, line: str = "{}") -> str:
        """Return a line of a box about a name of a column, class or text, which is cut where it is too long for two."""
        text = str(name)
        if not _fits(text, line, self.written):
            text = _boxed_names((*self._names(), text), line, self.written)[text]
        return line.format(shown(text))

    def _names(self) -> list[str]:
        columns = () if self.columns is None else self.columns.columns
        texts = [text for column in columns for text in (column.name, *column.values)]
        return [*texts, *map(str, self.features), *map(str, self.classes)]

    def feature(self, index: int) -> Feature:
        """Return a feature: what it reads of which column."""
        if self.columns is not None:
            return self.columns.features[index]
        return Feature(self.features[index], self.features[index], "number")

    def number(self, item: Feature, value: float) -> str:
        """Return a number that a feature is compared with: a date of a column of dates, else with the unit."""
        column = None if self.columns is None else self.columns.column_of(item)
        if column is not None and column.form:
            return column.number_text(value, number)
        return number(value) + self.unit(item.column)

    def unit(self, column: str) -> str:
        """Return the unit of a column behind a number, its blank included; nothing where none is known."""
        return f" {shown(self.units[column])}" if self.units.get(column) else ""


@dataclass(frozen=True, slots=True)
class Question:
    """A split as a question.

    Attributes
    ----------
    lines
        of the drawing: what is read, and the comparison.
    text
        the question on one line, without a question mark.
    yes_is_left
        whether "yes" means the left side.
    """

    lines: tuple[str, ...]
    text: str
    yes_is_left: bool = True


def question(split: Split | HyperplaneSplit, wording: Wording) -> Question:
    """Return the question that a split asks.

    A value of a text column is asked for as such, "colour is red", though yes then means right.
    """
    if isinstance(split, HyperplaneSplit):
        return _weighted(split, wording)
    item = wording.feature(split.feature)
    name, short = wording.boxed(item.column), wording.short(item.column)
    if wording.columns is None or item.kind == "number":
        if split.threshold is None:
            words = f"is {'' if split.missing == 'left' else 'not '}missing"
            return Question((name, f"{words}?"), f"{short} {words}")
        or_missing = " or missing" if split.missing == "left" else ""
        cut = f"≤ {wording.number(item, split.threshold)}{or_missing}"
        return Question((name, f"{cut}?"), f"{short} {cut}")
    if item.kind == "is-missing":
        return Question((name, "is missing?"), f"{short} is missing", False)
    if item.kind == "is":
        asked = (name, wording.boxed(item.value, "is {}?"))
        return Question(asked, f"{short} is {wording.short(item.value)}", False)
    words = wording.columns.left_words(split, number)
    rest = words.removeprefix(item.column).strip().replace("<=", "≤")
    if wording.unit(item.column) and "≤" in rest:
        cut, _, missing = rest.partition(" or missing")
        rest = f"{cut}{wording.unit(item.column)}{' or missing' if ' or missing' in rest and not missing else ''}"
    return Question((name, f"{shown(rest)}?"), f"{short} {shown(rest)}")


def _weighted(split: HyperplaneSplit, wording: Wording) -> Question:
    terms: list[tuple[str, str, str]] = []
    for feature, coefficient in zip(split.features, split.coefficients, strict=True):
        sign = f"{MINUS} " if coefficient < 0 else "+ " if terms else ""
        size = "" if abs(coefficient) == 1 else f"{number(abs(coefficient))} "
        terms.append((sign, size, wording.features[feature]))
    cut = f"≤ {number(split.offset)}"
    lines = [wording.boxed(name, f"{sign}{size}{{}}") for sign, size, name in terms]
    words = " ".join(f"{sign}{size}{wording.short(name)}" for sign, size, name in terms)
    return Question((*lines, f"{cut}?"), f"{words} {cut}")

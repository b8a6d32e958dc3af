"""One column of a table, and the features that a tree reads from it.

A number is one feature, NaN where a cell is missing: every split of a tree says where such a cell goes, and nothing is
imputed (docs/theory/missing.md). For trees whose splits have no sides, which regression trees are and all were up to
version 2 of the tree file, a number with missing cells is two complete features (`is_doubled`). The first places
missing cells below every number, the second above, so a cut `x <= t` of the first sends missing cells left and of the
second right; a cut below the least number asks whether the cell is missing.

A text is one yes/no feature (1: yes) for each of its values, or for each set of them, or, where it has an order, its
rank. A set and the rest of the values part the rows alike, so sets without the first value are enough: 2^(n-1) - 1.

Source: Twala, Jones & Hand (2008), "Good methods for coping with missing data in decision trees".
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from functools import lru_cache
from itertools import combinations
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.columns.cells import Cells, Stored
from octmip.formats.columns.instants import cut_between, date_text, duration_text
from octmip.formats.columns.spellings import DAYS
from octmip.formats.columns.written import FORMS, is_date
from octmip.input.cells import text_by_number
from octmip.input.checked import Choice, ListOf, Number, Record, Text, Truth
from octmip.input.messages import shown
from octmip.trees.nodes.digits import exact
from octmip.trees.nodes.tree import Leaf, Split

FeatureKind = Literal["number", "missing-left", "missing-right", "is", "is-missing", "among", "order"]
MOST_LEVELS = 12
"""Different texts of a column, missing cells one of them, of which every set is a feature."""

CONTENT = Record(
    {
        "column": Text(),
        "kind": Choice(("number", "values", "subsets", "order", "empty")),
        "has_missing": Truth(),
        "least": Number(),
        "most": Number(),
        "values": ListOf(Text()),
        "is_doubled": Truth(),
        "form": Text(pattern=FORMS, meaning="a form of numbers"),
        "zone": Text(pattern=r"^[-+A-Za-z0-9_/:]{0,40}$", meaning="a time zone"),
        "stored": Choice(("numbers", "texts", "truths")),
    },
    closed=True,
)
"""A column in a file."""


@dataclass(frozen=True, slots=True)
class Feature:
    """A number that a tree reads from a column: the cell itself, its rank, or the answer to a yes/no question."""

    name: str
    column: str
    kind: FeatureKind
    value: str = ""
    members: tuple[str | None, ...] = ()
    """The texts that go to the side of yes, None a missing cell, where sets are asked for."""


@lru_cache(maxsize=256)
def _sets(column: str, levels: tuple[str | None, ...]) -> tuple[Feature, ...]:
    """Return a feature for each set of levels that lacks the first, small sets first."""
    members = [chosen for size in range(1, len(levels)) for chosen in combinations(levels[1:], size)]
    return tuple(Feature(f"{column} in {set_words(one)}", column, "among", members=one) for one in members)


def set_words(levels: Iterable[str | None]) -> str:
    """Return a set of texts in braces, missing cells by that word."""
    return "{" + ", ".join("missing" if level is None else level for level in levels) + "}"


@dataclass(frozen=True, slots=True)
class Column:
    """How the cells of one column become features.

    Attributes
    ----------
    name
        of the column.
    kind
        "number", "values" (text, one yes/no feature per value), "subsets" (text, one per set of values), "order"
        (text, its rank) or "empty" (no value in training: one constant, whatever it holds later).
    has_missing
        whether a cell was missing in training; where none was, a missing cell is refused later.
    least, most
        the numbers' range in training; 0 and 0 for text.
    values
        the texts seen in training, in their order; none for numbers.
    is_doubled
        whether missing cells are numbers below and above all others, in two features.
    form
        how its numbers are written (`octmip.formats.columns.written`), "" for plain numbers and texts.
    zone
        of the clock that dates were read from (`octmip.formats.columns.instants.date_text`).
    stored
        what its cells are in the table: a database asks each of them in another way.
    """

    name: str
    kind: Literal["number", "values", "subsets", "order", "empty"]
    has_missing: bool
    least: float = 0.0
    most: float = 0.0
    values: tuple[str, ...] = ()
    is_doubled: bool = False
    form: str = ""
    zone: str = ""
    stored: Stored = "numbers"

    @property
    def lacks_numbers(self) -> bool:
        """Whether its feature is NaN where a cell is missing."""
        return self.has_missing and self.kind in ("number", "order") and not self.is_doubled

    @property
    def asks_texts(self) -> bool:
        """Whether its features are yes/no questions, which a missing cell answers too."""
        return self.kind in ("values", "subsets")

    @property
    def _levels(self) -> tuple[str | None, ...]:
        return (*self.values, None) if self.has_missing else self.values

    @property
    def features(self) -> tuple[Feature, ...]:
        """The features in the order of the columns of `encode`."""
        if self.kind == "values":
            return self._questions()
        if self.kind == "subsets":
            return _sets(self.name, self._levels)
        plain: FeatureKind = "order" if self.kind == "order" else "number"
        if not self.is_doubled:
            return (Feature(self.name, self.name, plain),)
        return (
            Feature(f"{self.name} (missing below)", self.name, "missing-left"),
            Feature(f"{self.name} (missing above)", self.name, "missing-right"),
        )

    def _questions(self) -> tuple[Feature, ...]:
        asked = self.values[1:] if len(self.values) == 2 and not self.has_missing else self.values
        found = tuple(Feature(f"{self.name} is {value}", self.name, "is", value) for value in asked)
        return (*found, Feature(f"{self.name} is missing", self.name, "is-missing")) if self.has_missing else found

    @property
    def beyond(self) -> tuple[float, float]:
        """The numbers that stand for a missing cell, one below the range of the others and one above it."""
        least, most = self._range
        step = most - least or max(1.0, abs(least))
        below, above = least - step, most + step
        if not (-math.inf < below < least and most < above < math.inf):
            raise DataError(
                f"has missing cells and numbers from {least:g} to {most:g}, beyond which "
                "float64 has no room for them; divide the column by a constant"
            )
        return below, above

    @property
    def _range(self) -> tuple[float, float]:
        return (self.least, self.most) if self.kind == "number" else (0.0, len(self.values) - 1.0)

    def encode(self, cells: Cells, *, takes_missing: bool = False) -> NDArray[np.float64]:
        """Return the features of some cells, shape (n_rows, len(features)), NaN where one is missing.

        A missing text is a level like others where training had one, and NaN in every feature where it had none. With
        `takes_missing` a text without a place in the order of training is missing too.

        Raises
        ------
        DataError
            a text has no place in the order of training; the sentence begins behind the name of the column.
        """
        if self.asks_texts:
            words = self.words_of(cells)
            answers = self._answers(words) if self.kind == "values" else self._memberships(words)
            if not self.has_missing:
                answers[np.array([word is None for word in words.tolist()], dtype=bool)] = math.nan
            return answers
        numbers = cells.numbers if self.kind == "number" else self._ranks(self.words_of(cells), takes_missing)
        if not self.is_doubled:
            return numbers[:, None]
        is_missing, (below, above), (least, most) = np.isnan(numbers), self.beyond, self._range
        # No cut lies between the ends of the range and what stands for missing but that which asks "is it missing?":
        # a number outside the training's range counts as its end, and stays on its side of every cut.
        left, right = np.maximum(numbers, least), np.minimum(numbers, most)
        return np.column_stack((np.where(is_missing, below, left), np.where(is_missing, above, right)))

    def _answers(self, words: NDArray[Any]) -> NDArray[np.float64]:
        """Return the answers of some texts (n_rows, n_features); one that training had not is none of its values."""
        is_value = [words == (None if item.kind == "is-missing" else item.value) for item in self.features]
        return np.column_stack(is_value).astype(np.float64)

    def _memberships(self, words: NDArray[Any]) -> NDArray[np.float64]:
        """Return the answers of some texts (n_rows, n_features); one that training had not is in no set."""
        place = {level: k for k, level in enumerate(self._levels)}
        answers = np.zeros((len(place) + 1, len(self.features)))
        for j, feature in enumerate(self.features):
            answers[[place[member] for member in feature.members], j] = 1.0
        return np.asarray(answers[[place.get(word, len(place)) for word in words.tolist()]])

    def words_of(self, cells: Cells) -> NDArray[Any]:
        """Return the texts of some cells, (n_rows,); numbers, true and false by the text of training that says them."""
        if cells.is_text:
            return cells.words
        text = text_by_number(self.values, are_truths=cells.stored == "truths")
        numbers = [None if math.isnan(number) else number for number in cells.numbers.tolist()]
        return np.array([number if number is None else text.get(number, f"{number:g}") for number in numbers], object)

    def _ranks(self, words: NDArray[Any], takes_missing: bool) -> NDArray[np.float64]:
        rank = {value: float(k) for k, value in enumerate(self.values)} | {None: math.nan}
        unseen = next((word for word in words if word not in rank), None)
        if unseen is not None and not takes_missing:
            raise DataError(
                f"holds {shown(unseen)}, which has no place in the order of training; train with it, or without the "
                "order (categories 'yes-no')"
            )
        return np.array([rank.get(word, math.nan) for word in words], dtype=np.float64)

    def number_text(self, value: float, number: Callable[[float], str] = exact) -> str:
        """Return a number of the column as people write it: a date, a duration, with its sign or unit."""
        if is_date(self.form):
            return date_text(value, self.zone)
        sign = self.form[7:]
        return duration_text(value) if self.form == DAYS else f"{number(value)}{' ' * sign[:1].isalpha()}{sign}"

    def cut_between(self, low: float, high: float) -> float | None:
        """Return the date or duration of fewest fields between two neighbours; None for other numbers."""
        return cut_between(low, high, self.zone) if is_date(self.form) or self.form == DAYS else None

    def left_words(self, feature: Feature, split: Split, number: Callable[[float], str] = exact) -> str:
        """Return what holds for the cells that a split of one of its features sends left."""
        threshold = split.threshold
        if threshold is None:
            return f"{self.name} is {'' if split.missing == 'left' else 'not '}missing"
        if feature.kind == "is":
            if len(self.values) == 2 and not self.has_missing:
                return f"{self.name} is {self.values[0]}"
            return f"{self.name} is not {feature.value}"
        if feature.kind == "is-missing":
            return f"{self.name} is not missing"
        if feature.kind == "among":
            rest = [level for level in self._levels if level not in feature.members]
            is_short = len(rest) <= len(feature.members)
            return (
                f"{self.name} in {set_words(rest)}" if is_short else f"{self.name} not in {set_words(feature.members)}"
            )
        least, most = self._range
        if feature.kind == "missing-left" and threshold < least:
            return f"{self.name} is missing"
        if feature.kind == "missing-right" and threshold >= most:
            return f"{self.name} is not missing"
        cut = (
            f"{self.name} <= {self.number_text(threshold, number)}"
            if self.kind == "number"
            else self._rank_words(threshold)
        )
        is_left = feature.kind == "missing-left" or (split.missing == "left" and not self.is_doubled)
        return f"{cut} or missing" if is_left else cut

    def questions(self) -> dict[str, str]:
        """Return the names of its yes/no features by the words of a tree that splits them, or of the other set."""
        found = {}
        for feature in self.features if self.asks_texts else ():
            found[self.left_words(feature, Split(0, 0.5, Leaf(0), Leaf(0)))] = feature.name
            if feature.kind == "among":
                rest = set_words([level for level in self._levels if level not in feature.members])
                found |= dict.fromkeys((f"{self.name} in {rest}", f"{self.name} not in {rest}"), feature.name)
        return found

    def _rank_words(self, threshold: float) -> str:
        left = self.values[: max(0, math.floor(threshold) + 1)]
        return f"{self.name} is {' or '.join(left)}" if len(left) <= 3 else f"{self.name} is {left[-1]} or before it"

    def to_json(self) -> dict[str, Any]:
        """Return the column as a JSON object."""
        content = asdict(self)
        return {"column": content.pop("name"), **content, "values": list(self.values)}

    @classmethod
    def from_json(cls, content: object) -> Self:
        """Return the column of a JSON object.

        Raises
        ------
        DataError
            it is none.
        """
        taken = CONTENT.take(content)
        if len(set(taken["values"])) != len(taken["values"]) or taken["least"] > taken["most"]:
            raise DataError(f"column {shown(taken['column'])} names a value twice, or its range ends before it begins")
        if taken["form"] and taken["kind"] != "number":
            raise DataError(f"column {shown(taken['column'])}: texts have no form of numbers; write the file anew")
        if (taken["kind"] in ("number", "empty")) == bool(taken["values"]):
            raise DataError(f"column {shown(taken['column'])}: texts have values, numbers none; write the file anew")
        if taken["kind"] == "subsets" and len(taken["values"]) + taken["has_missing"] > MOST_LEVELS:
            raise DataError(f"column {shown(taken['column'])}: sets are made of {MOST_LEVELS} texts at most")
        return cls(taken.pop("column"), **{**taken, "values": tuple(taken["values"])})

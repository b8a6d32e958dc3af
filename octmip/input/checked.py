"""Values of files: the one way to take a number, a name, a list or an object, and its JSON Schema from the same words.

A kind says what a value must be. `Kind.take` returns the value as that kind, or raises a `MisfitError` that knows
where in the file it stands; `Kind.schema` returns the same demand in the words of JSON Schema (draft 2020-12), so that
the two cannot disagree. As there, 3.0 is a whole number, and true is neither a number nor a whole one.
"""

import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from octmip.errors import DataError
from octmip.input.messages import MOST_NAME, place, shown

MOST = sys.float_info.max
MOST_WHOLE = 2**63 - 1

Schema = dict[str, Any]


class MisfitError(DataError):
    """A value that is not what it must be, and the way to it from the outermost value of the file."""

    def __init__(self, sentence: str, path: tuple[str | int, ...] = ()) -> None:
        super().__init__(f"{place(path)} {sentence}")
        self.sentence, self.path = sentence, path

    def inside(self, step: str | int) -> "MisfitError":
        """Return the same misfit seen from one value further out."""
        return MisfitError(self.sentence, (step, *self.path))


class Kind(Protocol):
    """The kind that a value must have."""

    @property
    def words(self) -> str:
        """The expected value, in a few words."""
        ...

    def take(self, value: Any) -> Any:
        """Return the value; raise `MisfitError` if it is of another kind."""
        ...

    def schema(self) -> Schema:
        """Return the JSON Schema of the kind."""
        ...


def _refused(value: object, expected: str) -> MisfitError:
    return MisfitError(f"is {shown(value)}; expected {expected}")


@dataclass(frozen=True, slots=True)
class Number:
    """A finite number from `low` to `high`, returned as float."""

    low: float = -MOST
    high: float = MOST

    @property
    def words(self) -> str:
        """The expected value."""
        ends = [f"of {self.low:g} or more"] if self.low > -MOST else []
        ends += [f"of {self.high:g} at most"] if self.high < MOST else []
        return " ".join(["a finite number", *ends])

    def take(self, value: Any) -> float:
        """Return the number."""
        if type(value) in (int, float) and self.low <= value <= self.high:
            return float(value)
        raise _refused(value, self.words)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"type": "number", "minimum": self.low, "maximum": self.high}


@dataclass(frozen=True, slots=True)
class Whole:
    """A whole number from `low` to `high`."""

    low: int = 0
    high: int = MOST_WHOLE

    @property
    def words(self) -> str:
        """The expected value."""
        return f"a whole number from {self.low} to {self.high}"

    def take(self, value: Any) -> int:
        """Return the number."""
        is_whole = type(value) is int or (type(value) is float and value.is_integer())
        if is_whole and self.low <= value <= self.high:
            return int(value)
        raise _refused(value, self.words)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"type": "integer", "minimum": self.low, "maximum": self.high}


@dataclass(frozen=True, slots=True)
class Text:
    """A text of at most `MOST_NAME` characters, of a pattern where one is given."""

    pattern: str = ""
    meaning: str = "a text"

    @property
    def words(self) -> str:
        """The expected value."""
        return f"{self.meaning} of at most {MOST_NAME} characters"

    def take(self, value: Any) -> str:
        """Return the text."""
        if type(value) is str and len(value) <= MOST_NAME and re.search(self.pattern, value):
            return value
        raise _refused(value, self.words)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"type": "string", "maxLength": MOST_NAME} | ({"pattern": self.pattern} if self.pattern else {})


@dataclass(frozen=True, slots=True)
class Truth:
    """True or false."""

    words: str = "true or false"

    def take(self, value: Any) -> bool:
        """Return the truth value."""
        if type(value) is bool:
            return value
        raise _refused(value, self.words)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"type": "boolean"}


@dataclass(frozen=True, slots=True)
class Choice:
    """One of a few texts."""

    choices: tuple[str, ...]

    @property
    def words(self) -> str:
        """The expected value."""
        return "one of " + ", ".join(repr(choice) for choice in self.choices)

    def take(self, value: Any) -> str:
        """Return the text."""
        if type(value) is str and value in self.choices:
            return value
        raise _refused(value, self.words)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"enum": list(self.choices)}


@dataclass(frozen=True, slots=True)
class Either:
    """A value of any of several kinds that no value can mistake for one another."""

    kinds: tuple[Kind, ...]

    @property
    def words(self) -> str:
        """The expected value."""
        return " or ".join(kind.words for kind in self.kinds)

    def take(self, value: Any) -> Any:
        """Return the value as the first kind that takes it."""
        for kind in self.kinds:
            try:
                return kind.take(value)
            except MisfitError as misfit:
                if misfit.path:  # of this kind outside, and wrong further in: that is what to report
                    raise
        raise _refused(value, self.words)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"anyOf": [kind.schema() for kind in self.kinds]}


@dataclass(frozen=True, slots=True)
class Nothing:
    """Null."""

    words: str = "null"

    def take(self, value: Any) -> None:
        """Return None."""
        if value is not None:
            raise _refused(value, self.words)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"type": "null"}


def maybe(kind: Kind) -> Either:
    """Return the kind that may be null, too."""
    return Either((kind, Nothing()))


@dataclass(frozen=True, slots=True)
class Anything:
    """Any value."""

    words: str = "anything"

    def take(self, value: Any) -> Any:
        """Return the value."""
        return value

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {}


@dataclass(frozen=True, slots=True)
class AsItIs:
    """A value of a kind, returned as it stands: 20 and 20.0 are one number, but two names."""

    kind: Kind

    @property
    def words(self) -> str:
        """The expected value."""
        return self.kind.words

    def take(self, value: Any) -> Any:
        """Return the value."""
        self.kind.take(value)
        return value

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return self.kind.schema()


@dataclass(frozen=True, slots=True)
class ListOf:
    """A list of values of one kind, at least `least`."""

    kind: Kind
    least: int = 0

    @property
    def words(self) -> str:
        """The expected value."""
        return f"a list of at least {self.least}" if self.least else "a list"

    def take(self, value: Any) -> list[Any]:
        """Return the list."""
        if type(value) is not list or len(value) < self.least:
            raise _refused(value, self.words)
        taken: list[Any] = []
        try:
            for entry in value:
                taken.append(self.kind.take(entry))
        except MisfitError as misfit:
            raise misfit.inside(len(taken)) from None
        return taken

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"type": "array", "items": self.kind.schema(), "minItems": self.least}


@dataclass(frozen=True, slots=True)
class MapOf:
    """An object of any names with values of one kind."""

    kind: Kind
    words: str = "an object"

    def take(self, value: Any) -> dict[str, Any]:
        """Return the object."""
        if type(value) is not dict:
            raise _refused(value, self.words)
        return {_name(name): _entry(self.kind, value, name) for name in value}

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        names = {"maxLength": MOST_NAME}
        return {"type": "object", "propertyNames": names, "additionalProperties": self.kind.schema()}


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """An object with these entries; others are left alone, or refused where it is `closed`."""

    entries: Mapping[str, Kind]
    closed: bool = False

    @property
    def words(self) -> str:
        """The expected value."""
        return f"an object with {', '.join(self.entries)}"

    def take(self, value: Any) -> dict[str, Any]:
        """Return the entries that it must have."""
        if type(value) is not dict:
            raise _refused(value, self.words)
        for name in self.entries:
            if name not in value:
                raise MisfitError(f"lacks the entry {name!r}; expected {self.words}")
        unknown = [name for name in value if name not in self.entries] if self.closed else []
        if unknown:
            raise MisfitError(f"has the entry {shown(unknown[0])}; expected {self.words}")
        return {name: _entry(kind, value, name) for name, kind in self.entries.items()}

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        properties = {name: kind.schema() for name, kind in self.entries.items()}
        found: Schema = {"type": "object", "properties": properties, "required": list(self.entries)}
        return found | ({"additionalProperties": False} if self.closed else {})


def _name(name: str) -> str:
    if len(name) > MOST_NAME:
        raise MisfitError(f"has an entry with a name of {len(name)} characters; expected {MOST_NAME} at most")
    return name


def _entry(kind: Kind, content: dict[str, Any], name: str) -> Any:
    try:
        return kind.take(content[name])
    except MisfitError as misfit:
        raise misfit.inside(name) from None

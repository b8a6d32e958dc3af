"""Kinds of values: what they take, what they refuse and where, and that their JSON Schema says the same."""

import math

import jsonschema
import pytest

from octmip.input.checked import (
    Anything,
    AsItIs,
    Choice,
    Either,
    ListOf,
    MapOf,
    MisfitError,
    Number,
    Record,
    Text,
    Truth,
    Whole,
    maybe,
)
from octmip.input.messages import several, shown

VALUES = [
    *(0, 1, -1, 2**63 - 1, 2**63, 10**29, 10**400, 0.0, -0.0, 1.0, 0.5, 1e308, 5e-324, math.inf, -math.inf, math.nan),
    *(True, False, None, "", "a", "a" * 1000, "a" * 1001, "b" * 64, [], [1], [1, 2.5], ["a"], [[]], {}, {"a": 1}),
    *({"a": 1, "b": 2}, {"a": "x"}, {"a" * 1001: 1}, {"b": 1}, [None], [True], [[1.0]]),
]
KINDS = [
    Number(),
    Number(low=0.0),
    Whole(),
    Whole(1, 30),
    Text(),
    Text("^b{64}$", "letters"),
    Truth(),
    Choice(("a", "b")),
    maybe(Number()),
    AsItIs(Either((Text(), Truth(), Number()))),
    Anything(),
    ListOf(Number()),
    ListOf(ListOf(Number(), 1), 1),
    MapOf(Whole()),
    Record({"a": Whole()}),
    Record({"a": Number()}, closed=True),
]


def refusal(kind, value):
    """Return what a kind says of a value that it does not take, None where it takes the value."""
    try:
        kind.take(value)
    except MisfitError as misfit:
        return str(misfit)
    return None


@pytest.mark.parametrize("kind", KINDS, ids=repr)
def test_a_kind_takes_exactly_what_its_schema_allows(kind):
    validator = jsonschema.Draft202012Validator(kind.schema())
    for value in VALUES:
        sentence = refusal(kind, value)
        if sentence is not None:
            assert "expected" in sentence
            assert len(sentence) < 1000
            assert "\n" not in sentence
        if not (isinstance(value, float) and math.isnan(value)):  # no JSON number, and refused where it is read
            assert (sentence is None) == validator.is_valid(value), value


def test_numbers_come_back_as_what_they_are():
    assert isinstance(Number().take(3), float)
    assert isinstance(Whole().take(3.0), int)
    assert isinstance(AsItIs(Number()).take(20), int)


@pytest.mark.parametrize(
    ("kind", "value", "sentence"),
    [
        (Record({"a": ListOf(Number())}), {"a": [1, [2]]}, r"^a\[1\] is a list of 1; expected a finite number$"),
        (Record({"a": MapOf(Truth())}), {"a": {"x\x1b": 1}}, r"^a\.'x\\x1b' is 1; expected true or false$"),
        (Record({"a": Truth()}), {}, "^the content lacks the entry 'a'; expected an object with a$"),
        (ListOf(Truth(), 2), [True], "^the content is a list of 1; expected a list of at least 2$"),
        (maybe(ListOf(Truth())), [1], r"^\[0\] is 1; expected true or false$"),
        (maybe(Truth()), 1, "^the content is 1; expected true or false or null$"),
        (Whole(1, 30), 10**400, "more than 60 digits; expected a whole number from 1 to 30"),
    ],
)
def test_a_misfit_says_where_it_stands_what_was_got_and_what_expected(kind, value, sentence):
    with pytest.raises(MisfitError, match=sentence):
        kind.take(value)


def test_what_is_shown_is_short_and_harmless():
    assert shown("a\x1b[2J\n\u202e") == r"'a\x1b[2J\n\u202e'"
    assert len(shown("a" * 10**6)) < 80
    assert shown("µ") == "'µ'"
    assert several(range(20)).endswith("11, ...")
    assert several(["a"]) == "'a'"

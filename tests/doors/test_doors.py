"""What comes in and goes out holds for files, models and engines that others made: one table, a row an input.

Each module of `TABLES` has the rows of one door. A row's input is made by the program that it names. Two promises hold
for all of them: the input is read, or refused in one sentence, and what is read gives the right answer.
"""

import importlib
from pathlib import Path

import pytest

from femlib.errors import FemlibError
from octmip.errors import OctmipError
from tests.doors.row import Refused, Row

TABLES: tuple[str, ...] = (
    "arrays",
    "campaigns",
    "class_orders",
    "class_weights",
    "decks",
    "exports",
    "frames",
    "large_integers",
    "later_tables",
    "models",
    "texts",
)
ROWS: list[Row] = [row for name in TABLES for row in importlib.import_module(f"tests.doors.{name}").ROWS]
MOST_CHARACTERS = 600
"""The longest sentence of a refusal: a person reads it in a terminal."""


@pytest.mark.parametrize("row", ROWS, ids=str)
def test_an_input_of_another_program_is_read_rightly_or_refused_in_one_sentence(row: Row, tmp_path: Path) -> None:
    source = row.make(tmp_path)
    answer = row.answer(source) if callable(row.answer) else row.answer
    if not isinstance(answer, Refused):
        assert row.ask(source) == answer
        return
    with pytest.raises((OctmipError, FemlibError)) as refused:
        row.ask(source)
    sentence = str(refused.value)
    assert len(sentence) <= MOST_CHARACTERS
    assert "\n" not in sentence
    assert [word for word in answer.words if word not in sentence] == []


def test_no_two_rows_are_the_same() -> None:
    assert len({str(row) for row in ROWS}) == len(ROWS)
